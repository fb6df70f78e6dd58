"""References for the joints of an arm: moves in joint space, and paths of poses through inverse kinematics.

references           REFERENCES: references by name; violations of the position limits
joint_moves          JointReference: point to point, LSPB moves, standing still
excitations          steps and chirps
pose_path_reference  PosePathReference: a timed pose path with an arm angle
recorded_motion      a motion from a CSV file
ist                  the path IST of the LWR 4+ paper
"""
