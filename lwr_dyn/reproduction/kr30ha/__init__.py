"""The KR 30 HA report recomputed: points, matrices, equations of motion, program."""

from lwr_dyn.reproduction.papers import Study

STUDY = Study(
    order=4,
    run="lwr_dyn.reproduction.kr30ha.study:run",
    formulas="lwr_dyn.reproduction.kr30ha.formulas:FORMULAS",
    proofs="lwr_dyn.reproduction.kr30ha.matrices:PROOFS",
    conventions="zero",
    failing_readings=("printed",),
)
