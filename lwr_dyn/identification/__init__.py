"""Parameters of an arm from its logs (`lwr-dyn identify`).

logs        recordings: read, checked, simulated
friction    friction per joint and direction from runs at constant speed
regression  base parameters, least squares with covariance
bodies      whether bodies can have estimated parameters
motion      inertial and friction parameters from any motion
command     the subcommands
"""
