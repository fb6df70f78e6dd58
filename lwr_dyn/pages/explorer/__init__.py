"""An arm in the browser: sliders, frames, centres of mass, inertia ellipsoids, limits, and the source of each number.

inertia_shape   the solid ellipsoid with the mass and inertia of a body
page_data       what the page knows of an arm, as JSON values
arms_shown      the arms of a page: readings of one paper, or two robots side by side
computing       the emitted functions that the page computes with; arms with the same kinematics share them
arm_html        what the page writes of one arm without a script, and what another arm changes of it
slips           what the readings of a paper differ in: errata and numbers
number_tables   tables of joints and links; each number opens its source
page            explorer_html, write_explorer: one HTML file without requests
still           a picture of an arm for readers that show no page
shown           show: a page in the browser, or in a cell of a notebook
command         lwr-dyn show

In the page: explorer.js keeps the list of arms with one active; arm_functions.js binds emitted functions to an arm's
numbers, arm_pieces.js puts its HTML in place, arm_parts.js draws what is added to it on the stage of `pages.replay`.
Each panel adds itself to panels.js and is made anew for each arm; kinematics.js computes poses from data alone;
numerics.js and written_numbers.js are for all panels; side_by_side.js compares and couples two robots.
"""
