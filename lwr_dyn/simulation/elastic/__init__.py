"""Arms with elastic joints: a spring and a damper between the motor side and the link side of every gear.

run          run_elastic: a sampled run, its record and its audit, with Radau IIA 5 for events and as second road
plant        ElasticPlant: 2n coordinates (q, theta); the reduced model of Spong, and the full one with spinning rotors
exponential  HeldExponential: one step under a held torque, of any stiffness; what the loop of rigid joints needs
"""
