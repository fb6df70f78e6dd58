"""A program that runs: values of expressions, statements, the state of the controller, motions of the arm.

values, evaluate        values and their operators; expressions -> values and references
cell                    what stands around a program, read from a cell file: constants, inputs, stubs, answers
controller              `MachineData`, system variables, inputs and outputs, what a run assumes
targets, motions        points -> axes, motions -> the timeline, spline blocks; with their faults
triggers                the clock, triggers, BRAKE
passes                  the passes of an endless loop, and states that are compared
running_program         `RunningProgram`: calls, variables, controller, motions, clock of one run
inline_forms, functions BAS and the functions of inline forms; those of the controller, stubs
background              what goes on beside: the cell's values and answers, conditions, BRAKE and RESUME, loops
execute                 a function for each statement; submit programs
program_run             `check_program`, `run_program` -> `ProgramRun`
"""
