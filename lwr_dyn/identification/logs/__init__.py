"""Logs of a moving arm: read, checked, written, and taken from simulated runs.

joint_log       JointLog: read with units, refused with row and column, written; rows that are given twice
log_columns     names and units of columns, what a file calls them, recordings without a gap in time
ros_bags        ROS 2 bags: topics of unequal rates on one clock
clock           how far rows miss an even grid; the log on an even one
motor_side      positions and currents of motors -> positions and torques of joints
simulated_logs  constant-velocity runs of a simulated arm, LogSensors for noise and rounding
"""
