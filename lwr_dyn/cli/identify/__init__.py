"""The subcommands of `lwr-dyn identify`, one file each.

group          the group: a row a subcommand
log_options    options that they share; logs from files; warnings, faults and the exit code
motor_options  logs of the motors
friction       from runs at constant speed
motion         from any motion
table          a table against logs
payload        a load in the hand
elastic        springs and dampers of gears
"""
