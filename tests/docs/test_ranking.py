"""The page of the ranking has the numbers of its file, and a seeded share of them comes out again."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.studies.compare.plants import plant_case
from lwr_dyn.studies.compare.study import ControllerStudy, tuned_frequencies
from lwr_dyn.trajectory.references.ist import Twice

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import ranking  # noqa: E402

SHARE, SEED = 2, 26
"""Pairs of a move that are simulated again; all of them: scripts/ranking.py."""
AGAIN = 1e-4
"""Relative, of an error of the tip: rounding of another machine, through friction that sticks."""


@pytest.fixture(scope="module")
def numbers():
    return json.loads(ranking.NUMBERS.read_text("utf-8"))


def study_of(numbers, study, controllers, plants):
    """The study with some of its controllers, and the gains that it had; its reference is followed twice."""
    arm = arm_with_friction(lwr_dyn.load("lwr4plus", reading=study.partition("-")[2]), 0.01)
    start, end = (np.radians([float(x) for x in ranking.MOVE[i].split(",")]) for i in (1, 3))
    once = lwr_dyn.reference("point-to-point", arm, start=start, end=end, duration=float(ranking.MOVE[5]))
    tuned = {name: {"omega_n": x["omega_n"]} for name, x in numbers[study]["tuned"].items()}
    reference = Twice(once)
    cases = [plant_case(arm, text) for text in plants]
    return ControllerStudy(arm, reference, controllers, cases, since=reference.second, tuned=tuned)


def test_the_page_has_the_numbers_of_the_file(numbers):
    page = ranking.PAGE.read_text("utf-8")
    assert ranking.filled(page, numbers) == page
    assert set(numbers) == set(ranking.STUDIES)


def test_each_study_has_every_pair_or_says_why_not(numbers):
    for study, record in numbers.items():
        assert record["command"] == f"lwr-dyn {ranking.shlex.join(ranking.command(study))}"
        assert re.fullmatch(r"[0-9a-f]{40}", record["commit"])
        pairs = [(run["typed"], run["plant"]) for run in record["runs"]]
        assert len(set(pairs)) == len(pairs)
        made = {typed for typed, _ in pairs}
        absent = [one for one in ranking.controllers(study.partition("-")[2]) if one not in made]
        assert all(any(why.startswith(f"{one}: ") for why in record["failures"]) for one in absent)
        refused = len(record["failures"]) - len(absent)
        assert len(pairs) + refused == len(made) * len(ranking.PLANTS_OF[study.partition("-")[0]])


@pytest.mark.slow
@pytest.mark.parametrize("reading", ranking.READINGS)
def test_a_seeded_share_comes_out_again(reading, numbers):
    study = f"move-{reading}"
    stable = [run for run in numbers[study]["runs"] if not run["unstable"]]
    words = {", ".join(text_words(text, reading)): text for text in ranking.PLANTS if "friction" not in text}
    rows = [run for run in stable if run["plant"] in words]
    for i in np.random.default_rng(SEED).choice(len(rows), SHARE, replace=False):
        run = rows[i]
        compared, _ = study_of(numbers, study, [run["typed"]], [words[run["plant"]]]).run()
        (again,) = compared.record()["runs"]
        for figure in ("tip_rms_mm", "tip_max_mm", "peak_torque"):
            assert again[figure] == pytest.approx(run[figure], rel=AGAIN), (run["typed"], run["plant"], figure)


def text_words(text, reading):
    """What a comparison says of the plant, where the plant's words say all of it."""
    case = plant_case(lwr_dyn.load("lwr4plus", reading=reading), text)
    load = case.options.get("payload")
    return [*case.words, *([f"{load:g} kg at the flange"] if load else [])] or ["as modelled"]


@pytest.mark.slow
def test_a_gain_comes_out_again(numbers):
    chosen = study_of(numbers, "move-physical", ["inverse-dynamics"], ["nominal"])
    found = tuned_frequencies(chosen.arm, chosen.specs, chosen.reference, ranking.PEAK)["inverse-dynamics"]
    recorded = numbers["move-physical"]["tuned"]["inverse-dynamics"]
    assert found.omega_n == pytest.approx(recorded["omega_n"], rel=1e-9)
    assert found.case.words == recorded["case"]
