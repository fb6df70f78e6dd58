"""The table of elastic loops: its figures are those of the poles, its shares carry their intervals."""

from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.gains import LinearFeedback, diagonal
from lwr_dyn.design.elastic_loop import ElasticArm, ElasticShares, elastic_shares, elastic_table
from lwr_dyn.design.sampled_loop import Sampling
from lwr_dyn.foundation.errors import MissingDataError
from tests.design.test_elastic_loop import arm, law


def test_a_row_for_every_law_on_every_stiffness():
    laws = [(law("pd"), "link"), (law("motor"), "motor")]
    reference = lwr_dyn.reference("ist", arm())
    table = elastic_table(arm(), laws, [1e4, 3e4], reference, 5.0, poses=40)
    assert [(*row[:2], row[3], row[4]) for row in table.cells] == [
        ("10000", "pd-gravity", "+58.8", "all (above 91.2 %)"),
        ("10000", "motor-pd", "-23.2", "0 (below 8.8 %)"),
        ("30000", "pd-gravity", "-27.0", table.cells[2][4]),
        ("30000", "motor-pd", "-26.9", "0 (below 8.8 %)"),
    ]
    late = elastic_table(arm(), laws[1:], ["file"], reference, 5.0, Sampling(1000.0, 1), poses=40)
    assert late.cells[0][5] == "all (above 91.2 %)"
    assert "late by 1 sample" in late.columns[5].title


def test_shares_count_each_pose_on_both_roads():
    """One by one as all at once; damping on light rotors is unstable only when it is sampled."""
    q = np.random.default_rng(1).uniform(arm().lower, arm().upper, (30, 7))
    plant = ElasticArm.of(arm(), 3e4, "link")
    found = elastic_shares(plant, law("pd"), q)
    one_by_one = [elastic_shares(plant, law("pd"), pose[None]) for pose in q]
    assert found.continuous == sum(each.continuous for each in one_by_one)
    assert found.sampled == sum(each.sampled for each in one_by_one)
    assert found.growth == pytest.approx(max(each.growth for each in one_by_one))
    assert found.radius == pytest.approx(max(each.radius for each in one_by_one))
    damper = SimpleNamespace(linear_feedback=lambda q: LinearFeedback(*(diagonal(np.full(7, 400.0), len(q)),) * 2))
    motor = elastic_shares(ElasticArm.of(arm(), 3e4, "motor"), damper, q)
    assert (motor.continuous, motor.sampled) == (0, 30)
    assert motor.radius > 1.2


def test_the_interval_of_a_share_holds_it():
    for low, high in ElasticShares(200, 20, 0, 5.0, 0.9).intervals:
        assert 0.0 <= low < high
    assert ElasticShares(200, 20, 0, 5.0, 0.9).intervals[0] == pytest.approx((0.0657, 0.1494), abs=1e-3)


def test_an_arm_without_stiffness_is_refused():
    with pytest.raises(MissingDataError, match="stiffness"):
        elastic_table(lwr_dyn.load("wam7"), [(law("pd"), "link")], ["file"], lwr_dyn.reference("ist", arm()), 5.0)
