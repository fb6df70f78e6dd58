"""The command `lwr-dyn`: one module a subcommand; optional packages bring theirs as rows of `main.COMMANDS`.

main          the subcommands, exit codes, errors as one line
options       parts of several subcommands: ROBOT, lists of numbers, JSON
row_options   options that come with the rows of a registry
run_report    a run as text and as a record
"""
