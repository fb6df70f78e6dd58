"""Checks of an arm: each gives a verdict, a value against a tolerance.

run_checks          `check_arm`: all of them
model_laws          feasible links; identities of the equations of motion
symbolic_agreement  symbolic equations against Pinocchio
verdict             `Verdict`, `CheckReport` and their table
"""
