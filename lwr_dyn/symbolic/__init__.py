"""Equations of motion by Euler and Lagrange, and DH matrices, in SymPy."""
