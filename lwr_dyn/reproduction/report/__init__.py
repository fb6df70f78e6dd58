"""A report as one HTML file that loads nothing and can be read without a script.

content      the records that a page shows, from `Page` down to `ReportCell`
page         `write_report`, `report_html`: the whole page, with runs and figures for the scripts beside this file
blocks       every number as a square and as a line with its residual; errata, checks, sections, files
figure_html  a figure as HTML and SVG
still_image  the 3D view as a picture before it starts
"""
