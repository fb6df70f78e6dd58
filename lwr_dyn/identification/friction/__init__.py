"""Friction per joint and direction from runs at constant speed (`lwr-dyn identify friction`).

direction_fit      One direction of a friction map -> parameters: viscous and Coulomb by linear least squares,
                   Stribeck by nonlinear
friction_map       The friction-velocity map: one point for every cruise, the averages of velocity and torque over it
identify_friction  Friction of an arm from constant-velocity runs, as the WAM paper identifies it; figure and document
"""
