"""Motion along time and space: profiles, paths, poses along a path, and references for the joints.

motion_profile  MotionProfile: s(t) with its derivatives; constant speed, quintic, trapezoids of speed
timings         profiles of a whole path by name; bounded jerk; corners rounded
path            Path: lines and arcs end to end, its corners and bends
csv_rows        rows of CSV files of poses or joint positions, in SI
pose_path       orientations along a path; TimedPosePath
references      references for the joints of an arm, by name
cartesian       lines and waypoints of the tip of any arm
"""
