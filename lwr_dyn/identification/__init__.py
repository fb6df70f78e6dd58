"""Parameters of an arm from its logs (`lwr-dyn identify`).

logs        recordings: read, checked, simulated
friction    friction per joint and direction from runs at constant speed
regression  base parameters, least squares with covariance
bodies      whether bodies can have estimated parameters
excitation  motions to run and log (`lwr-dyn excite`)
motion      inertial and friction parameters from any motion
payload     the ten parameters of a load in the hand
elastic_joints  springs and dampers of gears, where both encoders are logged
fitted      a fitted arm as a data file or a URDF
command     the subcommands
"""
