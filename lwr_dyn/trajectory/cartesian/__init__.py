"""Cartesian tasks of any arm: lines and waypoint files in space, followed joint position by joint position.

- `pose_curves`: poses along a leg, straight or through points;
- `tracking`: joint positions along such a curve, each from the one before, and where and why it stops;
- `stops`: `PathStopError`, the reason in words;
- `legs`, `arm_angle_legs`: legs one after another, of an S-R-S arm at its best arm angle;
- `joint_curves`: a smooth function through these positions, and its timing;
- `waypoint_file`: the CSV file of waypoints;
- `tasks`: the rows `line` and `waypoints` of the registry of references.
"""
