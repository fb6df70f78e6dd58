"""Faults in tables of numbers that need no model to be seen.

arithmetic    Formulas and units as text, evaluated safely: numbers, names, + - * / ^ and some functions; dimensions
formulas      A table against the formulas that its file declares: cells that do not follow, and the fault that
              explains them
min_mean_max  A mean outside its extremes, a maximum below its minimum, and the order of the columns in which they
              would fit
proportions   Columns of one file that are proportional in most rows, the rows that break it, and rows that are
              shifted by one
robot_checks  A data file of a robot held against what `lwr-dyn check` says of it: what that refuses or fails is a
              finding
rules         A file of numbers, examined by every rule; here the rules of numbers that must agree and of copied
              neighbours
sheet         The contents of a file of numbers, whatever its format: tables of printed cells, matrices, sentences;
              findings
toml_sheet    Any TOML file of numbers as a sheet: data files of robots, printed results, a user's own tables
"""
