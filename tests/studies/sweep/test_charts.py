"""The charts of a study's page, of a few runs by hand: where bars, lines and limits stand, and what is said of them."""

import re

import numpy as np
import pytest

from lwr_dyn.pages.figures.figure import Axis, axis_of, frequency_axis
from lwr_dyn.studies.sweep import charts
from lwr_dyn.studies.sweep.influence import Influence, PartQuantile, SobolIndices
from lwr_dyn.studies.sweep.intervals import IntervalEstimate, QuantileEstimate, quantile_of
from lwr_dyn.studies.sweep.outwards import FirstBreak, OutwardSearch
from lwr_dyn.studies.sweep.summary import MetricFigures
from lwr_dyn.studies.sweep.vocabulary import metric_words

TEN = np.arange(1.0, 11.0)
PLAIN = Axis(0.0, 10.0, (0.0, 5.0, 10.0))


def figures(sample, bound=None, name="tip_max", influence=(), shares=(0.5, 0.95)):
    """Of a sample in mm."""
    words = metric_words(name)
    values = words.badness(1e-3 * np.asarray(sample, dtype=float))
    return MetricFigures(words, values, values, tuple(quantile_of(values, x) for x in shares), tuple(influence), bound)


@pytest.mark.parametrize(
    ("bound", "ends"),
    [
        (None, (11.01, 20.99)), (np.inf, (11.01, 20.99)), (22e-3, (11.01, 22.88)), (41.9e-3, (11.01, 1.04 * 41.9)),
        (42e-3, (11.01, 20.99)), (5.51e-3, (5.51, 20.99)), (5.50e-3, (11.01, 20.99)),
    ],
)  # fmt: skip
def test_an_axis_has_nearly_all_runs_and_the_limit_if_it_is_near(bound, ends):
    """A thousandth of eleven values is 0.01 of the step between them."""
    found, wanted = charts.values_axis([figures(range(11, 22), bound)]), axis_of(np.array(ends), 8, 0.02)
    assert [found.low, found.high, *found.ticks] == pytest.approx([wanted.low, wanted.high, *wanted.ticks])


@pytest.mark.parametrize(
    ("samples", "wanted"),
    [
        ([[1, 25]], frequency_axis(np.array([1.024, 24.976]))),
        *(
            (samples, axis_of(np.array(ends), 8, 0.02))
            for samples, ends in {
                ((1, 20),): (1.019, 19.981), ((-1, 30),): (-0.969, 29.969), ((np.inf,),): (0.0, 1.0),
                ((2, 2), (2,)): (1.8, 2.2),
                ((3, 4, np.inf), (1, 2)): (1.001, 3.999),
            }.items()
        ),
    ],
)  # fmt: skip
def test_an_axis_of_wide_spread_is_logarithmic(samples, wanted):
    found = charts.values_axis([figures(one) for one in samples])
    assert found.is_logarithmic is wanted.is_logarithmic
    assert [found.low, found.high, *found.ticks] == pytest.approx([wanted.low, wanted.high, *wanted.ticks])


def test_one_value_of_all_runs_is_a_sentence():
    same, margin = figures([2, 2], 3e-3), figures([500, 500], 0.2, "limit_margin")
    assert charts.same_words([same]) == "2 mm in all 2 runs; limit 3 mm."
    assert charts.same_words([same, figures([2])]) == "2 mm in all 3 runs of 2 controllers; limit 3 mm."
    assert charts.same_words([margin]) == "500 mrad or mm in all 2 runs; limit 200 mrad or mm."
    assert charts.same_words([figures([2])]) == "2 mm in all 1 runs; no limit set."
    assert [charts.same_words([figures(x)]) for x in ([2, 2, 3], [np.inf, np.inf])] == ["", ""]


def test_a_limit_stands_in_the_picture_if_it_is_on_the_axis():
    words = [charts.limit_words([figures(range(1, 12), bound)]) for bound in (12e-3, 23e-3, None)]
    assert words == ["limit 12 mm", "limit 23 mm, beyond the axis", "no limit set"]
    marks = [charts.limit_mark(figures([1], bound), PLAIN) for bound in (0.0, 4e-3, 10e-3, 10.1e-3, -1e-4, None)]
    assert marks == [*(f'<i class="limit" style="left:{x}.00%"></i>' for x in (0, 40, 100)), "", "", ""]


def test_a_histogram_counts_every_run_and_says_how_many_it_does_not_show():
    """Of 1 and 2 mm on an axis from 0.98 to 2.10 mm; the largest bin is the whole height."""
    text = charts.histograms_html({"a": figures([1] * 1500 + [2] * 3000 + [0.5, 9, np.inf], 2e-3)}, {"a": "r1"})
    steps = re.findall(r"V(\d+)H(\d+)", re.search(r'class="bars" d="M0,1000(.*)V1000Z"', text)[1])
    assert [int(across) for _, across in steps] == [round(2000 * k / 60) for k in range(1, 61)]
    assert {k: int(down) for k, (down, _) in enumerate(steps) if down != "1000"} == {1: 500, 54: 0}
    assert "<small>3 of 4503 beyond the axis</small>" in text
    assert '<i class="limit" style="left:90.95%"></i>' in text  # of an axis to 1.04 times the limit
    assert re.findall(r"<li>(.*?)</li>", text) == [
        "median <b>2</b><small>[2 to 2]</small>", "95 % <b>2</b><small>[2 to 2]</small>",
    ]  # fmt: skip
    assert "beyond" not in charts.histograms_html({"a": figures([1, 2])}, {"a": "r1"})


def test_a_curve_is_the_share_of_the_runs_at_least_as_bad_and_leaves_the_plane_with_those_beyond():
    up = Axis(0.1, 1.0, (1.0, 0.1), True)
    down = [round(-1000 * np.log10(share)) for share in np.arange(10, 0, -1) / 10]
    whole = "M" + " ".join(f"{200 * k},{y}" for k, y in enumerate(down, 1))
    assert charts._curve(figures(TEN), PLAIN, up) == whole
    lost = "M" + " ".join(f"{200 * k},{y}" for k, y in enumerate(down[:7], 1)) + f" 2000,{down[7]}"
    for beyond in ([8, 8.5, 9], [np.inf] * 3):
        sample = [*TEN[:7], *(10 * x for x in beyond)]
        assert charts._curve(figures(sample), PLAIN, up) == lost
    margin = figures(TEN, name="limit_margin")
    assert charts._curve(margin, PLAIN, up) == "M" + " ".join(f"{2000 - 200 * k},{y}" for k, y in enumerate(down))
    many = charts._curve(figures(np.arange(10_000) / 1000), PLAIN, Axis(1e-4, 1.0, (), True)).split()
    assert (len(many), many[0], many[-1]) == (
        np.unique(np.rint(np.geomspace(1, 10_000, 240))).size,
        "M0,0",
        "2000,1000",
    )


def test_the_share_of_the_worst_has_ticks_limit_and_intervals():
    one = figures(TEN, 5e-3, shares=(0.5, 0.95))
    text = charts.worst_share_html({"a": one}, {"a": "r1"}, True)
    axis = charts.values_axis([one])
    low, high = (round(2000 * float(axis.share(x))) for x in (2.0, 9.0))  # of the median, by order statistics
    assert f'<path class="r1 bar" d="M{low},301H{high}M' in text
    last = re.search(r'bar" d="M[^"]*M(\d+),(\d+)H(\d+)"', text).groups()
    assert last == (f"{round(2000 * float(axis.share(8)))}", "1000", "2000")  # at the worst of ten
    assert re.findall(r'top:([\d.]+)%">([^<]+)', text) == [("0.0", "100 %"), ("100.0", "10 %")]
    assert charts.limit_mark(one, axis) in text
    assert "bar" not in charts.worst_share_html({"a": one}, {"a": "r1"}, False)


def influence(path, low, high, chance=0.0, rho=None, along=()):
    """Two parts, whose quantiles have intervals from 1 mm below to 1 mm above."""
    parts = [
        PartQuantile(x, x + 1.0, QuantileEstimate(0.95, 1e-3 * v, 1e-3 * (v - 1), 1e-3 * (v + 1), 9, 0, 9))
        for x, v in ((0.0, low), (1.0, high))
    ]
    return Influence(path, tuple(parts), chance, rho, along)


def test_a_bar_goes_from_the_best_part_to_the_worst():
    rho = IntervalEstimate(-0.5, -0.6, -0.4)
    rows = [influence("a", 8, 2, 0.04, rho), influence("b", 4, 6, 0.06, along=("a", "c"))]
    text = charts.tornado_html(figures([5] * 20, influence=rows), {"a": "kg"})
    left = [100 * (x - 1.64) / 6.72 for x in range(10)]  # of an axis from 2 to 8 mm, and 6 % of that beyond
    assert f'style="--centre:{left[5]:.2f}%"' in text
    bars = re.findall(r'<i class="([^"]+)" style="left:([\d.]+)%;width:([\d.]+)%"', text)
    assert [(kind, float(a), float(b)) for kind, a, b in bars] == [
        (kind, pytest.approx(left[a], abs=0.01), pytest.approx(min(left[b], 100) - left[a], abs=0.01))
        for kind, a, b in (("bar", 2, 8), ("whisker", 7, 9), ("bar hollow", 4, 6), ("whisker", 5, 7))
    ]
    assert re.findall(r'class="what">([^<]*)</div>.*?class="about">([^<]*)</div>', text) == [
        ("a", "2 at 1 to 2 kg, 8 at 0 to 1 kg; rank correlation \u22120.50".replace("\u2212", "-")),
        ("b", "4 at 0 to 1, 6 at 1 to 2; could be chance; may be the effect of a, c, which it follows in these runs"),
    ]  # fmt: skip
    assert "with less effect" not in text
    many = charts.tornado_html(figures([5] * 20, influence=rows[:1] * 12), {})
    assert (many.count('class="bar-row"'), "2 more, with less effect." in many) == (10, True)
    assert charts.tornado_html(figures([5] * 20), {}).startswith('<p class="note">Too few runs')
    margin = charts.tornado_html(figures([5] * 20, name="limit_margin", influence=rows[:1]), {})
    assert "-2 at 1 to 2, -8 at 0 to 1; rank correlation +0.50".replace("-", "\u2212") in margin


def test_indices_are_drawn_as_large_as_they_are():
    def one(value):
        return IntervalEstimate(value, value - 0.1, value + 0.1)

    first, total = {"a": one(-0.02), "b": one(0.25)}, {"a": one(0.3), "b": one(0.95)}
    text = charts.indices_html(SobolIndices("tip_max", first, total, 64, 2))
    assert re.findall(r'class="what">(\w)</div>', text) == ["b", "a"]
    assert re.findall(r'<i class="([^"]+)" style="left:([\d.]+)%?;width:([\d.]+)%"', text) == [
        ("bar first", "0", "25.00"), ("whisker first", "15.00", "20.00"),
        ("bar hollow total", "0", "95.00"), ("whisker total", "85.00", "15.00"),
        ("bar first", "0", "0.00"), ("whisker first", "0.00", "8.00"),
        ("bar hollow total", "0", "30.00"), ("whisker total", "20.00", "20.00"),
    ]  # fmt: skip
    assert "alone 0.25 [0.15 to 0.35], with interactions 0.95 [0.85 to 1.05]" in text
    assert "64 groups of runs, 2 left out; intervals of 95 % by bootstrap." in text
    assert re.findall(r'left:([\d.]+)%">([\d.]+)<', text) == [(f"{25 * k}.0", f"{0.25 * k:.2f}") for k in range(5)]
    assert "64 groups of runs; intervals" in charts.indices_html(SobolIndices("tip_max", first, total, 64, 0))
    assert charts.indices_html(None) == '<p class="note">Too few complete groups.</p>'


def test_gauges_end_where_a_limit_breaks():
    lines = FirstBreak("a<b", 7.0, 0.625, 4.2, 4.375, "tip_max"), FirstBreak("c", 0.8), FirstBreak("d", 2.0)
    assert charts.outwards_html(OutwardSearch(lines, 33)) == (
        '<div class="bars-of"><div class="bar-row"><div class="what">a&lt;b</div><div class="track">'
        '<i class="bar" style="left:0;width:62.50%"></i><i class="limit" style="left:62.50%"></i></div>'
        '<div class="about">tip_max kept at 4.2, broken at 4.375, 62 % of the way to 7</div></div></div>'
        '<p class="note">Keep every limit alone: c to 0.8, d to 2. 33 runs of their own.</p>'
    )
    assert '<p class="note">33 runs of their own.' in charts.outwards_html(OutwardSearch(lines[:1], 33))
    assert charts.outwards_html(OutwardSearch((), 1, ("a", "b"))) == (
        '<p class="note bad">Broken with every parameter at its nominal value: a, b.</p>'
    )


def test_a_run_stands_where_its_values_are():
    numbers = charts._axis("a", np.array([0.0, 7.0, 3.5]), "kg")
    assert (numbers.name, numbers.ends, numbers.places.tolist()) == ("a", ("0", "7 kg"), [0.0, 1.0, 0.5])
    names = charts._axis("r", np.array(["b", "a", "c"]), "")
    assert (names.ends, names.places.tolist()) == (("a", "c"), [0.5, 0.0, 1.0])
    one = charts._axis("r", np.array(["b", "b"]), "")
    same = charts._axis("a", np.array([2.0, 2.0]), "")
    assert (one.places.tolist(), same.places.tolist(), same.ends) == ([0.0, 0.0], [0.5, 0.5], ("2", "2"))
    tip = charts.metric_axis(figures([1, 2, np.inf]), [figures([1, 2])])
    assert (tip.name, tip.ends) == ("error of the tip, largest", ("0.981", "2.02 mm"))
    assert tip.places == pytest.approx([0.0183, 0.9817, 1.0], abs=1e-3)
    margin = charts.metric_axis(figures([1, 2, np.nan], name="limit_margin"), [figures([1, 2], name="limit_margin")])
    assert margin.places == pytest.approx([0.0183, 0.9817, 0.0], abs=1e-3)
