"""What is drawn, described once for pages and pictures.

figure       `Figure`: panels, curves, levels; axes and ticks
run_figures  figures of runs, by name in `QUANTITIES`
margins      figures of a margin report
"""
