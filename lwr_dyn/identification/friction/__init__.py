"""Friction per joint and direction from runs at constant speed (`lwr-dyn identify friction`).

cruise             stretches of constant speed
friction_map       one FrictionPoint a stretch
direction_fit      Coulomb, viscous and Stribeck friction of one direction
identify_friction  identify_friction: all joints of all logs
torque_model       gravity and inertia by the recursion, taken out of measured torques
passivity          speeds at which friction adds energy
passive_refit      the nearest friction that does not
friction_tables    the result as text and record
"""
