"""`lwr-dyn krl`: one file a subcommand, one group.

check    `lwr-dyn krl check`: the diagnostics of a program
diff     `lwr-dyn krl diff`: what two states of a program or a backup differ in
format   `lwr-dyn krl format`: files with their layout in order
group    The group `lwr-dyn krl`: a new subcommand is one file here and one row in it; each is imported when it is
         used
options  The options that `krl check` and `krl run` share; `lwr-dyn new cell`, a commented cell file to start from
run      `lwr-dyn krl run`: cycle time, motions, speeds and torques of a program, as text and as one JSON object
write    `lwr-dyn krl write`: a program from a task file of points, a run, or a table of poses or axes
"""
