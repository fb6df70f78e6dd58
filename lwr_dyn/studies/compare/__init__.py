"""Runs side by side: `lwr_dyn.compare`, and `lwr-dyn compare` with its page.

comparison    `RunComparison`: the table of the runs, its records, its figures, its page
compared_run  one of its runs: what it is compared by, and a run from a time on
plants        what a controller can be confronted with: payload, other masses, friction, ...
study         controllers x plants, simulated, in several processes if wanted
pair_page     any two of the runs replayed side by side, chosen from lists
"""
