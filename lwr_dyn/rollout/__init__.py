"""Rollouts: whole closed loops of many runs at once, in one kernel generated for arm and law, reduced on the way.

rollouts           `rollouts`, the front door
result             `Rollouts`: metrics of all runs, and each run again by `simulate`
symbolic_model     an arm's dynamics on symbols, of plant and law
philox             random numbers by counting: those of a run depend on its number alone
philox_code        the same as vector instructions for drivers
sensing            encoder, velocity filter and delay on symbols
counted_encoder    `CountedEncoder`, with which `simulate` repeats the noise of a run
"""
