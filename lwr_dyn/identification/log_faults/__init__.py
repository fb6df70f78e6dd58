"""Faults of logs, recognised and named; logs made ready for a regression.

found_faults     log_faults, prepared_logs
log_fault        LogFault
column_changes   signs, order and units that may be wrong
column_trials    which of them are, by what the arm can explain
saturation       torques at a bound, cut out
silent_torques   torques that never change
still_joints     joints that never move
torque_scale     torques in the wrong unit
table_spread     how far parameters may be off the table
"""
