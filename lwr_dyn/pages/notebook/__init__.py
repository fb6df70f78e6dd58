"""Results in a notebook; the core works without.

forms  arm, run, checks, inverse kinematics, reproduction, identification as small HTML
plot   `lwr_dyn.plot`: a picture that any notebook draws
"""
