"""Parameters of an arm from its logs (`lwr-dyn identify`).

logs, log_columns, log_checks: `JointLog`, read from CSV or Parquet with units, refused with row and column
simulated_logs: constant-velocity runs of a simulated arm, `LogSensors` for noise and rounding
cruise, friction_map: stretches of constant speed, and one `FrictionPoint` each
direction_fit, friction: Coulomb, viscous and Stribeck friction per direction (`identify_friction`)
torque_model: gravity and inertia by the recursion, taken out of measured torques
base_parameters, motion_fit: inertial and friction parameters from any motion (`identify_motion`)
possible_bodies: whether no bodies can have the base parameters
passivity, passive_refit: speeds at which friction adds energy; the nearest friction that does not
least_squares: weighted and Huber estimates with covariance
command, command_tables, motion_tables: the subcommand, its tables
"""
