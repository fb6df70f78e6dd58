"""Figures as pictures: PNG and SVG by Matplotlib, and HTML.

drawn_panel  a panel ready to draw: numbers, colours by name, axes, limits near and far, errors magnified; as HTML
panels       a figure's heading and panels drawn by Matplotlib
plots        `save_figure`, `figure_bytes`; pictures of sampled loops
"""
