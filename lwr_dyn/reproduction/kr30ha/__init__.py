"""The KR 30 HA report recomputed: points, matrices, equations of motion, program.

formulas         Formulas of the KR 30 HA report's numbers, printed and derived, by the names that its `results.toml`
                 gives them
krl_program      The KR 30 HA report's KRL program: its faults, each at its line and no other, the corrected program,
                 and its run
matrices         The report's matrices entry by entry: symbolic against its own Table 2, numeric against the true arm
                 at zero
planar_dynamics  The KR 30 HA report's dynamic analysis, expression by expression: printed, right, and each erratum
                 between them
points           The report's points recomputed: its own simplified solution digit by digit, what is right beside it,
                 misses in mm
study            Everything the KR 30 HA report prints, recomputed: points, matrices, envelope, equations, movement,
                 program
"""

from lwr_dyn.reproduction.papers import Study

STUDY = Study(
    order=4,
    run="lwr_dyn.reproduction.kr30ha.study:run",
    formulas="lwr_dyn.reproduction.kr30ha.formulas:FORMULAS",
    proofs="lwr_dyn.reproduction.kr30ha.matrices:PROOFS",
    conventions="zero",
    failing_readings=("printed",),
)
