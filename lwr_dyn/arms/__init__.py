"""Arms from names and files, and arms as files.

export   Any arm as a DH table, as a data file and as MJCF, the same motion and torque to rounding; a run as a ROS 2 bag
loading  From a name or a file to an arm, on its mount and with its tool; what a run records of that finds it again
papers   Data files: one TOML file per paper or data sheet, read strictly, corrected by errata, turned into an Arm
urdf     Arm to URDF and SRDF with the source of every number, and foreign URDFs back to Arm
"""
