"""What every package stands on: no robot, no physics.

arrays        Input checks of arrays: arguments become finite float64 arrays of the right shape, or raise one clear
              error
column_files  Columns of numbers in CSV and Parquet files (extra `logs`), in and out
document      What a command found, as a document: a title, a verdict, sections of facts, tables, notes and figures
errors        The error tree: every error of this package is an `LwrDynError` and keeps its facts as attributes
fields        A TOML table read field by field: one that is missing, wrong or unknown raises `PaperError` with its
              file and place
files         Reads files with one clear error; writes files under a temporary name and renames them: none is ever
              incomplete
number_text   Numbers as text for people: a few digits, a true minus, raised exponents
progress      Progress of long work: one line on a terminal, a bar in a notebook, nothing in a pipe; and whether it is
              to end
records       Frozen dataclasses made in a fifth of the time, for those that are made by the million
registry      Registries: what can be chosen by name. A row is imported when it is used; other packages can add rows
tables        A table is described once; its forms are aligned text, a record for programs, and (in `pages`) HTML
version       The version, in a module without imports so that every other module can use it
"""
