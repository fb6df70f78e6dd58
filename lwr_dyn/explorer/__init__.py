"""An arm in the browser: sliders, frames, centres of mass, inertia ellipsoids, limits, and the source of each number.

inertia_shape   the solid ellipsoid with the mass and inertia of a body
page_data       what the page knows of an arm, as JSON values
number_tables   tables of joints and links; each number opens its source
page            explorer_html, write_explorer: one HTML file without requests
still           a picture of an arm for readers that show no page
shown           show: a page in the browser, or in a cell of a notebook
command         lwr-dyn show

In the page: kinematics.js computes poses from the page's data alone, arm_parts.js draws what is added to the arm on the
stage of `lwr_dyn.viewer`, explorer.js connects sliders, switches and numbers with both.
"""
