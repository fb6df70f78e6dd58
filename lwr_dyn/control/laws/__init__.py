"""Control laws beyond the paper: they join the registries of controllers and of wrappers.

adaptive               The adaptive law of Slotine and Li: the load's parameters, and friction if asked for, are learnt
                       while tracking
friction_compensation  Friction compensation for any law, and hand guiding, which carries a share of the friction
impedance              Impedance: the arm as springs and dampers along its reference, its own dynamics kept and not
                       cancelled (PD+)
motor_side             PD on the motor side of elastic joints, with feed-forward and torque feedback; and any law on
                       the motor side
observer               Momentum observer beside any controller ("LAW+observer"): the torque of external forces, without
                       accelerations
robust                 The robust law on passivity: a load that is only known to lie in a set is held down by a term of
                       fixed size
"""
