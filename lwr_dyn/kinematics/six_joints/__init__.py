"""Closed forms of six-joint arms, reached through the registry of solvers.

spherical_wrist  six joints with a spherical wrist: geometry, all branches, in batches
snapped_arms     three parallel axes; rounded or calibrated numbers, polished on the arm; the package EAIK
"""
