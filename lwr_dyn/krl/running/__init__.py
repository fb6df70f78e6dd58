"""A program that runs: values of expressions, statements, the state of the controller, motions of the arm.

background       What goes on beside a running program: the cell's values and answers, interrupts, BRAKE and RESUME,
                 and loops
cell             A cell: what stands around a program: the robot, inputs, states, variables of a PLC, tools, stubs,
                 its answers
conditions       Conditions of interrupts and of the cell's answers: whether one is true, and when it becomes true
controller       The state of the robot controller while a program runs: machine data, frames, speeds, blends, inputs
evaluate         Evaluation: expressions -> values, and references -> the variables, elements and components they name
execute          Executes a running program step by step, with bounds on steps and time, and its submit programs
functions        Calls: the routine that one enters; else the value of a stub, or of a function of the controller
inline_forms     What KUKA's inline forms use: BAS, the functions of S motions, and assignments after WITH, which hold
                 for one motion
motions          Moves the arm of a running program: plans one motion after another onto the timeline, and lists them
program_run      Checks a program, and runs it on a robot's model: motions in time, speeds, poses, torques, and a Run
                 to replay
running_program  A running program: its calls, variables, controller, motions and clock, and what a name means in it
targets          From a programmed point to axes: reach, limits, Status and Turn, with diagnostics of faults and their
                 distance
triggers         The time of a running program: its clock, its events and timers, TRIGGER and BRAKE
values           Values of a running program (numbers, truth values, text, structures, arrays), their variables and
                 their operators
"""
