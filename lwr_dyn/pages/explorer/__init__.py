"""An arm in the browser: sliders, frames, centres of mass, inertia ellipsoids, limits, and the source of each number.

arm_html   What the page writes of one arm without a script: title, facts, notes, sliders, switches, tables
page       An arm -> one HTML file without requests: its scene, sliders, and tables in which each number opens its
           source
page_data  What the page knows of an arm, or of its arms: kinematics, bodies, closed forms, and the stage, as JSON
           values
shown      `lwr_dyn.show`: an arm or a run as a page, opened in the browser, or shown in a cell of a notebook

In the page: explorer.js keeps the list of arms with one active; arm_functions.js binds emitted functions to an arm's
numbers, arm_pieces.js puts its HTML in place, arm_parts.js draws what is added to it on the stage of `pages.replay`.
Each panel adds itself to panels.js and is made anew for each arm; kinematics.js computes poses from data alone;
numerics.js and written_numbers.js are for all panels; side_by_side.js compares and couples two robots.
"""
