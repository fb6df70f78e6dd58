"""Checks of an arm: each gives a verdict, a value against a tolerance.

model_laws  What holds for every arm, as verdicts: feasible links, and identities of the equations of motion over random
            states
run_checks  All checks of one arm and their report: frames, feasibility, identities, the two roads, energy, data sheet
"""
