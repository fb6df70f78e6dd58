"""The page of the robustness study: the numbers of its file, which agree with each other, and a share again."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from lwr_dyn.studies.sweep.read_study import read_study
from lwr_dyn.studies.sweep.running.workshop import SweepWorkshop

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import robustness
import robustness_runs

REPEATED = "inverse-dynamics"
"""The controller whose share is computed again here; all of them: scripts/soak.py robustness."""
RUN_AGAIN = 1e-5
"""Relative: the file has six digits."""


@pytest.fixture(scope="module")
def numbers():
    return json.loads(robustness.NUMBERS.read_text("utf-8"))


@pytest.fixture(scope="module")
def study():
    return read_study(robustness.STUDY)


def test_the_page_of_the_robustness_study_has_the_numbers_of_its_file(numbers):
    page = robustness.PAGE.read_text("utf-8")
    assert robustness.filled(page, numbers) == page
    assert {found["what"] for found in robustness.PLACE.finditer(page)} == set(robustness.parts(numbers))


def test_the_numbers_of_the_robustness_study_are_of_this_study(numbers, study):
    assert numbers["study"] == study.digest
    assert tuple(numbers["controllers"]) == study.controllers
    assert study.method == "random"  # the intervals are of independent runs
    for one in numbers["controllers"].values():
        assert one["runs"] == study.count
        assert len(one["again"]) == robustness.AGAIN
        assert {row["path"] for row in one["alone"]} <= {each.path for each in study.parameters}


def test_the_numbers_agree_with_each_other(numbers):
    for one in numbers["controllers"].values():
        for part in (one, one["known"], one["unknown"], *one["by_delay"]):
            for name in ("tip_max", "tip_rms"):
                values = [x["value"] for x in part[name]]
                assert values == sorted(values)
                assert all(x["low"] <= x["value"] <= x["high"] for x in part[name])
            kept = part["keeps"]
            assert 0.0 <= kept["low"] <= kept["count"] / kept["runs"] <= kept["high"] <= 1.0
        kept = one["keeps"]["count"]
        assert one["known"]["keeps"]["count"] + one["unknown"]["keeps"]["count"] == kept
        assert sum(part["keeps"]["count"] for part in one["by_delay"]) == kept
        outside = [one[key]["count"] for key in ("stop", "cut", "fast", "lost")]
        assert max(outside) <= one["runs"] - one["inside"]["count"] <= sum(outside)


@pytest.mark.slow
def test_a_seeded_share_of_the_robustness_study_comes_out_again(numbers, study):
    again = numbers["controllers"][REPEATED]["again"]
    found = robustness_runs.repeated(SweepWorkshop(study), REPEATED, [one["run"] for one in again])
    for name, column in found.items():
        assert column == pytest.approx([one[name] for one in again], rel=RUN_AGAIN)


def test_a_run_without_a_number_counts_as_above_all():
    rng = np.random.default_rng(0)
    k = 400
    columns = {
        "run": np.arange(k), "flags": np.full(k, "", dtype="U12"), "payload.known": rng.integers(0, 2, k),
        "loop.delay": rng.integers(0, 5, k), "tip_max": rng.random(k) * 1e-3, "tip_rms": rng.random(k) * 1e-4,
        "saturated_s": np.zeros((k, 2)), "limit_margin": np.ones((k, 2)), "peak_speed": np.ones((k, 2)),
    }  # fmt: skip
    columns["flags"][:40] = "stop"
    columns["flags"][40:50] = "not finite"
    for name in ("tip_max", "tip_rms", "limit_margin"):
        columns[name][:50] = np.nan
    columns["saturated_s"][50:60, 1] = 0.1
    columns["peak_speed"][60:65, 0] = 3.0
    found = robustness.figures(columns, np.full(2, 2.0))
    assert [one["value"] is None for one in found["tip_max"]] == [False, True, True, True]
    counts = {key: found[key]["count"] for key in ("keeps", "inside", "stop", "lost", "cut", "fast")}
    assert counts == {"keeps": 350, "inside": 335, "stop": 40, "lost": 10, "cut": 10, "fast": 5}
