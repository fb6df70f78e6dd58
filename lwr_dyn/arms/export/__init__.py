"""Any arm as a DH table, as a data file and as MJCF, the same motion and torque to rounding; a run as a ROS 2 bag.

data_file    An arm as a data file: a DH table in SI with its bodies, limits, rotors and friction; it loads as the same
             arm
dh_table     The Denavit-Hartenberg table of any serial arm, in either convention, computed from its joint axes
mjcf         Arm -> MJCF text for MuJoCo: frames, bodies, limits and shapes of the URDF, and the armature, which a URDF
             lacks
mjcf_reader  An MJCF as an arm: MuJoCo compiles the file, and its tree of bodies is read as that of a URDF
run_bag      A run as a ROS 2 bag in one file, MCAP: joint states of arm and reference, and the URDF of its arm
"""
