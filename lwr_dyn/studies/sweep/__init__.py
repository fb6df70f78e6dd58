"""Studies of many closed loops: what is varied, and what it does to the metrics.

charts             The charts of a study's page as HTML: how a metric is distributed, what each parameter does, lines
                   of runs
gain_search        A search for gains: differential evolution of SciPy, a whole generation at once, under one bound
influence          How much a metric follows each varied parameter: the numbers of a tornado, and Sobol indices of a
                   Saltelli design
intervals          Confidence intervals that assume nothing of a distribution: of a quantile by order statistics, of a
                   share
outwards           Which parameter breaks a limit first: each alone is moved from its nominal value to the ends of its
                   range
read_parameters    The `[[parameter]]` tables of a study: a path, its distribution, and whether arm, controllers and
                   task have it
read_study         Reads a study's file: TOML, strict; what is wrong is one line with the file and the field
report_page        The report of a study as one HTML file, and what comes of a finished sweep: figures, page, and the
                   worst runs
rollout_arguments  From values of a study's paths to the keywords of `lwr_dyn.rollouts`: plants, and one of its
                   controllers
running            Runs of a study in chunks: on threads, processes or a cluster, killed and resumed, in a folder of
                   results
sampling           What the runs of a study are: points of the unit cube, and from them values by the inverse
                   distribution
study_template     The commented study that `lwr-dyn new study` writes: for the LWR 4+, or fitted to an arm
summary            What a study found: for each controller its quantiles, shares inside the limits, influences, and
                   the worst runs
summary_document   A summary for people and programs: numbers with their intervals, tables, sections of a document and
                   its record
sweep_study        A study: which loops, what is varied, how many runs; and its arm, references and controllers, built
                   when needed
tune               `tune`: gains for a stated aim, found on some runs of a study and judged on others; as text and
                   JSON values
vocabulary         What a study can vary, by path, and the metrics of its runs, by name
"""
