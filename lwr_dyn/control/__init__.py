"""Controllers, their gains, and the worst-case inertia that the gains are computed from.

protocol     Controller, WithMemory: the interface that a simulation expects; Wrapped: what stands around a controller
controllers  CONTROLLERS, make_controller: controllers by name, from a user's Python file, or from the texts of a study
paper_laws   PDGravity, PID, InverseDynamics, on arrays and on symbols
gains        gains of a second-order loop, damping by modes, and a controller near rest as matrices
velocity     FilteredDifference: velocity from an encoder
laws         laws beyond the paper
inertia      the largest inertia seen at a joint, proven
"""
