"""Rigid-body dynamics of an arm by two roads: Pinocchio on the URDF, and Newton-Euler on the source's frames.

protocol          `Dynamics`: what every engine offers; `UngatedDynamics` for loops; `mechanical_energy`
engines           `dynamics_of`, and the registry of engines
gate              `Gated`: the shape gate around an engine
pinocchio_engine  road A; the only module that imports Pinocchio
newton_euler      road B: B, C, g and U from the recursion
recursion         the Newton-Euler recursion, for numbers and symbols
regressor         torques as a linear function of the inertial parameters
unknown_inertia   parameters that a source leaves open: refused where a torque depends on them
"""
