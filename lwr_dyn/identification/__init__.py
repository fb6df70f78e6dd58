"""Parameters of an arm from its logs (`lwr-dyn identify`).

bodies          Bodies that have the estimated parameters, or a proof that none do
elastic_joints  Springs, dampers, rotors, friction and links from logs with the encoders of both sides of the gears
excitation      Motions that excite the parameters of an arm (`lwr-dyn excite`)
fitted          The values of a fit with their standard errors, and the arm with them
fitted_files    A fitted arm as a model that every command takes (`lwr-dyn identify motion ... --out`): a data file,
                or a URDF
friction        Friction per joint and direction from runs at constant speed (`lwr-dyn identify friction`)
log_digests     Logs that a fit used by their digests, which a written model keeps
log_faults      Faults of logs, recognised and named; logs made ready for a regression
logs            Logs of a moving arm: read, checked, written, and taken from simulated runs
motion          Inertial and friction parameters from any motion (`lwr-dyn identify motion`)
payload         The ten inertial parameters of a load in an arm's hand (`lwr-dyn identify payload`)
ranking         Published sets of one robot, ranked on a log of the real one (`lwr-dyn rank`)
regression      Linear regression on the torques of an arm
report          The report of an identification as one HTML page
slips           Slips of a table, traced by a log
"""
