"""Kinematics of an arm: poses, Jacobians, inverse kinematics, arm angle.

forward          poses, joint axes, geometric Jacobian and its rate; the gate for poses
inverse          `inverse_kinematics` of one pose, and the registry of its solvers
solution         the problem, the solvers' interface, `InverseResult`
srs_solver       S-R-S arms: all branches at their best arm angle, or at a given one
numeric          any arm: damped least squares from many starts
srs, srs_margins, branches, arm_geometry
                 closed form, joint-limit margins over the arm angle, and the geometry they start from
arm_angle        a smooth arm angle along a path that maximises the joint-limit margin
arm_angle_search the largest margin that a continuous arm angle can keep
path_following   `follow`: joint motion along a path with its exact derivatives
"""
