"""Rollouts: whole closed loops of many runs at once, in one kernel generated for arm and law, reduced on the way.

rollouts           `rollouts`, the front door
result             `Rollouts`: metrics of all runs, and each run again by `simulate`
symbolic_model     an arm's dynamics on symbols, of plant and law
"""
