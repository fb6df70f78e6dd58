"""The ten inertial parameters of a load in an arm's hand (`lwr-dyn identify payload`).

identify_load  A load in the hand of an arm from a log: ten parameters, beside the friction of the joints or the arm
               as a whole
possible_load  The body that a load can be: nearest to what the torques say, of positive mass everywhere
"""
