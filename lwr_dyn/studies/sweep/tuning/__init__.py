"""Gains found on rollouts for a stated aim.

tune                gains for a stated aim, found on some runs, judged on others
gain_aim, gain_box  what a search of gains aims at, and between which bounds it walks
bounded_search      differential evolution under one bound, and the Pareto front of what it looked at
gain_verdict        gains beside the given ones, on runs that the search has not seen
command             `lwr-dyn tune`
tune_text           what was found, for the terminal and --json
"""
