"""Linear regression on the torques of an arm.

coupled_motors  Motors that turn several joints, in logs of the joints: whether rotors and friction are theirs
drive_gains     Unknown gains of the torques: logs whose torques are currents times a drive gain that is known to some
                per cent
information     What logs say of the base parameters: weighted least squares with the noise of every joint, and what
                they leave open
instrumental    Instrumental variables for logs without a filter: columns of the motion that was commanded stand in
                for noisy ones
joints_alone    Rotors and friction of motors that turn several joints, as numbers of the joints
least_squares   Linear least squares: base parameters, normal equations by their eigenvectors, weighted and robust
                estimates
load_friction   Friction that grows with the torque that a gear carries: a share of it, beside Coulomb and viscous
                friction
samples         Instants of logs as the regression takes them: states from positions alone, torques as they were
                measured
stribeck        Stribeck speeds: the one nonlinear parameter of friction, by a bounded search with all others linear
torque_columns  Torques of an arm as columns times parameters: bodies of one geometry, rotor and friction of each
                joint
"""
