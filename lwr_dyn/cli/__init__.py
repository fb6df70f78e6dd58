"""The command `lwr-dyn`: one module a subcommand, a row of `main.COMMANDS`; groups are folders.

check        `lwr-dyn check`: every check of one robot's model and file; exit 1 when one fails
compare      `lwr-dyn compare`: run files side by side, or controllers x plants simulated on one task
conventions  `lwr-dyn conventions`: the possible conventions of a table that states none, ranked, with the reasons
dh           `lwr-dyn dh`: any arm as a Denavit-Hartenberg table, or as a data file that loads again
fk           `lwr-dyn fk`: the pose of the flange, a point on it, and the DH matrices in symbols
fmu          `lwr-dyn fmu`: an arm as a plant, or a control law at samples, as an FMU for other tools
gains        `lwr-dyn gains`: each joint's largest inertia, what is proven of it, and gains for a second-order loop
help_text    What `--help` shows: commands and options in groups, limits of files, examples; and all options with
             `--help-all`
identify     The subcommands of `lwr-dyn identify`, one file each, and `lwr-dyn excite`
ik           `lwr-dyn ik`: joint positions for a pose of the flange, all branches; exit 1 when there is none
kernels      `lwr-dyn kernels`: functions of an arm as C or JavaScript; the generated source and the cost of a batch
             function
krl          `lwr-dyn krl`: one file a subcommand, one group
lint         `lwr-dyn lint`: faults in URDFs and in tables of numbers that show in the file; exit 1 when there are
             some
list_        `lwr-dyn list`: the robots, their readings, and where their numbers come from
lsp          `lwr-dyn lsp`: a language server for KRL, URDF and xacro files
main         `lwr-dyn`: the subcommands, and how errors become one line and an exit code
margins      `lwr-dyn margins`: what sampling, delay and elastic joints leave of a loop's stability, and where it is
             worst
new          `lwr-dyn new`: commented files to start from, each kind a row of `KINDS`
options      Parts of several subcommands: the ROBOT argument with its options, lists of numbers, JSON output, options
             of rows
origin       `lwr-dyn origin`: which published set the numbers of a model file come from
parity       `lwr-dyn parity`: what Pinocchio, MuJoCo, Drake, PyBullet and yourdfpy make of a model file
renamed      Options that had another name: an old one is answered with the new one, for this version
rank         `lwr-dyn rank`: published sets of one robot on a log of the real one
replay       `lwr-dyn replay`: run files -> one HTML page, or a live meshcat on this machine
reproduce    `lwr-dyn reproduce`: everything a paper prints, recomputed, into a folder
sensitivity  `lwr-dyn sensitivity`: one task under all readings of a robot, controllers on one and plants on another
show         `lwr-dyn show`: an arm or a run in the browser
simulate     `lwr-dyn simulate`: a robot, a task and a controller become a run file with its metrics and audit
sweep        `lwr-dyn sweep`: a study carried out, its cost stated ahead; killed at any point, the same command goes
             on
tune         `lwr-dyn tune`: gains for a stated aim over the runs of a study, judged on runs that the search has not
             seen
urdf         `lwr-dyn urdf`: the URDF on stdout, or into a file with its sidecars beside it
vocabulary   The options that several commands share: what each name means, its type, unit and form, in one table
"""
