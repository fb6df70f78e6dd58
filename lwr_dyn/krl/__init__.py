"""KUKA Robot Language: programs as data; they are read, written, checked and run on a robot's model.

Text to records
    lexer, line_parser, grammar.lark   one line -> tokens -> a statement
    expressions, declarations, statements   the records, with the rule of the grammar that builds each
    unparse                            records -> text
    source                             `SourceFile`: a file as lines, written back byte for byte
    blocks, symbols, program           routines and blocks; declared names; `Program`, a `.src` with its `.dat`
Checks
    diagnostics                        `Diagnostic`: severity, code, message and hint at a position
    types, predefined, type_check      the types of KRL, the names every controller has, types of expressions
    static_checks                      what can be diagnosed without running
Runs
    interpreter, execute               line by line; a function for each statement
    values, operators, evaluate        values of expressions
    controller, bas                    `MachineData`, system variables; the subprogram BAS
    motions, targets, planner          points to axes, motions to segments, with their faults
    motion_segments, timeline          PTP, LIN and CIRC in time; blends
    run                                `check_program`, `run_program` -> `ProgramRun`
    point_program                      `PointProgram`: a list of points -> a program
    kuka_pose, kuka_units              X, Y, Z, A, B, C, Status and Turn; what `lwr-dyn fk` and `ik` show of them
    command                            `lwr-dyn krl write | check | run`
"""
