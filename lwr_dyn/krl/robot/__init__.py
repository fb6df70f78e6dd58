"""The robot as a KUKA controller describes it.

kuka_pose      X, Y, Z, A, B, C, Status and Turn
machine_data   `$machine.dat`, or TOML in its words -> `Arm`
"""
