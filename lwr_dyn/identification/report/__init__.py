"""The report of an identification as one HTML page.

- `motion_report`: the page of a fit to any motion, and what its figures draw
- `arm_stage`: the motion in 3D, with the ellipsoids of the links
- `charts`: measured and predicted torques, what is left; friction over speed
"""
