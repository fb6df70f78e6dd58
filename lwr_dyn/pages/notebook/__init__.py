"""Results in a notebook, as files of other programs, and as pictures; the core works without.

forms        arm, run, checks, inverse kinematics, reproduction, identification as small HTML
markup       escaped text, tables
run_formats  a run as .csv, .parquet, .mat
plot         `lwr_dyn.plot`: a picture that any notebook draws
quantities   what can be plotted of a run
"""
