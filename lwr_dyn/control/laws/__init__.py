"""Control laws beyond the paper, one a file: they join the registry of controllers.

adaptive               Slotine and Li: the load, and friction, are learnt while tracking
adapted_parameters     which parameters are adapted, their gains and bounds
slotine_li_regressor   torques with two velocities as a linear function of the parameters
joint_impedance        joints as springs and dampers
cartesian_impedance    the tip as a spring and damper in space, the free joints as another
hand_guiding           weight and friction carried; a hand moves the arm
damping_design         damping from inertia and stiffness, without an inverse of J
moving_equilibrium     the torque that moves a compliant arm along its reference
motor_side_pd          PD on the motor side of elastic joints, with torque feedback
motor_side             any law on the motor side, with the deflection under gravity taken off
robust                 passivity-based: a load out of a set is held down by a term of fixed size
controller_specs       controllers as texts, with options and wrappers
assumed_friction       Coulomb friction as a share of the torque limits
wrapped                what is put around a controller
momentum_observer      MomentumObserver: the external torque from those of the motors
collision_threshold    levels that the estimate passes only in a collision
observed               Observed: a momentum observer beside any controller
observer_figure        its estimate, levels and the truth as a figure
friction_compensation  friction of the reference's or the measured velocity added to any law
"""
