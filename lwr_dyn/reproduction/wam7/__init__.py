"""The WAM paper recomputed: its eight simulations with friction."""

from lwr_dyn.reproduction.papers import SENSITIVITY, Study

STUDY = Study(
    order=3,
    run="lwr_dyn.reproduction.wam7.study:run",
    formulas="lwr_dyn.reproduction.wam7.formulas:FORMULAS",
    proofs="lwr_dyn.reproduction.wam7.formulas:PROOFS",
    options=(SENSITIVITY,),
    conventions="tensors",
)
