"""What people see in a browser or a notebook: replay, pictures, results.

document  a `foundation.document.Document` as a page and in a notebook
markup    HTML from records
still     `arm_still`: a picture of an arm, and of a run's path
replay    meshcat, and runs as one file
figures   what is drawn of runs
plotting  figures drawn by Matplotlib and as HTML
notebook  how results show themselves; `lwr_dyn.plot`
explorer  `lwr_dyn.show`
"""
