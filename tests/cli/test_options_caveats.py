"""Every command says first what must be known before its arm's numbers: errors left in place, what is estimated."""

import json

import pytest

import lwr_dyn
from lwr_dyn.cli import options
from lwr_dyn.model.run import Run
from lwr_dyn.studies.sweep.read_study import read_study
from lwr_dyn.studies.sweep.sweep_study import study_caveats

ESTIMATED = "kr30ha (kuka): masses, centres of mass and inertias estimated from drawn solids"
ROTORS = (
    "kr30ha (kuka): no rotor inertia given (--rotor JOINT=VALUE adds it): gears make a real arm heavier at its joints"
)
ADVISE = ("margins", "simulate", "compare")
"""Commands whose advice stands on rotor inertia."""
LEFT = "lwr4plus (computed): leaves rotor-inertia-power in place, a proven error"
SPRINGS = "gear stiffness and gear damping assumed for want of printed values"
POSE = "0,-90,90,0,30,0"
HOLD = ("--task", "hold", "--from-deg", POSE, "--duration", "0.01")
BENT = "0,30,0,-60,0,30,0"
SOON = ("--task", "hold", "--from-deg", BENT, "--duration", "0.01")
AUTHORS = ("lwr4plus", "--reading", "computed")


STUDY = """
robot = "kr30ha"
controllers = ["inverse-dynamics"]
[task]
name = "hold"
from-deg = [0, -90, 90, 0, 30, 0]
duration = 0.5
[[parameter]]
path = "payload.mass"
low = 0
high = 7
"""


@pytest.fixture
def run_file(folder):
    arm = lwr_dyn.load("kr30ha")
    hold = lwr_dyn.reference("hold", arm, q=[0.0, -1.5, 1.5, 0.0, 0.5, 0.0], duration=0.01)
    lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), hold).save("run.npz")
    return "run.npz"


@pytest.fixture
def shown(monkeypatch):
    """The documents that a command prints."""
    found, whole = [], options.with_caveats
    monkeypatch.setattr(options, "with_caveats", lambda document: found.append(whole(document)) or found[-1])
    return found


BOTH_WAYS = [
    (ESTIMATED, ("check", "kr30ha")),
    (ESTIMATED, ("margins", "kr30ha", "--q-deg", POSE)),
    (ESTIMATED, ("simulate", "kr30ha", *HOLD, "--controller", "inverse-dynamics")),
    (ESTIMATED, ("compare", "kr30ha", *HOLD, "--controllers", "inverse-dynamics,pd-gravity")),
    (ESTIMATED, ("kernels", "kr30ha")),
    (LEFT, ("check", *AUTHORS)),
    (LEFT, ("fk", *AUTHORS, "--q-deg", BENT)),
    (LEFT, ("ik", *AUTHORS, "--xyz", "-0.05,-0.45,0.55", "--rpy-deg", "-90,0,0")),
    (LEFT, ("dh", *AUTHORS)),
    (LEFT, ("margins", *AUTHORS, "--q-deg", BENT)),
    (LEFT, ("simulate", *AUTHORS, *SOON)),
    (LEFT, ("compare", *AUTHORS, *SOON, "--controllers", "inverse-dynamics")),
    (LEFT, ("kernels", *AUTHORS)),
    (f"lwr4plus (physical): {SPRINGS}", ("margins", "lwr4plus", "--q-deg", BENT, "--elastic", "file")),
    (f"lwr4plus (physical): {SPRINGS}", ("simulate", "lwr4plus", *SOON, "--elastic", "file")),
    (f"lwr4plus (physical): {SPRINGS}", ("simulate", "lwr4plus", *SOON, "--elastic", "20000")),
    ("kr30ha (printed): leaves table2-offset, table2-half-turn and kuka-signs in place, proven errors",
     ("fk", "kr30ha", "--reading", "printed", "--q-deg", POSE)),
]  # fmt: skip


@pytest.mark.parametrize(("line", "words"), BOTH_WAYS, ids=lambda x: " ".join(x)[:40] if isinstance(x, tuple) else "")
def test_the_first_line_and_the_record_say_it_once(lwr_dyn_command, folder, line, words, shown):
    lwr_dyn_command(*words)
    (document,) = shown
    text = document.text()
    assert text.splitlines()[0] == line
    assert text.count(line) == 1
    more = [ROTORS] if words[0] in ADVISE and words[1] == "kr30ha" else []
    assert document.record()["caveats"] == [line, *more]


def test_a_study_and_runs_made_before_name_a_way_that_they_have(lwr_dyn_command, run_file, folder):
    words = "no rotor inertia given (--rotor JOINT=VALUE of simulate adds it)"
    page = ("--label", "a", "--label", "b", "--html", str(folder / "c.html"))
    _, out, _ = lwr_dyn_command("compare", str(run_file), str(run_file), *page)
    assert out.count(words) == (folder / "c.html").read_text().count(words) == 1
    (folder / "s.toml").write_text(STUDY)
    (line,) = [x for x in study_caveats(read_study(folder / "s.toml")) if "no rotor" in x]
    assert "(name the file that lwr-dyn urdf ROBOT --rotor JOINT=VALUE writes)" in line


@pytest.mark.slow
@pytest.mark.parametrize(("line", "robot"), [(ESTIMATED, ("kr30ha",)), (LEFT, AUTHORS)])
def test_gains_say_it(lwr_dyn_command, line, robot, shown):
    lwr_dyn_command("gains", *robot)
    assert shown[0].text().splitlines()[0] == line


@pytest.mark.parametrize(
    "words",
    [
        ("fk", "kr30ha", "--q-deg", POSE),
        ("ik", "kr30ha", "--xyz-mm", "91,-1139,1392", "--abc-deg", "0,0,0"),
        ("dh", "kr30ha"),
        ("kernels", "lwr4plus"),
        ("simulate", "lwr4plus", *SOON),
    ],
)
def test_nothing_is_said_of_numbers_that_are_not_used(lwr_dyn_command, words, shown):
    lwr_dyn_command(*words)
    (document,) = shown
    assert document.caveats == ()
    assert document.record()["caveats"] == []


@pytest.mark.parametrize(
    "words",
    [
        ("urdf", "kr30ha", "--out", "arm.urdf"),
        ("urdf", "kr30ha", "--out", "arm.xml"),
        ("dh", "kr30ha", "--out", "arm.toml"),
        ("kernels", "kr30ha", "--language", "c", "--out", "arm.c"),
        ("show", "kr30ha", "--html", "arm.html"),
        ("replay", "run.npz", "--html", "run.html"),
        ("compare", "run.npz", "run.npz"),
    ],
)
def test_what_writes_files_says_it_first_and_the_files_say_it(lwr_dyn_command, run_file, folder, words):
    code, out, err = lwr_dyn_command(*words)
    assert code == 0, err
    assert out.splitlines()[0] == ESTIMATED
    for path in folder.glob("arm.*"):
        text = " ".join(path.read_text(encoding="utf-8").split()).replace("&quot;", '"')
        assert "estimated from drawn solids" in text or 'how = "from drawn solids"' in text, path.name


def test_pages_say_it(lwr_dyn_command, run_file, folder):
    for words in (("replay", run_file, "--html", "a.html"), ("compare", run_file, run_file, "--html", "b.html"),
                  ("compare", run_file, run_file, "--label", "a", "--label", "b", "--replay", "c.html")):  # fmt: skip
        assert lwr_dyn_command(*words)[0] == 0
        assert ESTIMATED in (folder / words[-1]).read_text(encoding="utf-8"), words


def test_the_arm_of_another_reading_is_said_too(lwr_dyn_command):
    _, out, _ = lwr_dyn_command("simulate", "lwr4plus", *SOON, "--plant-reading", "computed")
    assert out.splitlines()[0] == LEFT
    plant = json.loads(lwr_dyn_command("simulate", "lwr4plus", *SOON, "--plant-reading", "computed", "--json")[1])
    assert plant["caveats"] == [LEFT]


@pytest.mark.slow
def test_a_study_says_it(lwr_dyn_command, folder):
    (folder / "study.toml").write_text(
        'robot = "lwr4plus"\nreading = "computed"\ncontrollers = ["inverse-dynamics"]\n[task]\nname = "hold"\n'
        'from-deg = [0, 30, 0, -60, 0, 30, 0]\nduration = 0.02\n[[parameter]]\npath = "payload.mass"\nlow = 0\n'
        "high = 5\n"
    )
    _, out, _ = lwr_dyn_command("sweep", "study.toml", "--out", "made", "--runs", "16")
    assert out.splitlines()[0] == LEFT
    assert LEFT in (folder / "made" / "report.html").read_text(encoding="utf-8")
    record = json.loads(lwr_dyn_command("sweep", "study.toml", "--out", "made", "--runs", "16", "--json")[1])
    assert record["caveats"] == [LEFT]


def test_a_file_that_was_written_says_it_when_it_is_read_again(lwr_dyn_command, folder):
    lwr_dyn_command("urdf", "kr30ha", "--out", "arm.urdf")
    lwr_dyn_command("dh", *AUTHORS, "--out", "authors.toml")
    assert lwr_dyn_command("kernels", "arm.urdf")[1].startswith(ESTIMATED.replace("(kuka)", "(urdf)"))
    assert "leaves rotor-inertia-power in place" in lwr_dyn_command("kernels", "authors.toml")[1].splitlines()[0]


def test_a_run_knows_whether_its_gears_were_used():
    arm = lwr_dyn.load("lwr4plus")
    hold = lwr_dyn.reference("hold", arm, q=[0.0, 0.5, 0.0, -1.0, 0.0, 0.5, 0.0], duration=0.01)
    law = lwr_dyn.controller("pd-gravity", arm)
    runs: list[Run] = [lwr_dyn.simulate(arm, law, hold, elasticity=spring) for spring in (None, "file")]
    said = [lwr_dyn.compare(run, run).document.caveats for run in runs]
    assert said == [(), (f"lwr4plus (physical): {SPRINGS}",)]
