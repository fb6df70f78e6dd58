"""The same task under all readings of a robot: what depends on the reading, and which conclusions hold under all.

analysis      `sensitivity` -> `Sensitivity`, its tables and its document
closed_loops  runs of every model on every plant; gravity torques and gains; propositions
study_tasks   the tasks that papers set, and the reference that an arm follows in one
"""
