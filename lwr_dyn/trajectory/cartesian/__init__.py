"""Cartesian tasks of any arm: lines and waypoint files in space, followed joint position by joint position.

pose_curves  poses along a leg, straight or through points; the CSV file of waypoints
tracking     joint positions along such a curve, each from the one before, and where and why it stops
legs         legs one after another, a smooth function through their positions, and its timing
tasks        the rows `line` and `waypoints` of the registry of references
"""
