"""Motions that excite the parameters of an arm (`lwr-dyn excite`).

fourier           Fourier series at rest at both ends
clearance         distances of the arm from floor, column and itself
motion_limits     what positions, speeds and torques the motion may use
objectives        how much the torques of a motion say of the parameters, with gradient
search            one start of the search
design            design_excitation
excitation_file   the motion as a table or a run
excitation_text   the result as text and record
command           the subcommand
"""
