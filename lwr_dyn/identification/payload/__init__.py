"""The ten inertial parameters of a load in an arm's hand (`lwr-dyn identify payload`).

identify_load  identify_load: on a known arm, or together with the arm from logs without the load
possible_load  the body that the load can be; as text and record
"""
