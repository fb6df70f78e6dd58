"""The LWR 4+ paper recomputed: worst-case inertias, gains, both controllers on IST."""

from lwr_dyn.reproduction.papers import SENSITIVITY, Study, StudyOption

TIMINGS = ("constant", "quintic", "smooth")
STUDY = Study(
    order=1,
    run="lwr_dyn.reproduction.lwr4plus.study:run",
    formulas="lwr_dyn.reproduction.lwr4plus.formulas:FORMULAS",
    proofs="lwr_dyn.reproduction.lwr4plus.proofs:PROOFS",
    options=(
        StudyOption("timing", f"of the runs that are replayed: {', '.join(TIMINGS)} (the last if not given)", TIMINGS),
        StudyOption("fit-arm-angle", "also fit the arm angle to Table VIII"),
        SENSITIVITY,
    ),
    conventions="tensors",
)
