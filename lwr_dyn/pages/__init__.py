"""What people see in a browser or a notebook: replay, pictures, results.

- `document`, `markup`: a `foundation.document.Document` as a page and in a notebook; HTML from records
- `replay`: meshcat, and runs as one file
- `figures`, `plotting`: what is drawn of runs; drawn by Matplotlib
- `notebook`: how results show themselves; runs as files of other programs
- `explorer`: `lwr_dyn.show`
"""
