"""Controllers in the form that a kernel takes.

protocol             `LawForm`, what a kernel needs of a controller, and `LawInputs`, what it gives it
forms                `law_form`: the form of a controller, out of `LAW_FORMS`
check                whether a controller acts as its form
joint_forms          PD with gravity, PID, inverse dynamics, PD on the motor side
passivity_forms      adaptive and robust, on two_velocities: the torque of Slotine and Li on symbols
friction_forms       friction compensation around a law
"""
