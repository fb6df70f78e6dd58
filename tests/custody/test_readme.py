"""README and pages name what exists, and CI runs the README's test command. Their blocks are run by `tests/docs`."""

import re
from pathlib import Path

import click

import lwr_dyn
from lwr_dyn.cli.main import COMMANDS, group

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = README + "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs").rglob("*.md"))


def test_the_readme_is_a_screen_and_a_half():
    assert len(README.splitlines()) <= 110


def test_ci_runs_the_test_command_of_the_readme():
    """Its two halves, in this order, the second with the slow tests; between them lint and types begin beside."""
    halves = ("pip install '.[test]'", "pytest -n auto")
    assert f"    {' && '.join(halves)}\n" in README
    lines = (ROOT / ".ci" / "run").read_text(encoding="utf-8").replace(" -q", "").splitlines()
    end = """( #| -m "slow or not slow" |$)"""
    places = [[i for i, line in enumerate(lines) if re.match(re.escape(half) + end, line)] for half in halves]
    assert [len(found) for found in places] == [1, 1]
    assert places[0] < places[1]


def test_every_robot_is_in_the_readme_and_every_command_on_a_page():
    for robot in lwr_dyn.robots():
        assert f"`{robot}`" in README
    for name in COMMANDS.names:
        assert f"lwr-dyn {name}" in PAGES, name


def test_every_command_that_is_named_exists():
    """In data files, code and pages: `lwr-dyn NAME`, and of a group its command."""
    main = click.Context(group)
    files = [*(ROOT / "lwr_dyn").rglob("*.py"), *(ROOT / "lwr_dyn").rglob("*.toml"), *(ROOT / "docs").rglob("*.md")]
    named = {}
    for path in [ROOT / "README.md", ROOT / "action.yml", *files]:
        for words in re.findall(r"\blwr-dyn (?!--)([a-z][\w-]*(?: [a-z][\w-]*)?)", path.read_text(encoding="utf-8")):
            named.setdefault(words, path)
    for words, path in named.items():
        name, _, inner = words.partition(" ")
        command = group.get_command(main, name) if name in COMMANDS.names else None
        assert command is not None, f"{path}: lwr-dyn {name}"
        if isinstance(command, click.Group) and inner:
            assert inner in command.list_commands(main), f"{path}: lwr-dyn {words}"
    assert len(named) > 50


def test_every_script_that_is_named_exists():
    for script in re.findall(r"`(?:scripts/)?(?:examples/)?(\w+\.py)`", PAGES):
        assert [*(ROOT / "scripts").rglob(script), *(ROOT / "lwr_dyn").rglob(script)], script


def test_every_relative_link_of_the_readme_leads_to_a_file():
    links = re.findall(r"\]\((?!https?://)([^)#]+)", README)
    assert len(links) > 10
    assert [link for link in links if not (ROOT / link).is_file()] == []
