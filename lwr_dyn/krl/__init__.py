"""KUKA Robot Language: programs as data; they are read, written, checked and run on a robot's model.

The rooms, each sees those below it:

    command     `lwr-dyn krl write | check | run | diff | format | server`
    editor      what an editor asks, and the language server that answers
    page        the page that replays a run beside its program
    comparing   what two programs or backups differ in
    writing     programs from points, runs and tables of poses
    running     the interpreter, the controller's state, motions of the arm; `check_program`, `run_program`
    motion      segments and blends in time
    checks      what can be diagnosed without running
    project     a program's files and their names
    robot       poses with Status and Turn
    language    lines, statements, files, blocks
    names       types and predefined names
    diagnostics     `Diagnostic`: severity, code, message and hint at a position
"""
