"""Many closed loops side by side.

compare  Runs side by side: `lwr_dyn.compare`, and `lwr-dyn compare` with its page
sweep    Studies of many closed loops: what is varied, and what it does to the metrics
"""
