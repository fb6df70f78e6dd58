"""Studies of many closed loops: what is varied, and what it does to the metrics.

study       the file of a study, what varies, how its runs are drawn, the arguments of rollouts
running     runs in chunks: threads, processes, a Dask cluster; a folder that a killed sweep goes on from
statistics  what the runs say, with intervals
report      one HTML file
tuning      gains for a stated aim
command     `lwr-dyn sweep`
finished    figures, page and worst runs of a sweep
"""
