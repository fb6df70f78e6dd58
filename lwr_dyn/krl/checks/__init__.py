"""What can be diagnosed without running: names, types, declarations, initial values, jumps.

static_checks  What can be diagnosed without running a program or a project: names, types, declarations, initial
               values, jumps
type_check     An expression where it stands: its type, those of a call's arguments, and constants that cannot be meant
"""
