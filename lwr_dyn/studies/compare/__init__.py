"""Runs side by side: `lwr_dyn.compare`, and `lwr-dyn compare` with its page.

compared_run  `ComparedRun`: a run of a comparison with its figures of merit, and whether its loop kept still
comparison    `RunComparison`: several runs of one reference as a table, records and figures; refuses runs that differ
              in more; any two of them replayed side by side, in one file that needs no network
plants        Plants by name: each is the arm of the controllers' model, changed in one thing that they do not know of
study         Controllers x plants: every controller on every plant, on one reference, in one process or several
"""
