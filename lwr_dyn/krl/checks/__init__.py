"""What can be diagnosed without running: names, types, declarations, initial values, jumps.

static_checks   a program, a project: the check of each statement
type_check      the type of an expression, of arguments
constants       indices, speeds, percentages, constants of enumerations
"""
