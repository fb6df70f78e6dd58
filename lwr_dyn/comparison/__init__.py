"""Runs side by side: `lwr_dyn.compare`, and `lwr-dyn compare` with its page.

comparison  `RunComparison`: the table of the runs, its records, its figures
conditions  what of a run's plant its controller does not know; which runs can be compared
plants      what a controller can be confronted with: payload, other masses, friction, ...
study       controllers x plants, simulated
page        one HTML file; its charts
command     `lwr-dyn compare`
"""
