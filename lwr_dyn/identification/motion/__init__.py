"""Inertial and friction parameters from any motion (`lwr-dyn identify motion`).

- `motion_fit`: identify_motion: samples, base parameters, bodies, validation
- `motion_result`: MotionRule, how parameters are taken; MotionIdentification, what was found, as a document
- `identifiable`: identified or not, known only together, from the log or the table; swings that would identify more
- `validation`: what is left of torques that a fit did not see; whether residuals are white
"""
