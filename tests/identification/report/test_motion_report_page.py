"""The report of an identification: its numbers, its charts at the right places, no request, axe on all screens."""

import re
from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.foundation.files import write_file
from lwr_dyn.identification.motion.validation import rms
from lwr_dyn.identification.report.charts import friction_maps_html, link_ellipsoid, torque_rows_html
from lwr_dyn.identification.report.motion_report import UNITS, link_table
from lwr_dyn.kinematics.forward import flange_pose, frames
from lwr_dyn.model.chain import JointKind
from lwr_dyn.pages.document import page_html, table_html
from tests.axe import SCREENS, faint_texts, seen, sideways, violations
from tests.headless import logs, screenshot, waiting
from tests.identification.report.made_fit import BAD, NOISE, made_document, made_fit, parameter_table

IMPOSSIBLE = 4


@pytest.fixture(scope="module")
def shown():
    return made_fit(impossible=IMPOSSIBLE)


@pytest.fixture(scope="module")
def opened(shown, browser, tmp_path_factory):
    file = tmp_path_factory.mktemp("report") / "report.html"
    write_file(file, page_html(made_document(shown)))
    browser.get("about:blank")
    logs(browser)
    browser.get(file.as_uri())
    ready = "return !!(window.lwrReport && lwrReport.ready)"
    waiting(browser, 60).until(lambda window: window.execute_script(ready))
    return browser


def test_the_page_has_all_parts_and_is_the_same_again(shown):
    text = page_html(made_document(shown))
    assert re.findall(r"<h2>([^<]+)</h2>", text) == [
        "The motion, and the links before and after", "Torque against prediction", "Friction", "Parameters",
        "Validation",
    ]  # fmt: skip
    for value, name in (("14 of 21", "identified parameters"), ("7 of 7", "links that can be bodies")):
        assert f"<div><b>{value}</b><span>{name}</span></div>" in text
    for said in ("2 recordings, 18 s.", "A note.", "Judged on other logs."):
        assert said in text
    assert text == page_html(made_document(shown))


def test_names_are_escaped_and_nothing_is_loaded(shown):
    recordings = tuple(replace(one, source=BAD) for one in shown.recordings)
    text = page_html(made_document(replace(shown, recordings=recordings), BAD, BAD, (BAD, 1.0, 1.0, BAD)))
    page = re.sub(r"<script>\n.*?</script>", "", text, flags=re.DOTALL)
    assert "<img" not in page
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", page)
    assert re.findall(r"url\((?!data:)", page) == []


def test_a_row_of_torques_says_what_is_left(shown):
    one = shown.recordings[0]
    text = torque_rows_html(one, shown.noise, shown.arm.joint_names, ("N m",) * 7)
    assert text.count('class="trow"') == 7
    left = np.where(one.used[:, 0], one.measured[:, 0] - one.predicted[:, 0], np.nan)
    assert rms(left) == pytest.approx(NOISE, rel=0.1)
    assert f"<span>RMS left</span> <b>{rms(left):.3g} N m</b>" in text
    peak, torque = (np.nanmax(np.abs(x)) for x in (left, one.measured[:, 0]))
    assert f"<span>largest</span> <b>{peak:.3g} N m</b>" in text
    assert f"torque at most {torque:.3g} N m; measured less" in text


def test_torques_that_were_cut_out_leave_a_gap(shown):
    one = shown.recordings[0]
    measured, used = one.measured.copy(), one.used.copy()
    measured[200:400, 0], used[200:400, 0], measured[:, 1], used[:, 1] = np.nan, False, np.nan, False
    cut = replace(one, measured=measured, used=used)
    text = torque_rows_html(cut, shown.noise, shown.arm.joint_names, ("N m",) * 7)
    lines = re.findall(r'<path class="ref" d="([^"]+)"', text)
    assert [line.count("M") for line in lines] == [2, 1, 1, 1, 1, 1]
    assert "<span>RMS left</span> <b>none</b>" in text
    assert "nan" not in text


def test_a_friction_map_jumps_at_rest_and_draws_the_table_too(shown):
    units = (UNITS[JointKind.REVOLUTE],) * 7

    def maps(torque, *models):
        return friction_maps_html(shown.speed, torque, *models, shown.arm.joint_names, units)

    first, *others = maps(shown.friction_torque, shown.friction, shown.friction_before).split("<figure>")[1:]
    assert [x.count('class="ref"') for x in (first, *others)] == [1, *[0] * 6]
    line = re.search(r'<path class="r1" d="([^"]+)"', first)[1]
    assert line.count("M") == 2
    assert 100 < first.count("h0") <= 600
    none = maps(np.full_like(shown.friction_torque, np.nan), (None,) * 7, (None,) * 7)
    assert none.count("values that no friction can have") == 14


def test_parameters_are_shown_with_their_pulls(shown):
    long = "a" * 50 + " + " + "b" * 50
    table = replace(parameter_table(shown), rows=[
        ("Izz_2 + 0.16 m_3", 1.2, 2.0, "identified"), ("m_4", 0.4, -5.0, "no"), (long, 0.0, float("nan"), "no"),
    ])  # fmt: skip
    text = table_html(table.shown(page=True))
    assert 'left:50.0%;width:10.0%"></i></span><span class="m">2<' in text
    assert 'class="bar far" style="left:25.0%;width:25.0%"' in text
    assert text.count("<details>") == 1
    assert "all (3)" in text
    assert "no (2)" in text
    assert "nan" not in text


def test_links_before_and_after(shown):
    table = link_table(shown)
    assert [x.title for x in table.columns] == [
        "link", "mass, table [kg]", "mass [kg]", "centre moved by [mm]", "semi-axes, table [mm]", "semi-axes [mm]",
        "a body",
    ]  # fmt: skip
    assert [row[-1] for row in table.rows] == [i != IMPOSSIBLE for i in range(7)]
    assert [row[3] for row in table.rows] == pytest.approx([20.0] * 7)
    assert table.rows[0][2] / table.rows[0][1] == pytest.approx(0.8)
    assert table.cells[IMPOSSIBLE][5] == "none"


@pytest.mark.slow
def test_ellipsoids_stand_in_their_links(opened, shown):
    arm, one, k = shown.arm, shown.recordings[0], 300
    opened.execute_script("lwrReport.setTime(arguments[0])", one.t[k])
    pose = np.array(opened.execute_script("return lwrReport.flangePose()"))
    np.testing.assert_allclose(pose, flange_pose(arm.chain, one.q[k]), atol=1e-5)
    poses = frames(arm.chain, one.q[k])
    for what, rows in (("before", shown.before), ("after", shown.after)):
        drawn = opened.execute_script(f"return lwrReport.ellipsoids('{what}')")
        links = [i for i in range(arm.n) if link_ellipsoid(rows[i]) is not None]
        assert len(drawn) == len(links) == (7 if what == "before" else 6)
        for i, found in zip(links, drawn, strict=True):
            wanted = poses[i] @ link_ellipsoid(rows[i]).image.matrix()
            np.testing.assert_allclose(np.reshape(found["matrix"], (4, 4)).T, wanted, atol=1e-5)
    opened.execute_script("document.getElementById('show-before').click()")
    assert not any(d["visible"] for d in opened.execute_script("return lwrReport.ellipsoids('before')"))
    assert all(d["visible"] for d in opened.execute_script("return lwrReport.ellipsoids('after')"))
    opened.execute_script("document.getElementById('show-before').click()")


@pytest.mark.slow
def test_another_recording_and_one_state(opened, shown):
    opened.execute_script("lwrReport.choose(1)")
    assert opened.execute_script("return lwrReport.duration()") == pytest.approx(shown.recordings[1].t[-1])
    hidden = "return [...document.querySelectorAll('[data-recording]')].map((part) => part.hidden)"
    assert opened.execute_script(hidden) == [True, False]
    pose = np.array(opened.execute_script("lwrReport.setTime(2.0); return lwrReport.flangePose()"))
    np.testing.assert_allclose(pose, flange_pose(shown.arm.chain, shown.recordings[1].q[200]), atol=1e-5)
    opened.execute_script("lwrReport.choose(0)")
    pick = (
        "const s = document.querySelector('select.states'); s.value = arguments[0];"
        "s.dispatchEvent(new Event('change'));"
    )
    count = "return [...document.querySelectorAll('tr[data-state]')].filter((row) => !row.hidden).length"
    opened.execute_script(pick, "not excited")
    assert opened.execute_script(count) == 7
    opened.execute_script(pick, "")
    assert opened.execute_script(count) == 21


@pytest.mark.slow
@pytest.mark.parametrize(("width", "dark"), SCREENS)
def test_a_browser_finds_nothing_against_it(width, dark, opened):
    with seen(opened, width, dark):
        screenshot(opened, f"identification_{width}_{'dark' if dark else 'light'}.png")
        assert violations(opened) == []
        assert faint_texts(opened) == []
        assert sideways(opened) == 0


@pytest.mark.slow
def test_it_makes_no_request(opened):
    sent, said = logs(opened)
    assert [address for address in sent if not address.startswith(("data:", "blob:", "file:", "about:"))] == []
    assert [line for line in said if line.startswith("SEVERE")] == []


@pytest.mark.slow
def test_without_webgl_everything_else_stands(browser, shown, tmp_path):
    file = tmp_path / "report.html"
    write_file(file, page_html(made_document(shown)))
    none = "HTMLCanvasElement.prototype.getContext = () => null"
    added = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": none})
    try:
        browser.get(file.as_uri())
        assert browser.find_element("css selector", "#stage").text.startswith("No 3D in this browser: ")
        hidden = "return [...document.querySelectorAll('[data-recording]')].filter((part) => part.hidden).length"
        assert browser.execute_script(hidden) == 0
        assert browser.find_element("id", "stage").size["height"] < 100
        assert not browser.find_element("id", "play").is_displayed()
        assert violations(browser) == []
    finally:
        browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)
        browser.get("about:blank")
        logs(browser)
