"""Inertial and friction parameters from any motion (`lwr-dyn identify motion`).

motion_fit     identify_motion
motion_tables  the result as text and record
"""
