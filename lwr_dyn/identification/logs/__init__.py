"""Logs of a moving arm: read, checked, written, and taken from simulated runs.

joint_log       JointLog, read with units, refused with row and column
column_files    columns of numbers in CSV and Parquet files
log_columns     names and units of columns
column_map      what a file calls its columns
log_checks      what a log may not hold
ros_bags        messages of ROS 2 bags
bag_columns     columns from a bag, topics of unequal rates on one clock
clock           how far rows miss an even grid; the log on an even one
motor_side      positions and currents of motors -> positions and torques of joints
repeated        the same rows given twice
recordings      pieces without a gap in time
simulated_logs  constant-velocity runs of a simulated arm, LogSensors for noise and rounding
"""
