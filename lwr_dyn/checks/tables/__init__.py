"""Faults in tables of numbers that need no model to be seen.

rules         `lint`, `lint_file`: a file examined by every rule; numbers that must agree, copied neighbours
sheet         `Sheet`: tables, columns, matrices, sentences; CSV files; the meaning of headings; `Finding`
toml_sheet    TOML files as sheets
min_mean_max  a mean outside its extremes
proportions   proportional columns, shifted rows
formulas      declared formulas, arithmetic in sentences, the single faults that explain wrong cells
arithmetic    formulas and units as text, dimensions
"""
