"""The subcommands of `lwr-dyn identify`, one file each, and `lwr-dyn excite`.

group        the group with its subcommands
log_options  options that they share; logs from files, of motors too; warnings, faults and the exit code
friction     from runs at constant speed
motion       from any motion
table        a table against logs
payload      a load in the hand
elastic      springs and dampers of gears
excite       a motion to run and log
"""
