"""A program that runs: values of expressions, statements, the state of the controller, motions of the arm.

values, evaluate        values and their operators; expressions -> values and references
cell                    what stands around a program: constants, inputs, stubs, answers; reads a cell file
controller              `MachineData`, system variables, inputs and outputs, what a run assumes
targets, motions        points -> axes, motions -> the timeline, spline blocks; with their faults
triggers                the clock, triggers, BRAKE
passes                  the passes of an endless loop, and states that are compared
running_program         `RunningProgram`: calls, variables, controller, motions, clock of one run
inline_forms, functions BAS and the functions of inline forms; those of the controller, stubs
outside_values          a cell's names and values in a program
background              what goes on beside: conditions, answers, BRAKE and RESUME, loops that come back
branches, execute       where a routine goes on; a function for each statement, submit programs
program_run             `check_program`, `run_program` -> `ProgramRun`
"""
