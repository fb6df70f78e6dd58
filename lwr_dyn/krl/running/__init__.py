"""A program that runs: values of expressions, statements, the state of the controller, motions of the arm.

values, operators, evaluate                values of expressions
controller, bas                            `MachineData`, system variables; the subprogram BAS
interpreter, execute                       line by line; a function for each statement
motions, targets                           points to axes, motions to segments, with their faults
run, program_run                           `check_program`, `run_program` -> `ProgramRun`
"""
