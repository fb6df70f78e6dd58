"""KUKA Robot Language: programs as data; they are read, written, checked and run on a robot's model.

checks       What can be diagnosed without running: names, types, declarations, initial values, jumps
comparing    Compares two files, or two folders file by file: the values of a `.dat`, the statements of a `.src` by
             routine
diagnostics  Diagnostics: what is wrong or doubtful in a program, where, and what helps; and the log of those of a run
editor       What an editor asks of KRL files, and the language server that answers; nothing here imports numerics
language     The language: one line -> tokens -> a statement; a file as lines, written back byte for byte; routines
             and blocks
motion       Segments and blends in time
names        Types of KRL, and the names that need no declaration
page         One HTML file that replays a run with its program beside the arm: the line that moves it now is marked
project      A program: its files, the names they declare, and which of them a routine sees
robot        The robot as a KUKA controller describes it
running      A program that runs: values of expressions, statements, the state of the controller, motions of the arm
writing      Programs written from other data: a list of points, a run, a table of poses or axes
"""
