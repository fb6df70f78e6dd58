"""Logs of a moving arm: read, checked, written, and taken from simulated runs.

clock           The clock of a log: how far its rows miss an even grid, and the log on an even one
joint_log       Logs of a moving arm: read from CSV files, Parquet files or ROS 2 bags, checked, written, taken from
                simulated runs
log_columns     The columns of a log: what they are called, which units they may declare, and how they become SI
motor_side      Logs of the motors as logs of the joints: positions through the gears, torques from currents
ros_bags        ROS 2 bags (extra `logs`): the `sensor_msgs/JointState` topics of a bag as columns of a log
simulated_logs  Logs of simulated arms: constant-velocity runs out and back, and the noise and rounding of sensors
"""
