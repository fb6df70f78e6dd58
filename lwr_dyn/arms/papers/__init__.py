"""Data files: one TOML file per paper or data sheet, read strictly, corrected by errata, turned into an Arm.

catalog       robots, readings, open_paper: robots by name; the template of a new arm
reader        parse_paper: TOML text to a Paper, the errata of its reading applied
schema        tables, columns and units of a file; Paper, Column, Erratum, Reading
columns       one row per joint, with unit and source
plausibility  signs, order and symmetry of the numbers
solids        drawn cylinders, and the bodies estimated from them
assembly      arm_from_paper: Paper to Arm, with rotors, motor map, gains and friction
"""
