"""The report of a study: its numbers, its charts at the right places, names escaped, no request, axe on all screens."""

import re
from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.studies.sweep import charts, report_page
from lwr_dyn.studies.sweep.intervals import share_text
from lwr_dyn.studies.sweep.running.sweep import sweep
from lwr_dyn.studies.sweep.running.sweep_folder import SweepResults
from lwr_dyn.studies.sweep.summary import summarise
from lwr_dyn.studies.sweep.summary_document import quantile_text
from tests.axe import SCREENS, faint_texts, seen, sideways, violations
from tests.headless import logs, screenshot, waiting
from tests.pages.replay.replayed import lagging_run
from tests.studies.sweep.made_up import CONTROLLERS, evaluate, runs_of, study
from tests.studies.sweep.small import LAW, OWN, small_study

BAD = '<img src=x onerror="alert(1)">'
FIRST = CONTROLLERS[0]
INKS = {name: f"r{k + 1}" for k, name in enumerate(CONTROLLERS)}


@pytest.fixture(scope="module")
def summary(arm):
    made = replace(study(1024), limits={"tip_max": 0.6e-3, "limit_margin": 0.05})
    return summarise(made, runs_of(made), evaluate, arm)


@pytest.fixture(scope="module")
def worst(summary, arm):
    chosen = summary.worst()[:3]
    return [report_page.WorstRun(*one, lagging_run(arm, 0.01 * (k + 1), "pid"), arm) for k, one in enumerate(chosen)]


@pytest.fixture(scope="module")
def opened(summary, worst, browser, tmp_path_factory):
    two = replace(summary, controllers={name: summary.controllers[name] for name in CONTROLLERS[:2]})
    file = tmp_path_factory.mktemp("report") / "report.html"
    file.write_text(report_page.report_html(two, worst), encoding="utf-8")
    browser.get("about:blank")
    logs(browser)
    browser.get(file.as_uri())
    return browser


def tip_figures(summary):
    """The first metric of every controller."""
    return {name: one.metrics["tip_max"] for name, one in summary.controllers.items()}


@pytest.mark.slow
def test_every_number_of_the_summary_stands_in_it_with_its_interval(summary, worst):
    text = report_page.report_html(summary, worst)
    plain = re.sub(r"<[^>]+>", " ", text).replace("  ", " ")
    for one in summary.controllers.values():
        assert share_text(one.within) in plain
        for figures in one.metrics.values():
            for found in figures.quantiles:
                value, interval = quantile_text(figures.words, found).split(" [")
                assert f"{value} [{interval}" in plain
    assert "1024 runs a controller on the same plants" in text
    assert "without stick and without stops" in text
    assert text == report_page.report_html(summary, worst)


def test_names_are_escaped_and_nothing_is_loaded(summary):
    made = replace(summary.study, name=BAD, controllers=(BAD,))
    text = report_page.report_html(summarise(made, {BAD: runs_of(summary.study)[FIRST]}))
    assert "<img" not in text
    assert "&lt;img" in text
    assert "<script" not in text
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", text)
    assert re.findall(r"url\((?!data:)", text) == []


def test_greys_differ_by_their_dashes(summary):
    names = ("pid", "pd-gravity", "inverse-dynamics", "robust", "adaptive", "pid:omega-n=30", "pid:omega-n=40")
    many = replace(summary, controllers=dict.fromkeys(names, summary.controllers[FIRST]))
    inks = report_page.controller_inks(many)
    assert len(set(inks.values())) == len(names)
    assert [inks[name] for name in names[:3]] == ["r3", "r2", "r1"]


def test_a_histogram_counts_every_run_and_says_how_many_it_does_not_show(summary):
    figures = tip_figures(summary)
    axis, one = charts.values_axis(list(figures.values())), figures[CONTROLLERS[1]]
    shown = 1e3 * one.sample
    beyond = int((~((shown >= axis.low) & (shown <= axis.high))).sum())
    text = charts.histograms_html(figures, INKS)
    assert f"{beyond} of 1024 beyond the axis" in text
    heights = [1000 - int(v) for v in re.findall(r"V(\d+)H", re.findall(r'class="bars" d="([^"]+)"', text)[1])]
    counts, _ = np.histogram(axis.share(shown[np.isfinite(shown)]), bins=60, range=(0.0, 1.0))
    np.testing.assert_allclose(heights, 1000 * counts / counts.max(), atol=0.51)
    at = float(re.search(r'class="limit" style="left:([\d.]+)%', text)[1])
    assert at == pytest.approx(100 * float(axis.share(0.6)), abs=0.01)


def test_the_curve_of_the_worst_runs_is_their_share(summary):
    figures = tip_figures(summary)
    axis = charts.values_axis(list(figures.values()))
    text = charts.worst_share_html(figures, INKS, True)
    points = re.search(r'<path class="r2" d="M([^"]+)"', text)[1].split()
    ordered = np.sort(1e3 * figures[CONTROLLERS[1]].sample)
    for point in points[10:-2:20]:
        across, down = map(int, point.split(","))
        share = 10.0 ** (np.log10(1024.0) * (1.0 - down / 1000.0) - np.log10(1024.0))
        value = ordered[round(1024 * (1.0 - share))]
        assert float(axis.share(value)) == pytest.approx(across / 2000, abs=0.01)


def test_a_metric_that_is_the_same_in_all_runs_is_a_sentence():
    made = study(64, limits={"tip_max": 1e-3, "saturated_s": 0.02})
    still = {name: replace(one, metrics={**one.metrics, "saturated_s": np.zeros((64, 2))})
             for name, one in runs_of(made).items()}  # fmt: skip
    card = (
        report_page.report_html(summarise(made, still))
        .split("<h2>Time beyond the torque limit")[1]
        .split("</section>")[0]
    )
    assert "0 s in all 192 runs of 3 controllers; limit 0.02 s." in card
    assert "<svg" not in card
    still[FIRST].metrics["saturated_s"][5] = 0.1
    assert "<svg" in report_page.report_html(summarise(made, still)).split("<h2>Time beyond")[1].split("</section>")[0]


def test_a_tornado_reaches_from_the_best_part_to_the_worst(summary):
    one = summary.controllers[FIRST].metrics["tip_max"]
    text = charts.tornado_html(one, report_page.column_units(summary))
    names = re.findall(r'class="what">([^<]+)<', text)
    assert names[:2] == ["payload.mass", "loop.delay"]
    bars = [
        tuple(map(float, found))
        for found in re.findall(r'class="bar[^"]*" style="left:([\d.]+)%;width:([\d.]+)%', text)
    ]
    swings = [each.swing for each in one.influence[: len(bars)]]
    finite = [k for k, swing in enumerate(swings) if np.isfinite(swing)]
    ratios = [bars[k][1] / swings[k] for k in finite]
    np.testing.assert_allclose(ratios, ratios[0], rtol=0.1, atol=0.0)
    assert " kg; rank correlation +0." in text
    assert text.count("hollow") == sum(not each.is_clear for each in one.influence[: len(bars)])


def test_gauges_end_where_a_limit_breaks(summary):
    search = summary.controllers[CONTROLLERS[1]].outwards
    text = charts.outwards_html(search)
    assert f"width:{100 * search.lines[0].share:.2f}%" in text
    kept, broken = map(float, re.search(r"tip_max kept at ([\d.]+), broken at ([\d.]+)", text).groups())
    assert kept < 4.3 <= broken  # kg, by the formula

    assert "Keep every limit alone: arm.mass to 0.8" in text
    assert "Broken with every parameter at its nominal value: tip_max" in charts.outwards_html(
        replace(search, at_nominal=("tip_max",))
    )


def test_indices_are_drawn_as_large_as_they_are():
    made = replace(study(8 * 64, "saltelli"), limits={})
    one = summarise(made, runs_of(made)).controllers[FIRST].metrics["tip_max"]
    assert one.indices is None or one.indices.groups < 64  # groups with a run that diverged are left out
    safe = summarise(made, {FIRST: replace(runs_of(made)[FIRST], metrics={"tip_max": np.arange(512.0) % 8})})
    found = safe.controllers[FIRST].metrics["tip_max"].indices
    text = charts.indices_html(found)
    assert "64 groups of runs" in text
    first = max(found.total, key=lambda path: found.total[path].value)
    width = 100 * min(1.0, max(0.0, found.total[first].value))
    assert f'total" style="left:0;width:{width:.2f}%' in text
    assert "Sobol indices" in report_page.report_html(safe)


def test_a_line_goes_through_the_values_of_its_run(summary):
    figures = summary.controllers[FIRST]
    one = figures.metrics["tip_max"]
    axes = charts.parameter_axes(summary, figures, one, report_page.column_units(summary))
    mass = next(axis for axis in axes if axis.name == "payload.mass")
    values = figures.runs.values["payload.mass"]
    np.testing.assert_allclose(mass.places, (values - values.min()) / np.ptp(values))
    assert mass.ends[1].endswith(" kg")
    reading = next((axis for axis in axes if axis.name == "reading"), None)
    assert reading is None or reading.ends == ("computed", "printed")
    text = charts.parallel_html(summary, FIRST, "r1", {})
    worst = re.search(r'<path class="r1 worst" d="M([^"]+)"', text)[1].split("M")
    last = charts.metric_axis(one, list(tip_figures(summary).values()))
    for line, row in zip(worst, figures.worst, strict=False):
        points = [tuple(map(int, point.split(","))) for point in line.split()]
        assert len(points) == len(axes) + 1
        assert points[-1][0] == round(2000 * last.places[row])
        assert points[0][0] == round(2000 * axes[0].places[row])
    assert f"{charts.MOST_LINES} of {int(figures.kept.sum())} that keep all limits" in text


def test_the_worst_runs_stand_with_their_parameters(summary, worst):
    text = report_page.worst_table_html(summary, INKS, report_page.column_units(summary), worst)
    row = summary.controllers[FIRST].worst[0]
    runs = summary.controllers[FIRST].runs
    assert f'<td class="n">{runs.run[row]}</td>' in text
    assert f'<td class="n">{runs.values["payload.mass"][row]:.3g}</td>' in text
    assert text.count("data-replay=") == len(worst)


@pytest.mark.slow
@pytest.mark.parametrize(("width", "dark"), SCREENS)
def test_a_browser_finds_nothing_against_it(width, dark, opened):
    with seen(opened, width, dark):
        screenshot(opened, f"sweep_{width}_{'dark' if dark else 'light'}.png")
        assert violations(opened) == []
        assert faint_texts(opened) == []
        assert sideways(opened) == 0


@pytest.mark.slow
def test_a_button_replays_its_run_without_a_request(opened, worst):
    opened.execute_script("document.querySelectorAll('button[data-replay]')[1].click()")
    frame = opened.find_element("css selector", "#replay-place iframe")
    assert frame.get_attribute("title") == f"Replay of {worst[1].label}"
    opened.switch_to.frame(frame)
    try:
        ready = "return !!(window.lwrReplay && lwrReplay.ready)"
        waiting(opened, 60).until(lambda window: window.execute_script(ready))
        k = 200
        opened.execute_script("lwrReplay.setTime(arguments[0])", worst[1].run.t[k])
        pose = np.array(opened.execute_script("return lwrReplay.flangePose(0)"))
    finally:
        opened.switch_to.default_content()
    from lwr_dyn.kinematics.forward import flange_pose

    np.testing.assert_allclose(pose, flange_pose(worst[1].arm.chain, worst[1].run.q[k]), atol=1e-5)
    sent, said = logs(opened)
    assert [address for address in sent if not address.startswith(("data:", "blob:", "file:", "about:"))] == []
    assert [line for line in said if line.startswith("SEVERE")] == []


@pytest.mark.slow
def test_a_controller_in_python_takes_no_figures_from_the_others(tmp_path):
    made = small_study(tmp_path, OWN, "mine.py", mine=LAW)
    study = replace(made, runs=3, chunk=3, keep=0, limits={"tip_max": 1.0})
    sweep(study, tmp_path / "out", threads=1)
    summary = report_page.finish(study, SweepResults.load(tmp_path / "out")).summary
    assert summary.controllers[OWN].outwards is not None
    assert summary.not_searched == {"mine.py": "it has no kernel form"}
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "mine.py was not looked at, it has no kernel form." in page
    assert "mine.py: all runs by simulate, with stops." in page
