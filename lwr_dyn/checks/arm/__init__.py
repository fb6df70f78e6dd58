"""Checks of an arm: each gives a verdict, a value against a tolerance.

model_laws  What holds for every arm: feasible links, and identities of the equations of motion over random states
run_checks  All checks of one arm: frames, feasibility, identities, agreement of the two roads, energy, data sheet
verdict     The result of one check: quantity, value, tolerance, pass or fail; all results of an arm; their table
"""
