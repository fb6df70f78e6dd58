"""Data files: one TOML file per paper or data sheet, read strictly, corrected by errata, turned into an Arm.

catalog       robots, readings, open_paper: robots by name; the template of a new arm
reader        parse_paper: TOML text to a Paper
schema        tables, columns and units of a file; Paper, Column, Erratum, Reading
assembly      arm_from_paper: Paper to Arm
actuation     rotors, motor map, gains and friction of a paper
errata        patches of printed cells
columns, fields, plausibility, solids, units    the parts of the reader
"""
