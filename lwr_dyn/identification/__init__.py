"""Parameters of an arm from its logs (`lwr-dyn identify`).

logs            recordings: read, put on an even clock, taken from motors or simulated
regression      torques as columns times parameters, base parameters, least squares with covariance
friction        friction per joint and direction from runs at constant speed
bodies          bodies that have estimated parameters, near a table; proofs that none have
log_faults      columns of the wrong sign, order or unit; cut torques, joints that never move
excitation      motions to run and log (`lwr-dyn excite`)
motion          inertial and friction parameters from any motion
payload         the ten parameters of a load in the hand
elastic_joints  springs and dampers of gears, where both encoders are logged
slips           a table against logs: repairs that explain the difference
fitted          a fitted arm as a data file or a URDF
report          the result as one HTML file
"""
