"""A report as one HTML file that loads nothing and can be read without a script.

- `content`: the records that a page shows, from `Page` down to `ReportCell`.
- `page`: `write_report`, `report_html`; `layout`: the whole page; `markup`: one element.
- `number_map`, `number_tables`: every number as a square, and as a line with its residual and its origin.
- `figure_html`, `plane`: a figure as HTML and SVG.
- `run_table`, `still_image`: the runs in numbers, and the 3D view as a picture before it starts.
- `blocks`: errata, checks, sections, files.
- `script_data`: runs and figures for the scripts beside this file (3D view, cursors, zoom).
"""
