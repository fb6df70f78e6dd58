"""Rigid-body dynamics of an arm by two roads: Pinocchio on the URDF, and Newton-Euler on the source's frames.

engines           The engines of an arm's dynamics, by name
newton_euler      Road B: B, C and g from the recursion, as in the LWR 4+ paper
pinocchio_engine  Road A: the only module that imports Pinocchio. The model is built from the URDF text; rotors enter
                  as `armature`
protocol          What an engine of rigid-body dynamics offers: `Dynamics` behind the shape gate, `UngatedDynamics`
                  for loops
recursion         Road B: the paper's Newton-Euler recursion, by hand, on the native chain
regressor         Regressor of an arm: joint torques are linear in the ten inertial parameters of every link
seen_inertia      The inertia seen at a joint, B_ii(q), for many states at once
symbolic          Equations of motion and DH matrices in SymPy
"""
