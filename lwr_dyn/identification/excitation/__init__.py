"""Motions that excite the parameters of an arm (`lwr-dyn excite`).

objectives     Fourier series at rest at both ends; how much their torques say of the parameters, with gradient
motion_limits  what positions, speeds and torques a motion may use; distances from floor, column and own links
motion_design  the search from random starts, and whether there is room for any motion
design         design_excitation; the motion as document and file
"""
