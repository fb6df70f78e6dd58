"""Figures as pictures: PNG and SVG by Matplotlib, and HTML.

drawn_panel  A panel of a figure, ready to draw: its curves as numbers with their colours, and axes that follow the
             data
line_plane   A plane of lines and dots as HTML: SVG that stretches with the page, every text is text of the page
panels       One figure's heading and panels, drawn by Matplotlib: names instead of legends, gauges for far limits,
             scale bars
plots        Figures -> PNG and SVG by Matplotlib, imported when one is drawn; `lwr_dyn.plot`, a picture of runs
"""
