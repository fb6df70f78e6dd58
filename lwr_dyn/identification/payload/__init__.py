"""The ten inertial parameters of a load in an arm's hand (`lwr-dyn identify payload`).

load_columns    torques per unit of a load's parameters, about the flange
identify_load   identify_load: on a known arm, or together with the arm from logs without the load
arm_doubt       what errors of the arm's table do to the load
possible_load   the body that the load can be
load_tables     the result as text and record
"""
