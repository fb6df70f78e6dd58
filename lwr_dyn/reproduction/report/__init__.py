"""A report as one HTML file that loads nothing.

- `content`: the records that a page shows, from `Page` down to `ReportCell`.
- `page`: `write_report`, `report_html`.
- `layout`, `blocks`, `printed_tables`, `markup`: the HTML, from the whole page to one element.
- `run_figures`: figures of runs: errors, torques, path.
- `script_data`: runs and figures for the scripts beside this file.
"""
