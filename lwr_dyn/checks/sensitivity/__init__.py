"""The same task under all readings of a robot: what depends on the reading, and which conclusions hold under all.

- `analysis`: `sensitivity` -> `Sensitivity`
- `simulated_task`: a study task with the reference that an arm follows
- `statics`, `closed_loops`, `conclusions`: gravity torques and gains; runs of every model on every plant; propositions
- `result_tables`: the tables of a `Sensitivity`
"""
