"""Arm to URDF and back, with a trail from every number to its cell."""
