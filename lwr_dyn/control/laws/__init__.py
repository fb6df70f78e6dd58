"""Control laws beyond the paper: they join the registries of controllers and of wrappers.

impedance              joints, or the tip in space, as springs and dampers; the feed-forward that cancels nothing (PD+)
motor_side             PD on the motor side of elastic joints, with torque feedback; any law on the motor side
adaptive               Slotine and Li: the load, or all links, and friction are learnt; their regressor
robust                 passivity-based: a load out of a set is held down by a term of fixed size
friction_compensation  friction of the reference's or the measured velocity added to any law; hand guiding
observer               a momentum observer beside any controller: the external torque from those of the motors
collision_threshold    levels that the estimate passes only in a collision
"""
