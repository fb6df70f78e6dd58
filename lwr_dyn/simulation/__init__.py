"""Closed loops in time: plant, friction, stops, sensors, integrators, the audit, and figures of merit.

simulate      simulate = run_setup(prepare(...)): the closed loop as a Run
setup         Setup, prepare: a simulation whose options are all checked
options       SimulationOptions, and the checks of reference, start and friction
plant         Plant: the arm that is simulated
external      ExternalTorque: what acts on the links from outside, such as walls and pushes
arm_friction  ArmFriction: set-valued friction with true stick, and its smooth forms
sensors       Encoder
loops         the sampled and the continuous loop
flow          Flow: one interval with every event in it
fast_step     FastStep: the usual step without events
contact       ContactMode, impact, resolve_stick_slip: which joints rest, slip, or meet a stop
boxed_lcp     boxed_lcp: the complementarity problem behind all three
events        what may end a contact mode, and when
integrators   RK4 and DOP853
record        Log, run_of: from the loop to the Run
audit         audit: the change of energy against the work of the channels, and the verdicts in words
other_road    other_road: the motion against the torques by the engine that did not compute it
metrics       metrics: errors, and torques and speeds against their limits
stop_contacts StopContacts: joints that met their position stops, and for how long they leaned on them
swing         free_swing: the arm without torque
"""
