"""Kinematics of an arm: poses, Jacobians, inverse kinematics, arm angle.

arm_angle     A smooth arm angle along a path that maximises the smallest joint-limit margin
arm_geometry  The geometry of arms with a closed form of inverse kinematics, read off their axes at q = 0: S-R-S arms
closed_forms  Closed forms of inverse kinematics, written once in a small part of C, from which every language is
              made
forward       Forward kinematics of the native chain: poses, joint axes, geometric Jacobian and its rate
inverse       Inverse kinematics of one flange pose: every branch in closed form for arms that allow it, else a
              numeric search
pose_solver   One solution for a flange pose, fast: `solve(T, q0)`. All solutions: `kinematics.inverse`
six_joints    Closed forms of six-joint arms, reached through the registry of solvers
solution      Inverse kinematics of one pose: the problem, the solver's interface, the result with its solutions in
              order
solution_rows  Solutions of inverse kinematics as rows of one array; a `Solution` is a row's place, read when asked
srs           Closed-form inverse kinematics of an S-R-S arm for a flange pose, an arm angle psi and one of eight
              branches
srs_margins   Joint-limit margins of an S-R-S arm over the arm angle, and the arm angles at which a margin is kept, in
              closed form
srs_solver    One pose of an S-R-S arm by the text of its closed form, fast, where it is machine code; else by NumPy
"""
