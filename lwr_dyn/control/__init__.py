"""Controllers, their gains, and the worst-case inertia that the gains are computed from.

protocol            Controller, WithMemory: the interface that a simulation expects
controllers         CONTROLLERS, make_controller: controllers by name
controller_file     controller_from_file: a controller from a user's Python file
pd_gravity          PDGravity: PD with gravity compensation
pid                 PID with back-calculation against wind-up
inverse_dynamics    InverseDynamics, also called computed torque
gains               second_order_gains, worst_case_gains
linear_feedback     Linearised, LinearFeedback: a controller near rest as matrices
worst_case_inertia  the largest inertia seen at a joint, by a global search
inertia_maxima      maxima of that inertia: along one joint, and local
velocity            FilteredDifference: velocity from an encoder
"""
