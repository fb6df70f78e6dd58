"""What is drawn, described once for pages and pictures.

figure       A figure is described once: `lwr_dyn.pages.plotting` draws it as PNG and SVG, pages draw it themselves
margins      What a margin report draws: the loops at the worst pose over frequency, the margin over two joints around
             it
run_figures  Figures of runs: errors, torques and limits, the flange's path, a wall's force, an observer, responses;
             by name
"""
