"""References that people bring (files, steps, chirps), and what a loop made of them.

twice  Twice: a reference twice; part_of: one pass of a run
"""
