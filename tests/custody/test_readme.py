"""The README is correct: its commands run, and CI runs its test command. Its Python is run by `tests/docs`."""

import re
import shlex
from pathlib import Path

import pinocchio
import pytest

import lwr_dyn
from lwr_dyn.cli.main import COMMANDS, main

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
ELSEWHERE = ("reproduce lwr4plus", "reproduce all", "identify friction out/friction_wam/*.csv")
"""Run by tests/reproduction (paper by paper) and by tests/identification/test_identify_command.py."""
EXIT_1 = "panda.urdf"
"""As the README states, a link of it cannot hold its inertia."""


def commands() -> list[list[str]]:
    """Every indented `lwr-dyn` command, continuation lines joined, comments dropped."""
    text = README.replace("\\\n", " ")
    lines = [line.split(" #")[0].strip() for line in text.splitlines() if line.startswith("    ")]
    parts = [part.strip() for line in lines for part in line.split("&&")]
    return [shlex.split(part)[1:] for part in parts if part.startswith("lwr-dyn ")]


def test_every_command_of_the_readme_runs(tmp_path, monkeypatch, capsys):
    prefix = next(p for p in Path(pinocchio.__file__).parents if p.name == "cmeel.prefix")
    assert "cmeel.prefix/share/example-robot-data/robots)\n" in README
    robots = str(prefix / "share" / "example-robot-data" / "robots")
    monkeypatch.chdir(tmp_path)
    ran = 0
    for arguments in commands():
        if " ".join(arguments).startswith(ELSEWHERE):
            continue
        arguments = [a.replace("$robots", robots).replace("scripts/", f"{ROOT}/scripts/") for a in arguments]
        with pytest.raises(SystemExit) as stop:
            main(arguments)
        expected = 1 if any(EXIT_1 in a for a in arguments) else 0
        assert stop.value.code == expected, (arguments, capsys.readouterr().err)
        ran += 1
    assert ran >= 12


def test_ci_runs_the_test_command_of_the_readme():
    command = "pip install '.[test]' && pytest -n auto"
    assert f"    {command}\n" in README
    assert command in (ROOT / ".ci" / "run").read_text().replace(" -q", "")


def test_every_robot_and_subcommand_is_mentioned():
    for robot in lwr_dyn.robots():
        assert f"`{robot}`" in README
    for name in COMMANDS.names:
        assert f"lwr-dyn {name}" in README or name in ("replay",)


def test_every_script_named_in_the_readme_exists():
    for script in re.findall(r"`(?:scripts/)?(\w+\.py)`", README):
        assert [*(ROOT / "scripts").rglob(script), *(ROOT / "lwr_dyn").rglob(script)], script
