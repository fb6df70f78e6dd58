"""Faults of logs, recognised and named; logs made ready for a regression.

found_faults   log_faults, prepared_logs; cut or silent torques, still joints, torques in the wrong unit
column_trials  signs, order and units of columns, by what the arm can explain
"""
