"""Checks of published tables and of robots' files; each finding has its place and its reason.

arm          verdicts on one arm: identities, agreement of the roads, feasibility
datasheet    an arm against its maker's data sheet
urdf         faults in URDF files
tables       faults in tables of numbers that show without a model
conventions  the conventions under which a table can be read
sensitivity  one task under all readings of a robot
engines      what other engines make of a model file
"""
