"""The LWR-IV exercise recomputed.

study  The LWR-IV exercise recomputed: the seven matrices, the wrist centre by both routes, the tool point
"""

from lwr_dyn.reproduction.papers import Study

STUDY = Study(
    order=2,
    run="lwr_dyn.reproduction.lwr4.study:run",
    formulas="lwr_dyn.reproduction.lwr4.study:FORMULAS",
)
