"""Runs side by side: `lwr_dyn.compare`, and `lwr-dyn compare` with its page.

comparison        `RunComparison`: the table of the runs, its records, its figures
compared_run      one of its runs; whether its loop is stable
conditions        what of a run's plant its controller does not know; which runs can be compared
plants            what a controller can be confronted with: payload, other masses, friction, ...
study             controllers x plants, simulated, in several processes if wanted
study_run         one run of a study
tuning            omega_n of every controller for one margin along the task
part_of_run       a run from a time on; fewer samples of it
cross_table       plants down and controllers across, in Markdown
page              one HTML file
pair_page         any two of the runs replayed side by side, chosen from lists
command           `lwr-dyn compare`
"""
