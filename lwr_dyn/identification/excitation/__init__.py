"""Motions that excite the parameters of an arm (`lwr-dyn excite`).

design         Design of a motion that excites the base parameters of an arm: `design_excitation`; as a document
motion_design  The search for one motion: starts, the best of them searched further, and what its check asks to be
               done again
motion_file    A designed motion as a file: columns of CSV or Parquet, or a run
motion_limits  What a motion may use of an arm's positions, speeds and torques, and how near it comes to floor, column
               and itself
objectives     Fourier motions that begin and end at rest, and how much their torques say of the base parameters
room           Whether an arm has room for a motion at all: what no pose meets is said before a search begins
watch          When a search must end, and how far it is: its time, a wish to stop, and what progress shows
"""
