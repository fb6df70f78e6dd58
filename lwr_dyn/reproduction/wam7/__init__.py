"""The WAM paper recomputed: its eight simulations with friction.

formulas  Formulas of the numbers that the WAM paper prints, by the names that its `results.toml` gives them
runs      The WAM paper's eight simulations: 0.5 rad in 7 s on an LSPB, each joint alone, then all together, with its
          friction
study     Everything the WAM paper simulates: tables, runs, Figures 4 to 8 redrawn, a replay
"""

from lwr_dyn.reproduction.papers import SENSITIVITY, Study

STUDY = Study(
    order=3,
    run="lwr_dyn.reproduction.wam7.study:run",
    formulas="lwr_dyn.reproduction.wam7.formulas:FORMULAS",
    proofs="lwr_dyn.reproduction.wam7.formulas:PROOFS",
    options=(SENSITIVITY,),
    conventions="tensors",
)
