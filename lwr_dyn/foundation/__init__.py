"""What every package stands on: no robot, no physics.

arrays        gates for arrays and numbers of users; read-only arrays
errors        the error tree
fields        `Fields`: a TOML table read field by field
files         reading, and writing to a temporary name first
column_files  CSV and Parquet: columns by name
tables        tables as text and JSON
number_text   numbers for people: a few digits, a true minus, raised exponents
document      `Document`: one description of a result for text, JSON and schema
registry      `Registry`: rows that others add, and the options of their factories
progress      the line of long work on a terminal
version       the version
"""
