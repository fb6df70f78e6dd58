"""More solvers of inverse kinematics, reached through the registry of solvers.

spherical_wrist six joints with a spherical wrist: all branches, in batches
six_joint_*     geometry of six joints; their solutions: whole turns, singularities
three_parallel  six joints with three parallel axes (Universal Robots): the closed form
snapped_arms    six joints with rounded or calibrated numbers: the nearest closed form, polished on the arm
command         `lwr-dyn ik`
nearest_point   for a pose out of reach
eaik_solver     the package EAIK: six-joint arms by subproblems, compiled
"""
