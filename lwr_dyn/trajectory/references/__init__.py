"""References for the joints of an arm: moves in joint space, and paths of poses through inverse kinematics.

tasks                REFERENCES: references by name
joint_moves          JointReference: point to point, LSPB moves, standing still
pose_path_reference  PosePathReference: a timed pose path with an arm angle
ist                  the path IST of the LWR 4+ paper
arm_angles           the arm angle along a path
limits               largest violation of the position limits, smallest margin
"""
