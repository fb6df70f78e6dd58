"""Studies of many closed loops: what is varied, and what it does to the metrics.

study_file           SweepStudy: a study as a record: values of its runs, its digest
read_study           the study of a TOML file, read strictly
task_fields, parameter_fields, study_fields   the tables of the file
parameter_checks     whether what varies exists in the arm, the controllers, the task
nominal_values       what a parameter is as modelled
study_setup          arm, references and controllers of a study
plant_rows           values of the paths as parameters of the plants
rollout_arguments    values of the paths as keywords of `lwr_dyn.rollouts`, for one controller
new_study            `lwr-dyn new study`
parameter_paths      what can be varied, by path: unit, words, bounds, how many draws
distributions        VariedParameter: a path and how its values are distributed
sampling             the points of the unit cube: grid, Sobol, Latin hypercube, random, Saltelli
metric_table         the metrics of a run by name: unit, words, which side is bad
command              `lwr-dyn sweep`
sweep                sweep: every chunk that is missing, made and written
finished             figures, page and worst runs of a sweep
workshop             SweepWorkshop: a study in one thread, its runs in rows
simulated_rows       runs of a controller without a kernel form, by `simulate`
cost                 what a sweep will cost, measured on its first runs
manifest             what made results: study, kernels, versions; results of two makers are never mixed
sweep_folder         the folder of a sweep: files written whole or not at all, one writer, what a kill left is cleared
chunk_file           the runs of a chunk as a Parquet file
results              SweepResults: a folder as arrays
tasks, processes     chunks by threads, and by processes that may die
cluster              chunks on a Dask cluster
controller_runs      ControllerRuns: the runs of one controller as columns
metric_words         a metric for people, and which values are bad
intervals            quantiles by order statistics, shares by Clopper and Pearson
influence            what each parameter does where all vary: the numbers of a tornado
outwards             which parameter alone breaks a limit first
sobol_indices        Sobol indices of a Saltelli design
tune                 gains for a stated aim, found on some runs, judged on others
gain_aim, gain_box   what a search of gains aims at, and between which bounds it walks
bounded_search       differential evolution under one bound, and the Pareto front of what it looked at
gain_verdict         gains beside the given ones, on runs that the search has not seen
summary              SweepSummary: what the runs of all controllers say
summary_words        its numbers as texts, with intervals
summary_tables       its tables for the terminal, its record for --json
report_page          the report as one HTML file
distribution_charts  histograms, and the shares of the worst runs
influence_charts     tornado, Sobol indices, how far each parameter goes before a limit breaks
parallel_lines       runs as lines over all parameters
worst_runs           the worst runs with their parameters; their replay inside the page
"""
