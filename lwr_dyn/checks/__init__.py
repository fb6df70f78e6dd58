"""Checks of published tables and of robots' files; each finding has its place and its reason.

arm          Checks of an arm: each gives a verdict, a value against a tolerance
conventions  The conventions of a table that states none: every reading, ranked, and what decides it
datasheet    An arm against the data sheet of its maker
engines      What engines make of a model file, measured by loading it: Pinocchio, MuJoCo, Drake, PyBullet, yourdfpy
origin       Whose numbers a model file has: which published set, traced by digits
sensitivity  The same task under all readings of a robot: what depends on the reading, and which conclusions hold
             under all
tables       Faults in tables of numbers that need no model to be seen
urdf         Faults in URDF files: each link, joint and shape as written, with its place, the reason and what to write
             instead
"""
