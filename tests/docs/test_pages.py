"""Every page is true: its commands print what it shows, its Python runs, its links lead somewhere."""

import re
from pathlib import Path

import click
import pytest

from lwr_dyn.cli.main import group
from tests.docs.blocks import blocks
from tests.docs.console import ROOT, run_page
from tests.optional import need

PAGES = [ROOT / "README.md", *sorted(p for p in (ROOT / "docs").rglob("*.md") if "_build" not in p.parts)]
NOT_RUN = 12
"""Blocks of all pages that are shown and not run, at most; each has its reason beside it."""

NEEDS = {"docs/how_to/jax_and_torch.md": "jax"}
"""Page -> a package that it is about and that CI does not have: its lines run where it is installed."""


def name(page: Path) -> str:
    """A page as it is called in a report."""
    return page.relative_to(ROOT).as_posix()


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=name)
def test_a_page_does_what_it_shows(page, tmp_path):
    if name(page) in NEEDS:
        need(NEEDS[name(page)])
    folder = tmp_path / "page"
    folder.mkdir()
    run_page(page.read_text(encoding="utf-8"), folder, page=name(page))


def test_few_blocks_are_not_run_none_advises_a_lossy_encoding_and_an_unknown_option_is_seen():
    every = [(name(page), block) for page in PAGES for block in blocks(page.read_text(encoding="utf-8"))]
    reasons = [(page, block.reason) for page, block in every if block.reason is not None]
    assert len(reasons) <= NOT_RUN, reasons
    for page, block in every:  # a default that an extension of VS Code brings comes after the file was opened as UTF-8
        text = "\n".join(block.lines)
        assert not ("configurationDefaults" in text and "files.encoding" in text), f"{page}:{block.line}"
    text = "`lwr-dyn check x --html y`, `lwr-dyn krl run a.src --out b`"
    assert unknown_options(text) == ["--html of check x --html y"]


def unknown_options(text: str) -> list[str]:
    """Options of `lwr-dyn` that a text names and the command does not have; of a command that is none, its name."""
    found = []
    for line in re.findall(r"lwr-dyn ([a-z][^`\n|;&#)]*)", text):
        command, words = group, line.split()
        while isinstance(command, click.Group) and words and words[0] in command.list_commands(click.Context(command)):
            command = command.get_command(click.Context(command), words.pop(0))
        named = [] if command is group else command.get_params(click.Context(command))
        known = {"--help", *(option for one in named for option in (*one.opts, *one.secondary_opts))}
        given = {word.split("=")[0].rstrip(".,:") for word in words if word.startswith("--")}
        found += [f"{option} of {line}" for option in sorted(given - known) if command is not group]
    return found


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md", ROOT / "ARCHITECTURE.md"], ids=name)
def test_every_option_that_a_page_names_is_there(page):
    """Also of commands that stand in a sentence or are not run."""
    assert unknown_options(page.read_text(encoding="utf-8")) == []
