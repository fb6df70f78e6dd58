"""What can be diagnosed without running: names, types, declarations, initial values, jumps.

constant_values   Constants that cannot be meant: an index outside of its array, a speed in mm/s, over 100 %
global_names      GLOBAL names that two modules declare: the controller takes neither of them
spline_blocks     The lines of a spline block: its motions, and what belongs into such a block only
statement_places  What may stand where: the lines of SWITCH, the target of GOTO; parameters without a type; interrupts
static_checks     What can be diagnosed without running a program or a project: names, types, declarations, initial
                  values, jumps
system_names      Names that begin with `$` and that no list has: the one that was probably meant
type_check        An expression where it stands: its type, those of a call's arguments, and the `#NAME` of no ENUM
written_places    What a program may not write: inputs, measured values, constants, signals on inputs; texts without
                  their brackets
"""
