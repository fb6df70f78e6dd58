"""Figures as pictures: their rules, and PNG and SVG by Matplotlib.

run_figures  figures of runs: errors, torques, the path of the flange
axes         the range and the ticks of an axis, by the data
drawn_panel  a panel ready to draw: numbers, colours by name, axes, limits near and far, errors magnified
layout       where the parts of a figure stand
panels       one panel drawn by Matplotlib
plots        save_figure, figure_bytes: a figure as PNG and SVG
charts       a figure as HTML: lines that stretch with the page, texts of the page
document     one HTML file without a request: head, look, frame
"""
