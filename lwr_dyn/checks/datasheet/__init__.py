"""An arm against the data sheet of its maker.

datasheet  `datasheet_verdicts`; zero, direction and DH convention of joints from the sheet's poses
envelope   section, reach and volume that the wrist centre of a six-joint arm can reach
"""
