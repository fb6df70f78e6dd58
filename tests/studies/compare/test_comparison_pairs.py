"""The page that replays any two runs: each choice shows its own run, the rest of the page stays, nothing is loaded."""

import json
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.studies.compare.comparison import SHARED, comparison_of, pair_data, pair_html, rate_within
from lwr_dyn.studies.compare.plants import plant_case
from lwr_dyn.studies.compare.study import ControllerStudy
from tests.axe import SCREENS, seen, sideways, violations
from tests.headless import opened
from tests.studies.compare.conftest import POSE

CHOOSE = """const list = document.getElementById(`run-${arguments[0]}`);
list.value = arguments[1]; list.dispatchEvent(new Event("change"));"""


@pytest.fixture(scope="module")
def study(arm):
    move = lwr_dyn.reference("point-to-point", arm, start=POSE, end=POSE + 0.3, duration=1.0)
    cases = [plant_case(arm, text) for text in ("nominal", "payload=3")]
    return ControllerStudy(arm, move, ("inverse-dynamics", "pid:omega-n=20"), cases, "move").run()


@pytest.fixture(scope="module")
def page(study, browser, tmp_path_factory):
    file = tmp_path_factory.mktemp("pair") / "x.html"
    file.write_text(pair_html(study[0]))
    opened(browser, file.as_uri())
    return browser


@pytest.mark.slow
def test_any_two_runs_can_be_chosen_and_move_as_they_ran(page, study, arm):
    _, runs = study
    for place, chosen in ((0, 3), (1, 0), (0, 1), (1, 1), (0, 2)):
        page.execute_script(CHOOSE, place + 1, chosen)
        for k in (0, 500, 1000):
            page.execute_script("lwrReplay.setTime(arguments[0])", runs[chosen].t[k])
            pose = np.array(page.execute_script("return lwrReplay.flangePose(arguments[0])", place))
            expected = lwr_dyn.forward_kinematics(arm, runs[chosen].q[k])
            np.testing.assert_allclose(pose, expected, atol=1e-6)
    cards = page.execute_script("return [...document.querySelectorAll('.card header span')].map((x) => x.textContent)")
    assert cards == [
        "inverse dynamics with feed-forward, 3 kg at the flange",
        "PID + gravity, damping on dq, omega_n 20, as modelled",
    ]


@pytest.mark.slow
def test_what_was_switched_off_stays_off(page):
    page.execute_script("document.getElementById('trace').click()")
    page.execute_script(CHOOSE, 1, 3)
    shown = "return lwrReplay.stage.node(lwrReplay.stage.runs[0].root.concat(arguments[0])).visible"
    assert [page.execute_script(shown, what) for what in ("trace", "target")] == [False, True]
    page.execute_script("document.getElementById('trace').click()")
    assert page.execute_script(shown, "trace")


@pytest.mark.slow
def test_the_lists_have_every_run_under_its_plant(page, study):
    groups = page.execute_script(
        "return [...document.querySelectorAll('#run-2 optgroup')]"
        ".map((group) => [group.label, [...group.children].map((one) => one.text)])"
    )
    assert groups == [[plant, [one.controller for one in runs]] for plant, runs in study[0].plants.items()]


@pytest.mark.slow
@pytest.mark.parametrize(("width", "dark"), SCREENS)
def test_a_browser_finds_nothing_against_it(width, dark, page):
    with seen(page, width, dark):
        assert violations(page) == []
        assert sideways(page) == 0


def test_it_makes_no_request_and_says_nothing_in_the_console(page):
    names = page.execute_script("return performance.getEntriesByType('resource').map((entry) => entry.name)")
    assert [name for name in names if not name.startswith(("data:", "blob:"))] == []
    assert [entry for entry in page.get_log("browser") if entry["level"] == "SEVERE"] == []


def test_what_runs_share_stands_in_it_once(study):
    data = pair_data(study[0])["pair"]
    assert set(data["shared"]) == set(SHARED)
    assert all(not set(SHARED) & set(own) for own in data["runs"])
    text = pair_html(study[0])
    assert text == pair_html(study[0])
    assert text.count(json.dumps(data["shared"]["q_ref"]["data"])) == 3  # also in the two that it begins with


def test_it_begins_with_the_best_and_the_worst_of_the_last_plant_with_two_stable_runs(study):
    errors = [one.figures.tip_rms_mm for one in study[0].runs]
    first, second = ([k + int(find(errors[k : k + 2])) for find in (np.argmin, np.argmax)] for k in (0, 2))
    one_each = [int(np.argmax(errors[:2])), 2]
    for kept, expected in (([0, 1, 2, 3], second), ([0, 1, 2], first), (one_each, [0, 1])):
        data = pair_data(replace(study[0], runs=tuple(study[0].runs[i] for i in kept)))
        assert data["pair"]["chosen"] == expected
        assert [one["place"] for one in data["runs"]] == [0, 1]
        shown = [study[0].runs[kept[i]] for i in expected]
        assert [(one["controller"], one["plant"]) for one in data["runs"]] == [(x.controller, x.plant) for x in shown]


def test_many_runs_get_fewer_samples_each(study):
    rates = [rate_within(study[0].runs, budget) for budget in (10_000_000, 10_000, 5_000, 10)]
    assert rates[0] == 100.0
    assert rates[-1] == 10.0
    assert all(a >= b for a, b in pairwise(rates))
    assert rates[1] == pytest.approx(10_000 / (4 * 12 * 16 / 3))


def test_names_are_escaped(study):
    _, runs = study
    text = pair_html(comparison_of(runs[:2], ["a", "b"], labels=["</script><img src=x>", "b"]))
    assert "<img" not in text
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", text)


def test_one_run_is_refused(study):
    with pytest.raises(LwrDynError, match="replay of two runs: one run; allowed: two runs or more"):
        pair_html(comparison_of(study[1][:1], ["a"], least=1))
