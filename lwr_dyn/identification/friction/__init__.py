"""Friction per joint and direction from runs at constant speed (`lwr-dyn identify friction`).

friction_map       stretches of constant speed, one FrictionPoint each; what the arm's model takes out of its torques
direction_fit      Coulomb, viscous and Stribeck friction of one direction
identify_friction  identify_friction: all joints of all logs, as figure, text and record
"""
