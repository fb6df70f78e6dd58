"""The report of a study: its numbers, its charts at the right places, names escaped, no request, axe on all screens."""

import json
import re
from dataclasses import replace
from html import unescape
from types import SimpleNamespace

import numpy as np
import pytest

from lwr_dyn.foundation.errors import DivergenceError
from lwr_dyn.studies.sweep import charts, report_page
from lwr_dyn.studies.sweep.intervals import share_text
from lwr_dyn.studies.sweep.running.sweep import sweep
from lwr_dyn.studies.sweep.running.sweep_folder import SweepResults
from lwr_dyn.studies.sweep.summary import draw_columns, summarise
from lwr_dyn.studies.sweep.summary_document import about_text, quantile_text, value_text
from lwr_dyn.studies.sweep.vocabulary import metric_words
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


def test_a_metric_that_is_the_same_in_all_runs_is_a_sentence():
    made, title = study(64, limits={"tip_max": 1e-3, "saturated_s": 0.02}), "Time beyond the torque limit, worst joint"
    cut = np.zeros((64, 2))
    still = {name: replace(one, metrics={**one.metrics, "saturated_s": cut}) for name, one in runs_of(made).items()}
    page = cards(report_page.report_html(summarise(made, still)))
    assert page[title] == "<p>0 s in all 192 runs of 3 controllers; limit 0.02 s.</p>"
    cut[5] = 0.1
    assert "<svg" in cards(report_page.report_html(summarise(made, still)))[title]


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
    units = report_page.column_units(summary)
    text = report_page.worst_table_html(summary, INKS, units, worst)
    heads = re.findall(r'<th scope="col">(.*?) <small>(.*?)</small>', text)
    assert heads[:6] == [
        ("controller", ""), ("run", ""), ("replay", ""), ("error of the tip, largest", "mm"),
        ("least distance from a position limit, worst joint", "mrad"), ("flag", ""),
    ]  # fmt: skip
    paths = [name for name, _ in heads[6:]]
    assert (len(paths), paths[:2]) == (10, ["payload.mass", "loop.delay"])
    assert [unit for _, unit in heads[6:]] == [units[path] for path in paths]
    rows = re.findall(r"<tr>(<th scope=\"row\">.*?)</tr>", text)
    assert len(rows) == 2 * len(CONTROLLERS)
    figures = summary.controllers[FIRST]
    for row, html, button in zip(figures.worst, rows, (0, 1), strict=False):
        cells = re.findall(r'<td class="n">(.*?)</td>', html)
        tip, margin = (figures.metrics[name].badness[row] for name in ("tip_max", "limit_margin"))
        drawn = draw_columns(summary.study, figures.runs)
        assert cells[:4] == [
            f"{figures.runs.run[row]}", value_text(metric_words("tip_max"), tip),
            value_text(metric_words("limit_margin"), margin), figures.runs.flags[row] or "none",
        ]  # fmt: skip
        assert cells[4:] == [x if isinstance(x, str) else f"{x:.3g}" for x in (drawn[path][row] for path in paths)]
        said = f'<span class="unseen"> of {FIRST}, run {figures.runs.run[row]}</span>'
        assert f'data-replay="{button}">Replay{said}</button>' in html
    assert text.count("data-replay=") == len(worst) == 3
    assert "10 of 11 parameters; the files of results have all." in text


def cards(text):
    """Title -> inside, of a page."""
    return dict(re.findall(r'<section class="card"><h2>(.*?)</h2>(.*?)</section>', text, re.DOTALL))


def test_the_page_has_its_cards_and_says_first_what_was_found(summary):
    text = report_page.report_html(summary)
    assert list(cards(text)) == [
        "Controllers", "Error of the tip, largest", "Least distance from a position limit, worst joint",
        "What each parameter does", "Which parameter breaks a limit first", "Runs over all parameters", "Worst runs",
        "What was varied",
    ]  # fmt: skip
    said = re.findall(r"<li>(.*?)</li>", re.search(r'<ul class="say">(.*?)</ul>', text)[1])
    order = sorted(CONTROLLERS, key=lambda name: -summary.controllers[name].within.value)
    shares = [f"{x} keeps all limits in {share_text(summary.controllers[x].within)} of 1024 runs." for x in order]
    assert said[-4:] == [about_text(summary), *shares]
    assert "smaller value" in cards(text)["Least distance from a position limit, worst joint"]
    assert "larger value" in cards(text)["Error of the tip, largest"]
    row = "<td>payload.mass</td><td>payload.mass</td><td>uniform from 0 to 7</td><td>kg</td><td>0</td><td>assumed</td>"
    assert row in re.sub(r"<t[dh][^>]*>", "<td>", cards(text)["What was varied"].replace("</th>", "</td>"))
    assert (charts.MOST_LINES, text.count("data-replay="), text.count("<script")) == (150, 0, 0)
    made = replace(study(8 * 64, "saltelli"), limits={})
    sobol = cards(report_page.report_html(summarise(made, {FIRST: runs_of(made)[FIRST]})))
    assert list(sobol)[2:5] == ["What each parameter does", "Sobol indices", "Runs over all parameters"]
    assert "Shares of the variance of error of the tip, largest: filled alone" in sobol["Sobol indices"]


def test_what_was_not_looked_at_is_said_controller_by_controller(summary):
    title = "Which parameter breaks a limit first"
    some = dict(summary.controllers)
    for name in (FIRST, "adaptive"):
        some[name] = replace(some[name], outwards=None)
    part = replace(summary, controllers=some, not_searched={FIRST: "it has no kernel form"})
    inside = cards(report_page.report_html(part))[title]
    notes = re.findall(r'<p class="note">(.*?)</p>', inside)
    assert (notes[1], notes[3]) == ("Not looked at: it has no kernel form.", "Not looked at: no runs.")
    assert inside.count('class="limit"') == len(some[CONTROLLERS[1]].outwards.broken) > 0
    none = {name: replace(one, outwards=None) for name, one in summary.controllers.items()}
    assert title not in cards(report_page.report_html(replace(summary, controllers=none)))


def test_a_finished_sweep_has_its_page_and_its_worst_runs_alone(arm, tmp_path, monkeypatch):
    """Of three controllers one is slow; one of the worst runs diverges when it is made again."""
    made, asked = replace(study(64), keep=1), []

    def run(text, number):
        asked.append((text, number))
        if text == CONTROLLERS[1]:
            raise DivergenceError(0.1, "joint_1", "inf", "less")
        return lagging_run(arm, 0.01, "pid")

    def further(text, values, hand_over):
        return evaluate(text, values) if hand_over else None

    shop = SimpleNamespace(arm=arm, run=run, is_slow=lambda text: text == FIRST, evaluate=further)
    monkeypatch.setattr(report_page, "SweepWorkshop", lambda of: shop)
    (tmp_path / "worst").mkdir()
    for name in ("a-run-1.npz", "notes.txt"):
        (tmp_path / "worst" / name).write_text("")
    results = SimpleNamespace(controllers=runs_of(made), folder=tmp_path, failures={})
    done = report_page.finish(made, results)
    assert asked == done.summary.worst()
    number = dict(asked)
    files = [f"inverse-dynamics-run-{number[FIRST]}.npz", f"adaptive-run-{number['adaptive']}.npz"]
    assert done.worst == tuple(tmp_path / "worst" / name for name in files)
    assert sorted(path.name for path in (tmp_path / "worst").iterdir()) == sorted([*files, "notes.txt"])
    assert done.summary.not_searched == {FIRST: "it has no kernel form"}
    searched = [one.outwards is not None for one in done.summary.controllers.values()]
    assert searched == [False, True, True]
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.count('data-replay="') == 2
    for part in ('<div id="replay-place" hidden></div>', "A replay is the run again by simulate;", 'id="replays"'):
        assert page.count(part) == 1
    assert "frame-src 'self'; base-uri 'none'" in unescape(page)
    labels = json.loads(re.search(r'id="replays">(.*?)</script>', page)[1])["labels"]
    assert labels == [f"{name}, run {number[name]}" for name in (FIRST, "adaptive")]
    results.controllers = {}
    assert report_page.finish(made, results) is None


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
