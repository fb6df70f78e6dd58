"""Kinematics of an arm: poses, Jacobians, inverse kinematics, arm angle.

forward       poses, joint axes, geometric Jacobian and its rate
arm_geometry  the geometry of S-R-S arms, read off their axes
inverse       `inverse_kinematics` of one pose, the registry of its solvers, and the numeric one for any arm
solution      the problem, the solvers' interface, `InverseResult`
srs           S-R-S arms in closed form; `follow`: joint motion along a path with its exact derivatives
srs_margins   their joint-limit margins over the arm angle, and the best angle of a pose
arm_angle     a smooth arm angle along a path that maximises the joint-limit margin
pose_solver   `ik_solver`: one solution of a pose, fast
pose_search   its search on Pinocchio
six_joints    closed forms of six joints
"""
