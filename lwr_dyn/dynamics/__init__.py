"""Rigid-body dynamics of an arm by two roads: Pinocchio on the URDF, and Newton-Euler on the source's frames.

protocol          `Dynamics`: what every engine offers; `UngatedDynamics` for loops; `Gated`: the shape gate
engines           `dynamics_of`, and the registry of engines
pinocchio_engine  road A; the only module that imports Pinocchio
newton_euler      road B: B, C, g and U from the recursion
recursion         the Newton-Euler recursion, for numbers and symbols
regressor         torques as a linear function of the inertial parameters; those that a source may leave open
symbolic          equations of motion and DH matrices in letters
"""
