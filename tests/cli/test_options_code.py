"""Which Python file a command would run is said before; `--no-code` and LWR_DYN_NO_CODE refuse it."""

import pytest

from lwr_dyn.control.controllers import code_files, make_controller
from lwr_dyn.foundation.errors import OptionError

OWN = """open("RAN", "w").close()
def make(arm, dynamics, gain=40.0):
    def controller(t, q, dq, q_ref, dq_ref, ddq_ref):
        return dynamics.gravity_vector(q) + gain * (q_ref - q) - 10.0 * dq
    return controller
"""
STUDY = """robot = "lwr4plus"
reading = "physical"
controllers = ["mine.py:gain=30"]
[task]
name = "hold"
from-deg = [0, 30, 0, -60, 0, 30, 0]
duration = 0.05
[sampling]
method = "random"
runs = 2
[[parameter]]
path = "payload.mass"
low = 0
high = 1
"""
HOLD = ("--task", "hold", "--from-deg", "0,0,0,0,0,0,0", "--duration", "0.02")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(OWN, encoding="utf-8")
    return tmp_path


COMMANDS = [
    ("simulate", "lwr4plus", "--controller", "mine.py", *HOLD),
    ("simulate", "lwr4plus", "--controller", "mine.py+observer", *HOLD),
    ("compare", "lwr4plus", "--controllers", "pd-gravity,mine.py:gain=30", *HOLD),
    ("margins", "lwr4plus", "--controller", "mine.py", "--q-deg", "0,30,0,-60,0,30,0"),
]


@pytest.mark.parametrize("words", COMMANDS)
def test_a_file_that_runs_is_said_and_refused(folder, words, lwr_dyn_command):
    code, _, err = lwr_dyn_command(*words, "--no-code")
    assert code == 2
    assert "mine.py: Python that would run, against --no-code; allowed: controllers by name" in err
    assert not (folder / "RAN").exists()
    code, out, err = lwr_dyn_command(*words)
    assert code == 0, err
    assert "mine.py" in out  # typed by the user, and named in what is printed
    assert (folder / "RAN").exists()


@pytest.mark.parametrize("words", [("sweep", "s.toml", "--out", "out", "--no-report"), ("tune", "s.toml")])
def test_a_study_that_names_a_file(folder, words, lwr_dyn_command):
    (folder / "s.toml").write_text(STUDY, encoding="utf-8")
    code, _, err = lwr_dyn_command(*words, "--no-code")
    assert code == 2
    assert "Python that would run, against --no-code" in err
    assert not (folder / "RAN").exists()
    assert not (folder / "out").exists()
    err = lwr_dyn_command(*words)[2]
    assert "runs the Python file" in err
    assert "mine.py" in err


def test_a_controller_by_name_runs_no_file(folder, lwr_dyn_command):
    code, _, err = lwr_dyn_command("simulate", "lwr4plus", "--no-code", *HOLD)
    assert code == 0
    assert "Python file" not in err


def test_the_variable_refuses_in_every_process_that_inherits_it(folder, arm, monkeypatch):
    monkeypatch.setenv("LWR_DYN_NO_CODE", "1")
    with pytest.raises(OptionError, match=r"mine\.py: Python that would run, against LWR_DYN_NO_CODE"):
        make_controller("mine.py", arm)
    assert not (folder / "RAN").exists()


def test_files_among_controllers_are_found_however_they_are_written():
    texts = ["pid", "a.py", "b c.py:x=1:y+friction", "a.py+observer", "adaptive:omega-n=3"]
    assert code_files(texts) == ("a.py", "b c.py")
    assert code_files(["robust"]) == ()
