"""Our own set of a ranking: ahead of the table that it is near, bodies, and no row that tests is seen."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.identification.ranking.filtered_log import FilterRule, filtered_log, trained_and_tested
from lwr_dyn.identification.ranking.identified_set import identified_arm
from lwr_dyn.identification.ranking.published_logs import published_log
from lwr_dyn.identification.ranking.rank import rank


@pytest.mark.slow
def test_bodies_identified_on_the_part_that_trains_leave_less_of_the_rest():
    """The trial found 0.344 N m on all of the log, under a filter of identification at 5 Hz."""
    found = rank("panda", "panda_salerno", ["gaz", "identified"])
    assert [one.name for one in found.scores] == ["identified", "gaz"]
    assert found.scores[0].not_bodies == ()
    assert found.floor() < found.scores[0].fits[0].total == pytest.approx(0.349, rel=0.01)


@pytest.mark.slow
def test_rows_that_test_are_not_seen():
    arm, rule = lwr_dyn.load("panda"), FilterRule(5.0)
    _, log = published_log("panda_salerno")
    train, _ = trained_and_tested(filtered_log(log, rule), rule.share)
    tau = log.tau.copy()
    tau[log.t > train.t[-1]] += 100.0
    one, other = (identified_arm(arm, x, train, rule) for x in (log, replace(log, tau=tau)))
    for a, b in zip(one.chain.bodies, other.chain.bodies, strict=True):
        assert np.array_equal(a.inertia_com, b.inertia_com)
        assert a.mass == b.mass
