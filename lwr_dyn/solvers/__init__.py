"""Inverse kinematics by other packages, as rows of the registry of solvers; each result is verified by ours.

eaik_solver  EAIK: six-joint arms by subproblems, compiled
"""
