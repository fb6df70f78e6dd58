"""The report of an identification as one HTML page.

report_page          the report as one HTML file
motion_report        a fit to any motion as what the page shows
motion_checks        its validation, bodies, what it leaves open
table_section        the table against the log, cell by cell, and repairs of slips
fit_values           from a fit to parameters, predicted torques, friction over speed
shown_fit            what it shows, as plain values
arm_stage            the motion in 3D with the ellipsoids of the links
inertia_ellipsoids   a body as the solid ellipsoid of its mass and inertia
torque_charts        measured and predicted torques, what is left
friction_charts      friction over speed, dots and the fitted curve
parameter_rows       parameters with sigma and table; links before and after
line_plane           lines, dots and bands of a plane
"""
