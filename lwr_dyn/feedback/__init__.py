"""Control laws beyond the paper, one a file: they join the registry of controllers.

wrapped                what is put around a controller
momentum_observer      MomentumObserver: the external torque from those of the motors
collision_threshold    levels that the estimate passes only in a collision
observed               Observed: a momentum observer beside any controller
friction_compensation  friction of the reference's or the measured velocity added to any law
"""
