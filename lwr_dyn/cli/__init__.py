"""The command `lwr-dyn`: one module a subcommand, a row of `main.COMMANDS`; groups are folders.

main     the subcommands, exit codes, errors as one line, help
options  what several subcommands share: ROBOT, lists of numbers, JSON, options of rows
"""
