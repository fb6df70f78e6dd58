"""Cartesian tasks of any arm: lines and waypoint files in space, followed joint position by joint position.

legs      Legs one after another: through the space of the tip, or through joint positions, each with its time
tasks     The tasks `line` and `waypoints`: from the command's options to a reference for the joints of any arm
tracking  Joint positions of any arm along a curve of poses, each found from the one before: no start is drawn at
          random
"""
