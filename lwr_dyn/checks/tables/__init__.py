"""Faults in tables of numbers that need no model to be seen.

- `rules`: `lint`, `lint_file`: a file examined by every rule
- `sheet`: `Sheet` and its tables, columns, matrices, sentences; `Finding`
- `toml_sheet`, `csv_sheet`, `list_columns`, `roles`: files as sheets, the meaning of headings
- `min_mean_max`, `proportions`, `formulas`, `sentences`, `consistency`, `shifts`, `repeated_digits`, `unit_sense`: the
  rules
- `fault_search`, `arithmetic`, `dimensions`: explanations of wrong cells, formulas as text, dimensions of units
"""
