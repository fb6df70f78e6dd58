"""What the runs of a study say: quantiles, shares and indices with their intervals, what breaks a limit.

controller_runs  ControllerRuns: the runs of one controller as columns
metric_words     a metric for people, and which values are bad
intervals        quantiles by order statistics, shares by Clopper and Pearson
influence        what each parameter does where all vary: the numbers of a tornado
outwards         which parameter alone breaks a limit first
sobol_indices    Sobol indices of a Saltelli design
summary          SweepSummary: what the runs of all controllers say
summary_words    its numbers as texts, with intervals
summary_tables   its tables for the terminal, its record for --json
"""
