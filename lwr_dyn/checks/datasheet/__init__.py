"""An arm against the data sheet of its maker.

datasheet  A DH table and its limits against the maker's data sheet: poses, axes, ranges, reach, envelope volume and
           mass
envelope   Working envelope of the wrist centre of a six-joint arm: its section, reach and volume in closed form
"""
