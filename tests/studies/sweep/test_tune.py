"""Gains are found where the optimum is known, the same for a seed, and judged on runs that the search has not seen."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError, UnknownNameError
from lwr_dyn.studies.sweep.gain_search import gain_aim, searched_gain, values_of, verdict
from lwr_dyn.studies.sweep.sampling import VariedParameter
from lwr_dyn.studies.sweep.sweep_study import SweepStudy
from lwr_dyn.studies.sweep.tune import SearchSize, tune

LOAD = VariedParameter("payload.mass", "uniform", ("payload.mass",), low=0.0, high=7.0)
STUDY = SweepStudy("stand-in", "lwr4plus", "", ("pid",), "hold", parameters=(LOAD,))
OMEGA, XI = searched_gain("omega_n=5:200"), searched_gain("xi=0.2:2")
GIVEN = {OMEGA.path: 50.0, XI.path: 1.0}
AIM = gain_aim("tip_max:0.9")
SIZE = SearchSize(runs=32, population=12, generations=30, check=400, front=0)
BEST_OMEGA, BEST_XI = 80.0, 0.7
"""Of the bowl."""


def bowl(values):
    """An error with one least point, whatever the load, and a torque that grows with omega_n."""
    omega, xi, load = values[OMEGA.path], values[XI.path], values["payload.mass"]
    error = (1.0 + load) * (1e-3 + np.log(omega / BEST_OMEGA) ** 2 + (xi - BEST_XI) ** 2)
    return {"tip_max": error, "torque_use": omega / 100.0 + load / 1000.0}


def hyperbola(values):
    """An error that falls with omega_n as the torque grows: only the bound ends it."""
    omega = values[OMEGA.path]
    return {"tip_max": 1.0 / omega + 0.0 * values["payload.mass"], "torque_use": omega / 100.0}


def cliff(values):
    """No number above 60 rad/s, where a loop turns unstable; before it the error falls."""
    omega = values[OMEGA.path]
    return {"tip_max": np.where(omega > 60.0, np.nan, 1.0 / omega), "torque_use": omega / 1e3}


def test_a_known_optimum_is_found():
    found = tune(STUDY, "pid", [OMEGA, XI], bowl, GIVEN, aim=AIM, size=SIZE)
    assert found.values == pytest.approx([BEST_OMEGA, BEST_XI], rel=0.02)
    assert found.keeps_bound
    assert found.check.ratio.high < 0.1
    assert found.check.words == "the found gains are better"
    assert found.check.better.count == SIZE.check


def test_the_bound_is_kept_where_it_ends_the_search():
    found = tune(STUDY, "pid", [OMEGA], hyperbola, GIVEN, aim=AIM, bound=0.7, size=SIZE)
    assert found.trace.use[found.best] <= 0.7
    assert found.values == pytest.approx([70.0], rel=0.01)


def test_a_bound_that_nothing_keeps_is_said():
    found = tune(STUDY, "pid", [OMEGA], hyperbola, GIVEN, aim=AIM, bound=0.01, size=SIZE)
    assert not found.keeps_bound
    assert found.values == pytest.approx([5.0], rel=0.05)  # it misses by the least


def test_runs_without_a_number_are_behind_all_others():
    found = tune(STUDY, "pid", [OMEGA], cliff, GIVEN, aim=AIM, size=SIZE)
    assert 55.0 < found.values[0] <= 60.0


def test_the_front_has_no_candidate_that_another_one_beats():
    found = tune(STUDY, "pid", [OMEGA, XI], bowl, GIVEN, aim=AIM, size=SearchSize(32, 12, 10, 50, front=2))
    aim, use = found.trace.aim, found.trace.use
    front = found.trace.front
    assert found.best in front
    assert (np.diff(use[front]) > 0.0).all()
    assert (np.diff(aim[front]) < 0.0).all()
    for i in range(aim.size):
        assert ((use[front] <= use[i]) & (aim[front] <= aim[i])).any()


def test_the_front_is_searched_below_the_bound_too():
    size = SearchSize(32, 12, 30, 50, front=3)
    found = tune(STUDY, "pid", [OMEGA, XI], bowl, GIVEN, aim=AIM, size=size)
    aim, use = found.trace.aim, found.trace.use
    load = AIM.of(replace(STUDY, method="random").values(0, 32)["payload.mass"])
    for bound in np.linspace(use[found.trace.front[0]], use[found.best], 5)[1:-1]:
        omega = 100.0 * (bound - load / 1000.0)
        least = (1.0 + load) * (1e-3 + np.log(omega / BEST_OMEGA) ** 2)
        assert aim[use <= bound].min() == pytest.approx(least, rel=0.05)


def test_a_bound_that_only_the_runs_of_the_search_keep_is_said():
    def rare(values):
        """Torque that a rare load takes: none of the first eight runs has it."""
        return {**hyperbola(values), "torque_use": np.where(values["payload.mass"] > 6.5, 2.0, 0.1)}

    found = tune(STUDY, "pid", [OMEGA], rare, GIVEN, aim=gain_aim("tip_max:0.99"), size=SearchSize(8, 6, 2, 400, 0))
    assert found.keeps_bound
    assert not found.holds
    assert "on these runs the bound is NOT kept" in found.document.text()
    assert not found.document.record()["check"]["keeps_bound"]


def test_the_given_gains_are_the_first_candidate():
    found = tune(STUDY, "pid", [OMEGA, XI], bowl, GIVEN, aim=AIM, size=SearchSize(8, 6, 1, 40, 0))
    assert values_of(found.gains, found.trace.points[:1])[0] == pytest.approx([50.0, 1.0])
    for gain in (OMEGA, searched_gain("payload.known=0:1")):
        assert gain.share(float(gain.value(np.array(0.3)))) == pytest.approx(0.3)


def test_the_same_seed_gives_the_same_search():
    one, same, other = (
        tune(STUDY, "pid", [OMEGA, XI], bowl, GIVEN, aim=AIM, size=SearchSize(16, 8, 4, 40, 1, seed=s))
        for s in (3, 3, 4)
    )
    assert np.array_equal(one.trace.points, same.trace.points)
    assert one.check.ratio.low == same.check.ratio.low
    assert not np.array_equal(one.trace.points, other.trace.points)


def test_the_search_and_its_judgement_meet_other_runs():
    met = []

    def note(values):
        met.append(values["payload.mass"])
        return bowl(values)

    tune(STUDY, "pid", [OMEGA, XI], note, GIVEN, aim=AIM, size=SearchSize(16, 8, 2, 40, 0))
    searched = {tuple(part) for loads in met[:-2] for part in loads.reshape(-1, 16)}
    assert len(searched) == 1  # common random numbers
    assert np.array_equal(met[-1], met[-2])
    assert met[-1].size == 40
    assert not np.isin(met[-1], met[0]).any()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("omega_n", "PATH=LOW:HIGH"),
        ("omega_n=5", "PATH=LOW:HIGH"),
        ("omega_n=a:b", "PATH=LOW:HIGH"),
        ("omega_n=200:5", "low < high"),
        ("omega_n=5:inf", "low < high"),
    ],
)
def test_bad_bounds_are_refused(text, words):
    with pytest.raises(OptionError, match=words):
        searched_gain(text)


@pytest.mark.parametrize("text", ["tip_max", "tip_max:1", "tip_max:0", "tip_max:most", "limit_margin:0.9"])
def test_a_bad_aim_is_refused(text):
    with pytest.raises(OptionError):
        gain_aim(text)


def test_an_unknown_metric_is_refused():
    with pytest.raises(UnknownNameError, match="tip_max"):
        gain_aim("tip_mx:0.9")


def test_other_bad_input_is_refused():
    for gains, bound in (([], 1.0), ([OMEGA, OMEGA], 1.0), ([OMEGA], 0.0)):
        with pytest.raises(OptionError):
            tune(STUDY, "pid", gains, bowl, GIVEN, aim=AIM, bound=bound, size=SIZE)
    for bad in ({"runs": 0}, {"population": 2}, {"generations": 0}, {"check": 0}, {"front": -1}, {"seed": -1}):
        with pytest.raises(OptionError):
            SearchSize(**bad)


def test_few_runs_beyond_a_quantile_judge_only_themselves():
    """99.9 % of 1000 runs is the second worst: the bootstrap knows two runs there, and their intervals are open."""
    given = np.linspace(1.0, 2.0, 1000)
    found = verdict(given, 0.99 * given, given, given, 0.999, 0)
    assert found.ratio.high < 1.0
    assert found.words == "the found gains are better on these runs, too few to bound the quantile"
    assert verdict(given, 0.99 * given, given, given, 0.9, 0).words == "the found gains are better"
