"""Gains are found where the optimum is known, the same for a seed, and judged on runs that the search has not seen."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError, UnknownNameError
from lwr_dyn.studies.sweep.gain_search import (
    SearchedGain,
    SearchTrace,
    costs,
    gain_aim,
    paired_ratio,
    search,
    searched_gain,
    values_of,
    verdict,
)
from lwr_dyn.studies.sweep.sampling import VariedParameter
from lwr_dyn.studies.sweep.sweep_study import SweepStudy
from lwr_dyn.studies.sweep.tune import SearchSize, TunedGains, tune

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


def tuned(gains=(OMEGA, XI), evaluate=bowl, size=SIZE, given=GIVEN, aim=AIM, **more):
    return tune(STUDY, "pid", gains, evaluate, given, aim=aim, size=size, **more)


def test_a_known_optimum_is_found():
    found = tuned()
    assert found.values == pytest.approx([BEST_OMEGA, BEST_XI], rel=0.02)
    assert found.keeps_bound
    assert found.check.ratio.high < 0.1
    assert found.check.words == "the found gains are better"
    assert found.check.better.count == SIZE.check
    loads = replace(STUDY, method="random", runs=432, seed=0).values(32, 432)["payload.mass"]
    omega, xi = found.values
    error = (1.0 + loads) * (1e-3 + np.log(omega / BEST_OMEGA) ** 2 + (xi - BEST_XI) ** 2)
    assert found.check.found.value == np.sort(error)[359]
    assert found.check.found_use.value == np.sort(omega / 100.0 + loads / 1000.0)[359]
    assert found.given.tolist() == [50.0, 1.0]


def test_the_bound_is_kept_where_it_ends_the_search_and_where_nothing_keeps_it_that_is_said():
    found = tuned([OMEGA], hyperbola, bound=0.7)
    assert found.trace.use[found.best] <= 0.7
    assert found.values == pytest.approx([70.0], rel=0.01)
    found = tuned([OMEGA], hyperbola, bound=0.01)
    assert not found.keeps_bound
    assert found.values == pytest.approx([5.0], rel=0.05)  # it misses by the least
    assert "no candidate keeps the bound: the one that misses it by the least is shown" in found.document.text()


def test_runs_without_a_number_are_behind_all_others():
    assert 55.0 < tuned([OMEGA], cliff).values[0] <= 60.0


def test_the_front_has_no_candidate_that_another_one_beats():
    found = tuned(size=SearchSize(32, 12, 10, 50, front=2))
    aim, use = found.trace.aim, found.trace.use
    front = found.trace.front
    assert found.best in front
    assert (np.diff(use[front]) > 0.0).all()
    assert (np.diff(aim[front]) < 0.0).all()
    for i in range(aim.size):
        assert ((use[front] <= use[i]) & (aim[front] <= aim[i])).any()


def test_the_front_is_searched_below_the_bound_too():
    size = SearchSize(32, 12, 30, 50, front=3)
    found = tuned(size=size)
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

    found = tuned([OMEGA], rare, SearchSize(8, 6, 2, 400, 0), aim=gain_aim("tip_max:0.99"))
    assert found.keeps_bound
    assert not found.holds
    assert "on these runs the bound is NOT kept" in found.document.text()
    assert not found.document.record()["check"]["keeps_bound"]


def test_the_given_gains_are_the_first_candidate_where_all_are_known():
    size = SearchSize(8, 6, 1, 40, 0)
    assert values_of((OMEGA, XI), tuned(size=size).trace.points[:1])[0] == pytest.approx([50.0, 1.0])
    part = tuned(evaluate=lambda x: bowl({XI.path: 1.0, **x}), size=size, given={OMEGA.path: 50.0})
    assert not np.isclose(values_of((OMEGA, XI), part.trace.points), [50.0, 1.0], rtol=1e-6).all(axis=1).any()
    np.testing.assert_array_equal(part.given, [50.0, np.nan])


def test_the_same_seed_gives_the_same_search():
    one, same, other = (tuned(size=SearchSize(16, 8, 4, 40, 1, seed=s)) for s in (3, 3, 4))
    assert np.array_equal(one.trace.points, same.trace.points)
    assert one.check.ratio.low == same.check.ratio.low
    assert not np.array_equal(one.trace.points, other.trace.points)


def test_the_search_and_its_judgement_meet_other_runs_and_say_how_far_they_are():
    met, said = [], []

    def note(values):
        met.append(values["payload.mass"])
        return bowl(values)

    tuned(evaluate=note, size=SearchSize(16, 8, 2, 40, 1), report=said.append)
    searched = {tuple(part) for loads in met[:-2] for part in loads.reshape(-1, 16)}
    assert len(searched) == 1  # common random numbers
    assert np.array_equal(met[-1], met[-2])
    assert met[-1].size == 40
    assert not np.isin(met[-1], met[0]).any()
    assert said == pytest.approx([1 / 6, 2 / 6, 3 / 6, 4 / 6, 5 / 6, 1.0])  # three generations of two searches


def test_a_search_begins_at_its_start_and_ends_with_the_best_of_its_trace():
    trace = SearchTrace(lambda x: (((x - 0.3) ** 2).sum(axis=1), x[:, 0]), np.zeros((0, 2)))
    start = [np.array([0.9, 0.1]), np.array([0.2, 0.8])]
    best = search(trace, start, 0.25, population=8, generations=20, seed=0)
    np.testing.assert_allclose(trace.points[:2], start, rtol=1e-15)
    assert best == trace.best(0.25) == np.argmin(np.where(trace.use <= 0.25, trace.aim, np.inf))
    assert trace.points[best] == pytest.approx([0.25, 0.3], abs=0.02)
    with pytest.raises(OptionError, match="no judge"):
        search(SearchTrace(refused, np.zeros((0, 1))), [], 1.0, population=5, generations=1, seed=0)


def refused(_):
    raise OptionError("no judge", 1, "another")


def test_candidates_are_ordered_by_the_bound_first():
    aim, use = np.array([3.0, 1.0, 2.0, np.inf, 1.0, 2.5]), np.array([0.5, 0.9, 0.7, 0.1, np.nan, 0.8])
    assert costs(aim, use, 0.8).tolist() == [3.0, pytest.approx(1.1e12), 2.0, 1e30, 1e12 * (1 + 1e6), 2.5]
    assert costs(aim, use, np.inf).tolist() == [3.0, 1.0, 2.0, 1e30, 1.0, 2.5]
    trace = SearchTrace(None, np.zeros((6, 1)), aim, use)
    assert (trace.best(0.8), trace.best(np.inf), trace.front.tolist()) == (2, 1, [0, 2, 1])


X = np.arange(1.0, 101.0)


def by_hand(points, aims, uses, best, **more):
    """What a search might have found; of 100 runs the median is the 50th, its interval from the 40th to the 61st."""
    check = verdict(2e-3 * X / 50, 1e-3 * X / 50, 0.01 * X, 0.02 * X, 0.5, 0)
    gains = SearchedGain(OMEGA.path, 5.0, 500.0), SearchedGain(XI.path, 0.0, 2.0)
    trace = SearchTrace(None, points, aims, uses)
    made = {"aim": gain_aim("tip_max:0.5"), "bound": 0.8, "size": SearchSize(runs=8), "given": np.array([np.nan, 1.0])}
    return TunedGains("s", "pid", gains, trace=trace, best=best, check=check, **(made | more))


def test_the_document_says_what_was_found():
    points = np.array([[0.5, 0.5], [0.0, 0.25], [1.0, 1.0], [0.5, 0.0], [0.25, 0.75]])
    aim, use = np.array([2e-3, 8e-3, 1e-3, 5e-3, np.inf]), np.array([0.5, 0.2, 0.9, 0.4, 0.1])
    found = by_hand(points, aim, use, 0)
    assert found.document.text().splitlines() == DOCUMENT
    record = found.document.record()
    ends = {"given": (2e-3, 0.5), "found": (1e-3, 1.0)}
    for name, (error, share) in ends.items():
        for key, value in (("aim", error), ("torque_use", share)):
            interval = {"value": value, "low": value * 0.8, "high": value * 1.22}
            assert record["check"][name][key] == pytest.approx(interval)
    values = [{OMEGA.path: x, XI.path: y} for x, y in ((5.0, 0.5), (50.0, 0.0), (50.0, 1.0), (500.0, 2.0))]
    order = [1, 3, 0, 2]
    assert record["front"] == [
        {"gains": pytest.approx(x), "aim": aim[k], "torque_use": use[k]} for k, x in zip(order, values, strict=True)
    ]  # fmt: skip
    assert record["search"] == {
        "candidates": 5, "runs": 8, "seed": 0, "aim": 2e-3, "torque_use": 0.5, "keeps_bound": True,
    }  # fmt: skip
    worst = by_hand(points, aim, use, 2, aim=gain_aim("tip_max:0.9"), bound=np.inf)
    said = worst.document.text().splitlines()
    assert said[1] == "aim: least 90 % quantile over runs: error of the tip, largest"
    assert said[3] == "of 8 runs, the 90 % quantile is the worst"
    assert (worst.keeps_bound, by_hand(points, aim, use, 4).keeps_bound) == (True, False)


DOCUMENT = """\
s, pid: omega_n 5 to 500, xi 0 to 2
aim: least 50 % quantile over runs: error of the tip, largest; the same quantile of the torque use at most 80 %
search: differential evolution, 5 candidates, each on the same 8 runs, seed 0

on 100 runs that the search has not seen, intervals of 95 %
gains  omega_n  xi  error of the tip, largest, 50 % [mm]  torque use [%]
-----  -------  --  ------------------------------------  ---------------
given           1   2 (1.6 to 2.44)                       50 (40 to 61)
found  50       1   1 (0.8 to 1.22)                       100 (80 to 122)
found / given: 0.5 (0.5 to 0.5); less error in 100 % of the runs: the found gains are better
on these runs the bound is NOT kept: more --runs find gains that keep it

Pareto front of the candidates, on the runs of the search: 4 of 4
omega_n  xi   error of the tip, largest, 50 % [mm]  torque use [%]
-------  ---  ------------------------------------  --------------  -----
5        0.5  8                                     20
50       0    5                                     40
50       1    2                                     50              found
500      2    1                                     90""".splitlines()


def test_of_a_long_front_eight_are_shown_and_what_was_found():
    k = np.arange(20.0)
    found = by_hand(np.column_stack([k / 19, k / 19]), 1.0 / (1.0 + k), k / 20, 1)
    text = found.document.text()
    assert "on the runs of the search: 9 of 20" in text
    shown = [line.split()[3:] for line in text.splitlines()[-9:]]
    rows = [0, 1, 3, 5, 8, 11, 14, 16, 19]
    assert shown == [[f"{5 * x}", *["found"] * (x == 1)] for x in rows]


@pytest.mark.parametrize(
    ("gain", "share", "value"),
    [
        (OMEGA, 0.5, 1000**0.5),
        (XI, 1.0, 2.0),
        (searched_gain("a.b=-1:3"), 0.25, 0.0),
        (searched_gain("z=0:2"), 0.3, 0.6),
    ],
)
def test_a_gain_above_zero_is_searched_by_its_logarithm(gain, share, value):
    assert gain.value(np.array([share])) == pytest.approx([value], abs=1e-12)
    assert gain.share(value) == pytest.approx(share)
    assert (gain.share(gain.low - 1.0), gain.share(gain.high + 1.0)) == (0.0, 1.0)


def test_a_gain_is_read_with_its_bounds():
    assert searched_gain(" omega-n = 5 : 200 ") == SearchedGain("controller.omega_n", 5.0, 200.0)
    assert searched_gain("payload.known=0:1") == SearchedGain("payload.known", 0.0, 1.0)
    assert (OMEGA.name, searched_gain("payload.known=0:1").name) == ("omega_n", "payload.known")


@pytest.mark.parametrize(
    ("read", "text", "error", "words"),
    [
        *((searched_gain, text, OptionError, "PATH=LOW:HIGH") for text in ("omega_n", "omega_n=5", "x=a:b", "=1:2")),
        *((searched_gain, f"omega_n={text}", OptionError, "low < high") for text in ("200:5", "5:inf", "5:5")),
        *((gain_aim, f"tip_max{text}", OptionError, "METRIC:SHARE") for text in ("", ":most")),
        *((gain_aim, f"tip_max:{text}", OptionError, "between 0 and 1") for text in (1, 0)),
        (gain_aim, "limit_margin:0.9", OptionError, "a metric that is to be small"),
        (gain_aim, "tip_mx:0.9", UnknownNameError, "tip_max"),
    ],
)  # fmt: skip
def test_bad_bounds_and_aims_are_refused(read, text, error, words):
    with pytest.raises(error, match=words):
        read(text)


def test_other_bad_input_is_refused():
    for gains, bound, words in (
        ([], 1.0, "gains: none; allowed: one or more"), ([OMEGA, XI, OMEGA], 1.0, "gains: controller.omega_n twice"),
        ([OMEGA], 0.0, "torque bound: 0.0; allowed: a share"), ([OMEGA], np.nan, "torque bound: nan"),
    ):  # fmt: skip
        with pytest.raises(OptionError, match=words):
            tuned(gains, bound=bound)
    assert SearchSize() == SearchSize(64, 16, 20, 1000, 3, 0)
    with pytest.raises(OptionError, match="seed: -1; allowed: a whole number from 0 on"):
        SearchSize(seed=-1)
    for name, (least, most) in {
        "runs": (8, 100_000), "population": (5, 1000), "generations": (1, 10_000), "check": (8, 1_000_000),
        "front": (0, 20),
    }.items():  # fmt: skip
        assert [getattr(SearchSize(**{name: x}), name) for x in (least, most)] == [least, most]
        for bad in (least - 1, most + 1):
            with pytest.raises(OptionError, match=f"^{name}: {bad}; allowed: a whole number from {least} to {most}$"):
                SearchSize(**{name: bad})


FEW = " on these runs, too few to bound the quantile"


@pytest.mark.parametrize(
    ("runs", "share", "factor", "words"),
    [
        (1000, 0.9, 0.99, "the found gains are better"), (1000, 0.9, 1.01, "the given gains are better"),
        (1000, 0.9, 1.0, "the runs do not tell them apart"), (1000, 0.999, 0.99, f"the found gains are better{FEW}"),
        (1000, 0.999, 1.01, f"the given gains are better{FEW}"), (20, 0.5, 0.99, "the found gains are better"),
        (19, 0.5, 0.99, f"the found gains are better{FEW}"), (19, 0.5, 0.1, "the found gains are better"),
        (19, 0.5, 10.0, "the given gains are better"),
    ],
)  # fmt: skip
def test_a_verdict_says_what_its_runs_bear(runs, share, factor, words):
    """99.9 % of 1000 runs is the second worst: the bootstrap knows two runs there, and their intervals are open."""
    given = np.linspace(1.0, 2.0, runs)
    found = verdict(given, factor * given, 3.0 * given, 4.0 * given, share, 0)
    assert found.words == words
    place = int(np.ceil(share * runs - 1e-9)) - 1
    quantiles = [found.given, found.found, found.given_use, found.found_use]
    assert [one.value for one in quantiles] == [x * given[place] for x in (1.0, factor, 3.0, 4.0)]
    assert found.better.count == (runs if factor < 1.0 else 0)


def test_a_ratio_of_quantiles_has_the_percentiles_of_resampled_pairs():
    given = np.random.default_rng(1).random(40)
    rng, ratios = np.random.default_rng(7), []
    for _ in range(2000):
        rows = rng.integers(0, 40, 40)
        ratios.append(np.sort(given[rows] ** 2)[29] / np.sort(given[rows])[29])
    found = paired_ratio(given, given**2, 0.75, 7)
    assert found.value == pytest.approx(np.sort(given)[29], rel=1e-12)
    assert (found.low, found.high) == pytest.approx((np.sort(ratios)[50], np.sort(ratios)[1949]), rel=1e-12)


@pytest.mark.parametrize(
    ("given", "found", "ratio"),
    [(np.inf, np.inf, 1.0), (np.inf, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, np.inf), (2.0, 1.0, 0.5)],
)
def test_a_ratio_over_nothing_or_over_no_number(given, found, ratio):
    one = paired_ratio(np.full(5, given), np.full(5, found), 0.5, 0)
    assert (one.value, one.low, one.high) == (ratio,) * 3
