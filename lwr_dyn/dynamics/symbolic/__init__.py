"""Equations of motion and DH matrices in SymPy.

arm_equations   `equations_of_motion` of some joints of an arm, derived from the Lagrangian; DH matrices
equation_forms  the equations as an engine, as text and as LaTeX; one entry alone
link_motion     velocities and accelerations of the links; normal form and short form of trigonometric expressions
"""
