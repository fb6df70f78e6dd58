"""An arm in the browser: sliders, frames, centres of mass, inertia ellipsoids, limits, and the source of each number.

page       `explorer_html`, `write_explorer`: one HTML file without requests, with the functions it computes with
page_data  what the page knows of its arms, as JSON values
arm_html   what the page writes of one arm without a script
shown      `show`: a page in the browser, or in a cell of a notebook

In the page: explorer.js keeps the list of arms with one active; arm_functions.js binds emitted functions to an arm's
numbers, arm_pieces.js puts its HTML in place, arm_parts.js draws what is added to it on the stage of `pages.replay`.
Each panel adds itself to panels.js and is made anew for each arm; kinematics.js computes poses from data alone;
numerics.js and written_numbers.js are for all panels; side_by_side.js compares and couples two robots.
"""
