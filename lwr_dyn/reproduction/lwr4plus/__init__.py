"""The LWR 4+ paper recomputed: worst-case inertias, gains, both controllers on IST.

formulas     Formulas of the numbers that the LWR 4+ paper prints, by the names that its `results.toml` gives them
proofs       Proofs of the errata in the LWR 4+ paper: tables against what they must be, equations exactly as printed
study        Everything the LWR 4+ paper prints, recomputed; every controller on IST, also with a wrong model; the
             figures
worst_cases  Tables IV and VI of the LWR 4+ paper recomputed: worst-case inertias under every reading, and the gains
"""

from lwr_dyn.reproduction.papers import SENSITIVITY, Study, StudyOption

TIMINGS = ("constant", "quintic", "smooth")
STUDY = Study(
    order=1,
    run="lwr_dyn.reproduction.lwr4plus.study:run",
    formulas="lwr_dyn.reproduction.lwr4plus.formulas:FORMULAS",
    proofs="lwr_dyn.reproduction.lwr4plus.proofs:PROOFS",
    options=(
        StudyOption(
            "timing", "motion profile along the path in runs that are replayed; the last if not given", TIMINGS
        ),
        StudyOption("fit-arm-angle", "also fit the arm angle to Table VIII"),
        SENSITIVITY,
    ),
    conventions="tensors",
)
