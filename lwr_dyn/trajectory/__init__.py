"""Motion along time and space, without an arm: motion profiles, paths, orientations, poses along a path.

motion_profile  MotionProfile: s(t) with its derivatives; constant speed, quintic
lspb            profiles with a trapezoid of speed
double_s        profiles with bounded jerk
timings         MOTION_PROFILES: profiles of a whole path by name
segments        straight lines and circular arcs
path            Path: segments end to end, its corners and bends
blends          corners and bends rounded by quintics
pose_path       orientations along a path; TimedPosePath
references      the above as references for the joints of an arm
"""
