"""Logs of a moving arm: read, checked, written, and taken from simulated runs.

joint_log       JointLog, read from CSV or Parquet with units, refused with row and column
log_columns     names and units of columns
log_checks      what a log may not hold
simulated_logs  constant-velocity runs of a simulated arm, LogSensors for noise and rounding
"""
