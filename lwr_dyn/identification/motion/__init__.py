"""Inertial and friction parameters from any motion (`lwr-dyn identify motion`).

motion_fit        identify_motion: samples, base parameters, bodies, validation
motion_pieces     which motions are kept from a fit
validation        what is left of torques that a fit did not see
residuals         what a fit leaves, and whether it is white
parameter_states  identified or not, known only together, from the log or the table
missing_motions   swings that would identify what is not
motion_tables     the result as text
motion_record     the result as a record
"""
