"""The same task under all readings of a robot: what depends on the reading, and which conclusions hold under all.

analysis      The same task under all readings of a robot: every controller simulated on every plant, and what
              follows; tables
closed_loops  Every pair of readings in a closed loop, the controller's model one and the plant the other; what a
              paper concludes
study_tasks   The tasks that papers set: a motion, the controllers that follow it, and what the paper concludes from
              it
"""
