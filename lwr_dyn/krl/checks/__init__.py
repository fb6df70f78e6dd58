"""What can be diagnosed without running: names, types, declarations, initial values, jumps.

constants      Constants that cannot be meant: an index outside of its array, a speed in mm/s, over 100 %, a `#NAME`
               of no ENUM
static_checks  What can be diagnosed without running a program or a project: names, types, declarations, initial
               values, jumps
type_check     The type of an expression in a scope, and of each argument of a call, with a diagnostic where types do
               not fit
"""
