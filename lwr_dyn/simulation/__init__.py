"""Closed loops in time: plant, friction, stops, sensors, integrators, the audit, and figures of merit.

simulate      simulate, run_setup, free_swing: a closed loop as a Run; the registry of loops
setup         Loop, what closes a loop; Setup and prepare: a simulation whose options are all checked
plant         Plant, the arm that is simulated; ExternalTorque on its links; Encoder, what the controller sees
arm_friction  ArmFriction: set-valued friction with true stick, and its smooth forms; boxed_lcp behind it
contact       ContactMode, impact, resolve_stick_slip: which joints rest, slip or meet a stop, and what ends that
flow          Flow: one interval with every event in it; FastStep: the usual step without events
integrators   RK4 and DOP853
loops         the sampled and the continuous loop; Log and run_of: from the loop to the Run
audit         audit: energy against the work of the channels; other_road: the motion by the other engine
metrics       metrics: errors, torques and speeds against their limits, stops and for how long joints leaned on them
elastic       arms with elastic joints
environment   walls and pushes: external torques
responses     what a loop made of a step and of chirps
"""
