"""Motion along time and space: profiles, paths, poses along a path, and references for the joints.

cartesian       Cartesian tasks of any arm: lines and waypoint files in space, followed joint position by joint
                position
motion_files    CSV files of poses or joint positions, in SI: waypoints, and motions that a person brings
motion_profile  Motion profiles: a scalar s(t) with its exact derivatives, as polynomials in time from knot to knot
path            A path in space: lines and arcs end to end, with the length travelled as its one parameter, and its
                joints
pose_path       Poses along a path: a path in space, an orientation along it, and a motion profile that says when
references      References for the joints of an arm: moves in joint space, and paths of poses through inverse
                kinematics
timings         How a path in space is travelled in a given time: motion profiles by name, and corners rounded
"""
