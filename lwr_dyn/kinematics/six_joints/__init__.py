"""Closed forms of six-joint arms, reached through the registry of solvers.

exact_arms       Six-joint arms with a closed form that is theirs as it stands: its text, and one pose solved by it,
                 fast
snapped_arms     Further six-joint arms: rounded or calibrated numbers, three parallel axes, and what the package EAIK
                 solves
spherical_wrist  Closed-form inverse kinematics of six-joint arms with a spherical wrist: eight branches for each
                 pose, in batches
"""
