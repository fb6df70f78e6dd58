"""Faults of logs, recognised and named; logs made ready for a regression.

column_trials  Wrong signs, order and units of columns, recognised: the change under which the arm explains the log
found_faults   All faults of logs, and logs made ready for a regression
"""
