"""Gains of one margin: each law gets the omega_n of the search, on the plants of the set, and a study uses it."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import controller_spec
from lwr_dyn.design.gain_search import TunedFrequency
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.studies.compare import study
from lwr_dyn.studies.compare.plants import plant_case
from lwr_dyn.studies.compare.study import ControllerStudy, cases_of, poses_of, tuned_frequencies
from tests.studies.compare.conftest import POSE

LAWS = ("inverse-dynamics", "inverse-dynamics:no-gravity+observer")


@pytest.fixture(scope="module")
def arm():
    """As its authors computed it, with rotors too light for the wrist."""
    return lwr_dyn.load("lwr4plus", "computed")


@pytest.fixture(scope="module")
def physical():
    return lwr_dyn.load("lwr4plus", reading="physical")


@pytest.fixture
def move(physical, monkeypatch):
    monkeypatch.setattr(study, "POSES", 3)
    return lwr_dyn.reference("point-to-point", physical, start=POSE, end=POSE + 0.3, duration=0.2)


def test_the_set_is_rigid_with_delays_and_elastic_where_rotors_carry_it(physical, arm, move):
    words = ["rigid, 1000 Hz, delay of 1 sample", *(f"rigid, 1000 Hz, delay of {k} samples" for k in (2, 3, 4))]
    elastic = "elastic (motor encoders), 1000 Hz"
    assert [case.words for case in cases_of(physical, 1000.0, poses_of(move))] == [*words, elastic]
    assert [case.words for case in cases_of(arm, 1000.0, poses_of(move))] == words  # light rotors
    wam = lwr_dyn.load("wam7")
    assert len(cases_of(wam, 1000.0, np.zeros((1, 7)))) == 4  # no stiffness


@pytest.fixture
def searched(monkeypatch):
    """What the search is asked for; 20 rad/s of every law, and none of adaptive."""
    asked = []

    def found(arm, name, cases, **given):
        asked.append((arm, name, cases, given))
        omega_n = None if name == "adaptive" else 20.0
        return TunedFrequency(omega_n, 1.65, given["peak"], cases[1], given["q"][0], 2, len(given["q"]))

    monkeypatch.setattr(study, "largest_omega_n", found)
    return asked


def test_the_search_gets_law_plants_poses_and_options(physical, move, searched, tmp_path):
    (tmp_path / "mine.py").write_text("")
    specs = [controller_spec(text) for text in (*LAWS, "hand-guiding", str(tmp_path / "mine.py"))]
    said = []
    found = tuned_frequencies(physical, specs, move, 1.7, 500.0, said.append)
    assert (list(found), said) == (list(LAWS), [f"tuning {text}" for text in LAWS])
    for (arm, name, cases, given), spec in zip(searched, specs, strict=False):
        assert (arm, name) == (physical, spec.name)
        assert [case.words for case in cases] == [case.words for case in cases_of(physical, 500.0, poses_of(move))]
        assert (given.pop("peak"), given.pop("dynamics").n) == (1.7, 7)
        np.testing.assert_array_equal(given.pop("q"), move.sample(np.array([0.0, 0.1, 0.2])).q)
        assert given == dict(spec.options)


def test_a_study_runs_the_laws_that_keep_the_peak_with_their_gains(physical, move, searched):
    laws, cases = ("adaptive", "inverse-dynamics:xi=0.9"), [plant_case(physical, "nominal")]
    options = (("rate", 500.0), ("duration", 0.02))
    compared, (run,) = ControllerStudy(physical, move, laws, cases, options=options, peak=1.7).run()
    where = "rigid, 500 Hz, delay of 2 samples, joint 3"
    assert compared.failures == (f"adaptive: no omega_n keeps |S_ii| <= 1.7, {where}",)
    assert f"{laws[1]}: omega_n 20 rad/s, where |S_ii| reaches 1.65 of 1.7 ({where})" in compared.notes
    assert list(compared.tuned) == [laws[1]]
    np.testing.assert_allclose(run.meta["controller"]["parameters"]["Kp"], 400.0)
    assert run.meta["note"]["controller_options"] == "xi 0.9, omega_n 20"
    with pytest.raises(LwrDynError, match=r"^tuned: 1\.7; allowed: a higher peak: no controller keeps it"):
        ControllerStudy(physical, move, laws[:1], cases, peak=1.7).run()


BAD = {
    "peak": ("pid", 1.0, "tuned: 1.0; allowed: a peak of |S| above 1"),
    "nan": ("pid", float("nan"), "tuned: nan"),
    "given": ("pid:omega-n=2", 1.7, "omega-n given, which is to be tuned; allowed: without it"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case, physical, move):
    text, peak, words = BAD[case]
    with pytest.raises(LwrDynError) as fault:
        tuned_frequencies(physical, [controller_spec(text)], move, peak)
    assert words in str(fault.value)
    assert "\n" not in str(fault.value)
