"""Studies of many closed loops: what is varied, and what it does to the metrics.

sweep_study        SweepStudy: values of its runs, its digest; its arm, references and controllers
read_study         the study of a TOML file, read strictly
read_parameters    its `[[parameter]]` tables, and whether what varies exists in the arm, the controllers, the task
vocabulary         what can be varied, by path; the metrics of a run, by name
sampling           VariedParameter: how values are distributed; grid, Sobol, Latin hypercube, random, Saltelli
rollout_arguments  values of the paths as keywords of `lwr_dyn.rollouts`, for one controller
running            runs in chunks: threads, processes, a Dask cluster; a folder that a killed sweep goes on from
summary            what a study found, for each controller
intervals          quantiles and shares over runs with their intervals
influence          what each parameter does to a metric: a tornado, Sobol indices
outwards           how far a parameter alone goes before a limit breaks
summary_text       the summary as text, tables and JSON values
report_page        the summary as one HTML file; what comes of a finished sweep: page and worst runs
charts             the charts of that page
gain_search        differential evolution under one bound; what gains are worth on runs not seen
tune               gains for a stated aim, as text and JSON values
"""
