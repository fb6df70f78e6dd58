"""Checks of an arm: each gives a verdict, a value against a tolerance.

run_checks   `check_arm`: all checks that the arm's data allow; agreement of the two roads; `CHECKS` of other packages
identities   identities of B, C and g; energy of a free swing; random states
feasibility  inertia of each link
verdict      `Verdict`, `CheckReport` and their table
"""
