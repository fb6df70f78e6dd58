"""Our own set of a ranking: bodies identified on the rows that train, with the filter of the ranking.

They are those of `identify motion` near the first set that is named, with rotors and friction free beside them; the
ranking takes the bodies alone, as of every set. No row that tests is seen.
"""

from dataclasses import replace

from lwr_dyn.identification.fitted import fitted_arm, fitted_values
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import MotionRule
from lwr_dyn.identification.ranking.filtered_log import FilteredLog, FilterRule
from lwr_dyn.identification.regression.samples import SampleRule
from lwr_dyn.model.arm import LINK_SIDE, Arm

IDENTIFIED = "identified"
"""Its name in place of a reading."""


def identified_arm(near: Arm, log: JointLog, train: FilteredLog, rule: FilterRule) -> Arm:
    """The arm `near` with bodies identified on the rows of a log up to the last one that trains.

    Raises
    ------
    LogError
        Rows from which nothing can be identified.
    """
    rows = log.t <= train.t[-1]
    seen = replace(log, **{name: x[rows] for name in ("t", "q", "tau", "dq") if (x := getattr(log, name)) is not None})
    samples = SampleRule(rule.cutoff, link_side=near.torques == LINK_SIDE)
    return fitted_arm(near, fitted_values(identify_motion([seen], near, MotionRule(samples))))
