"""Whose numbers a model file has: which published set, traced by digits (`lwr-dyn origin`).

link_numbers     Masses, centres and tensors of links, of a file and of every published set here
origin_document  What was found, for people and programs
tracing          Which set the links of a file agree with, digit by digit, in any frame and unit; where they differ
"""
