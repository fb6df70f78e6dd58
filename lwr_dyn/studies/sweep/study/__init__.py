"""The file of a study: what is varied, how its runs are drawn, and the arguments of rollouts that it gives.

study_file                                   SweepStudy: a study as a record: values of its runs, its digest
read_study                                   the study of a TOML file, read strictly
task_fields, parameter_fields, study_fields  the tables of the file
parameter_checks                             whether what varies exists in the arm, the controllers, the task
nominal_values                               what a parameter is as modelled
source_files                                 files that changed since a study was read: refused
study_setup                                  arm, references and controllers of a study
plant_rows                                   values of the paths as parameters of the plants
rollout_arguments                            values of the paths as keywords of `lwr_dyn.rollouts`, for one controller
new_study                                    `lwr-dyn new study`
parameter_paths                              what can be varied, by path: unit, words, bounds, how many draws
distributions                                VariedParameter: a path and how its values are distributed
sampling                                     the points of the unit cube: grid, Sobol, Latin hypercube, random, Saltelli
metric_table                                 the metrics of a run by name: unit, words, which side is bad
"""
