"""Tolerances shared by tests, each with its reason."""

EXACT = 1e-12
"""Relative, one model by two roads: a few hundred roundings of 1e-16."""
RANDOM_ARM = 1e-12
"""Relative, arms with random frames, sliding joints and gravity in any direction."""
FULL_ROTOR = 1e-10
"""[N m], torques of tens of N m against a model with twice the bodies and gear ratios of 110 squared."""
METRES = 1e-12
"""[m], poses of an arm about a metre long."""
POSE_SOLVED = 1e-9
"""[m and rad] What `ik_solver` promises; it stops at 0.99e-9, the rest is rounding of the check."""

OBSERVER_SHARE = 1e-3
"""Of the largest true torque: the estimate of a momentum observer against the ideal filter of it at 1 kHz. The change
of the torque within a sample leaves K_O T^2 / 12 times its slope: 0.0008 at K_O = 100 1/s and a push that rises in
20 ms."""
