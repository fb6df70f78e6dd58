"""Controllers, their gains, and the worst-case inertia that the gains are computed from.

controllers  Controllers by name, from a Python file of one's own, or from the texts of a study
gains        Gains of a second-order loop, the damping of an impedance, and a controller near rest as matrices
inertia      The largest inertia seen at a joint over its box, and the proof that there is none larger
laws         Control laws beyond the paper: they join the registries of controllers and of wrappers
paper_laws   The paper's laws: PD with gravity compensation and PID, joint by joint, and inverse dynamics
protocol     The interface of a controller: it is called with the state and the reference, and returns torques
"""
