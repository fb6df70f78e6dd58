"""Equations of motion and DH matrices in SymPy.

arm_equations       `equations_of_motion` of some joints of an arm, with the numbers of its symbols
lagrangian          `EquationsOfMotion` of a chain of symbolic links, derived from the Lagrangian
compiled_equations  the equations as an engine for any masses, lengths and gravity
equation_text       the equations as plain text and LaTeX
entry_text          one entry of B, C or g, derived alone
link_motion         velocities and accelerations of the links
trigonometry        normal form and short form of trigonometric expressions
dh_matrices         the matrices of a DH table, and positions by two routes
verdicts            the equations against Pinocchio
"""
