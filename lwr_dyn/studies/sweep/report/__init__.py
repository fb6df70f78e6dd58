"""The report of a study as one HTML page.

report_page          the report as one HTML file
distribution_charts  histograms, and the shares of the worst runs
influence_charts     tornado, Sobol indices, how far each parameter goes before a limit breaks
parallel_lines       runs as lines over all parameters
worst_runs           the worst runs with their parameters; their replay inside the page
"""
