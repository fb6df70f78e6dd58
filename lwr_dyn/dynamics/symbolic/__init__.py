"""Equations of motion and DH matrices in SymPy.

arm_equations   Equations of motion of an arm in symbols, from its Lagrangian: a third road beside URDF and recursion
equation_forms  Equations of motion as numbers and as text: compiled to an engine, as plain text, as LaTeX, or one
                entry alone
link_motion     Motion in symbols: DH matrices, velocities and accelerations of the links, and one normal form of
                expressions
"""
