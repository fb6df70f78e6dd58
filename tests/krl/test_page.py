"""The page of a run: the marked line is the one that moves the arm at that time, and a line goes to its motion."""

import base64
import json
import re

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.krl.language.source import parse_text
from lwr_dyn.krl.page import SPEEDS, program_data, program_html
from lwr_dyn.krl.project.program import load_program, parse_program, program_of
from lwr_dyn.krl.running.program_run import run_program
from tests.axe import EACH_ONCE, seen, sideways, violations
from tests.headless import logs, opened, screenshot

MARKED = "return [...document.querySelectorAll('#program ol li.runs i')].map((x) => Number(x.textContent))"
ENDING = MARKED.replace("runs", "ends")
CLICK = "document.querySelectorAll('#program ol li')[arguments[0] - 1].querySelector('button').click()"
HOME = "PTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}"
CALLER = f"DEF a( )\n{HOME}\nturn( )\nPTP {{A1 0}}\nEND\n"
CALLED = "DEF turn( )\nPTP {A1 20}\nEND\n"


@pytest.fixture(scope="module")
def program():
    return load_program("tests/krl/programs/pick_place.src")


@pytest.fixture(scope="module")
def run(program, arm):
    return run_program(program, arm)


@pytest.fixture(scope="module")
def page(run, program, browser, tmp_path_factory):
    file = tmp_path_factory.mktemp("program") / "x.html"
    file.write_text(program_html(run, program))
    opened(browser, file.as_uri())
    return browser


@pytest.mark.slow
def test_the_marked_line_is_the_one_that_moves_the_arm(page, run):
    for motion in run.executed:
        if motion.end > motion.begin:
            page.execute_script("lwrReplay.setTime(arguments[0])", motion.begin + 1e-4)
            assert page.execute_script(MARKED) == [motion.position.line]
            overlapped = motion.overlap > 2e-4
            before = [x.position.line for x in run.executed if x.begin < motion.begin < x.end - 2e-4]
            assert page.execute_script(ENDING) == (before if overlapped else [])


@pytest.mark.slow
def test_it_stays_in_sight_and_in_step_while_the_page_plays(page, run):
    page.execute_script("lwrReplay.setTime(0)")
    inside = """const row = document.querySelector('#program ol li.runs').getBoundingClientRect();
    const list = document.querySelector('#program ol').getBoundingClientRect();
    return row.top >= list.top - 1 && row.bottom <= list.bottom + 1"""
    for motion in (run.executed[0], run.executed[-1], run.executed[5]):
        page.execute_script("lwrReplay.setTime(arguments[0])", motion.begin)
        assert page.execute_script(inside)


@pytest.mark.slow
def test_a_line_goes_to_each_of_its_motions_and_outputs_in_turn(page, run):
    def clicked(line):
        page.execute_script(CLICK, line)
        return page.execute_script("return lwrReplay.time()")

    begins = [x.begin for x in run.executed if x.position.line == 38]
    events = [x for x in run.events if x.position.line == 40]
    assert (len(begins), len(events)) == (3, 3)
    page.execute_script("lwrReplay.setTime(0)")
    assert [clicked(38) for _ in range(4)] == pytest.approx([*begins, begins[0]], abs=1e-5)
    marked = MARKED.replace("runs", "happens")
    page.execute_script("lwrReplay.setTime(0)")
    for event in events:
        assert clicked(40) == pytest.approx(event.time, abs=1e-5)
        assert 40 in page.execute_script(marked)
        text = page.execute_script("return document.querySelector('#program .happened').textContent")
        assert text == f"{event.time:.3f} s: $OUT[1] = TRUE"
        page.execute_script("lwrReplay.setTime(arguments[0])", event.time - 1e-3)
        assert 40 not in page.execute_script(marked)
        page.execute_script("lwrReplay.setTime(arguments[0])", event.time)


@pytest.mark.slow
@pytest.mark.parametrize(("width", "dark"), EACH_ONCE)
def test_a_browser_finds_nothing_against_it(width, dark, page):
    with seen(page, width, dark):
        page.execute_script("lwrReplay.setTime(3.6)")
        screenshot(page, f"program_{width}_{'dark' if dark else 'light'}.png")
        assert violations(page) == []
        assert sideways(page) == 0


def test_it_makes_no_request_and_says_nothing_in_the_console(page):
    requests, messages = logs(page)
    assert [address for address in requests if not address.startswith(("file:", "data:", "blob:"))] == []
    assert messages == []


def unpacked(packed):
    return packed["step"] * np.frombuffer(base64.b64decode(packed["data"]), "<i4")


def test_the_data_has_every_line_every_motion_and_the_speed_of_the_flange(run, program):
    data = program_data(run, program)
    (file,) = data["files"]
    shown = [line.strip().replace("\t", "    ") for line in program.source.text().splitlines()]
    assert (file["name"], [line.strip() for line in file["lines"]]) == ("pick_place.src", shown)
    rows = [[0, x.position.line, round(x.begin, 6), round(x.end, 6), x.kind] for x in run.executed]
    events = [[0, x.position.line, round(x.time, 6), x.text] for x in run.events]
    assert (data["motions"], data["events"], data["left_out"]) == (rows, events, 0)
    count = f"{len(rows)} motions and pauses"
    assert data["about"] == [f"{run.duration:.3f} s", count, "robot kr30ha"]
    assert data["assumed"] == [*run.times().lines(), *map(str, run.assumptions)]
    place = lwr_dyn.forward_kinematics(run.arm, run.motion.q)[:, :3, 3]
    speed = np.linalg.norm(np.diff(place, axis=0), axis=1) / np.diff(run.motion.t)
    part = -(-len(speed) // SPEEDS)
    largest = [speed[i : i + part].max() for i in range(0, len(speed), part)]
    assert unpacked(data["speed"]["values"]) == pytest.approx(largest, abs=2e-6)
    middle = 0.5 * (run.motion.t[1:] + run.motion.t[:-1])[::part]
    assert unpacked(data["speed"]["t"]) == pytest.approx(middle, abs=1e-5)


def test_each_motion_names_its_file_and_an_endless_run_its_pass(arm):
    included = [parse_text(CALLED, "turn.src")[0], parse_text("DEF still( )\nEND\n", "still.src")[0]]
    program = program_of(parse_text(CALLER, "a.src")[0], None, included)
    data = program_data(run_program(program, arm), program)
    assert [file["name"] for file in data["files"]] == ["a.src", "turn.src"]
    assert [m[:2] for m in data["motions"]] == [[0, 2], [1, 2], [0, 4]]
    endless = parse_program(CALLER.replace("turn( )", "LOOP\nWAIT SEC 1\nENDLOOP"), name="a")
    about = program_data(run_program(endless, arm), endless)["about"]
    assert about[0].endswith(" s (cut)") or about[1] == "1.000 s a pass"


def test_warnings_stand_beside_their_lines_and_text_cannot_end_the_script(arm):
    source = CALLER.replace("turn( )", 'PTP {A1 20} ;</script><b>"')
    program = parse_program(source, name="a")
    html = program_html(run_program(program, arm), program)
    data = json.loads(re.search(r'id="replay-data">(.*?)</script>', html, re.DOTALL)[1])
    (file,) = data["program"]["files"]
    assert list(file["says"]) == ["2"]
    assert file["says"]["2"][0].startswith("warning: no velocity is set")
    assert ("</script><b>" in file["lines"][2], "</script><b>" in html) == (True, False)
