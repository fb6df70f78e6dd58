"""The subcommands of `lwr-dyn identify`, one file each, and `lwr-dyn excite`.

elastic      `lwr-dyn identify elastic`: springs and dampers of gears from logs of both their sides
excite       `lwr-dyn excite`: a motion whose torques say most of an arm's parameters
friction     `lwr-dyn identify friction`: friction from runs at constant speed
group        `lwr-dyn identify`: parameters of an arm from its logs
log_options  What the subcommands of `lwr-dyn identify` share: options of logs and motors, logs from files, faults,
             exit codes
motion       `lwr-dyn identify motion`: friction, base parameters and bodies from any motion
payload      `lwr-dyn identify payload`: a load in the hand from any motion
table        `lwr-dyn identify table`: a table against logs, cell by cell, and its slips traced
"""
