"""Every page is true: its commands print what it shows, its Python runs, its links lead somewhere."""

from pathlib import Path

import pytest

from tests.docs.blocks import blocks
from tests.docs.console import ROOT, run_page

PAGES = [ROOT / "README.md", *sorted(p for p in (ROOT / "docs").rglob("*.md") if "_build" not in p.parts)]
NOT_RUN = 12
"""Blocks of all pages that are shown and not run, at most; each has its reason beside it."""


def name(page: Path) -> str:
    """A page as it is called in a report."""
    return page.relative_to(ROOT).as_posix()


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=name)
def test_a_page_does_what_it_shows(page, tmp_path):
    folder = tmp_path / "page"
    folder.mkdir()
    run_page(page.read_text(encoding="utf-8"), folder, page=name(page))


def test_few_blocks_are_not_run():
    reasons = [
        (name(page), block.reason)
        for page in PAGES
        for block in blocks(page.read_text(encoding="utf-8"))
        if block.reason is not None
    ]
    assert len(reasons) <= NOT_RUN, reasons


def test_no_page_advises_an_encoding_that_loses_bytes():
    """A default that an extension of VS Code brings comes after the file was opened as UTF-8."""
    for page in PAGES:
        for block in blocks(page.read_text(encoding="utf-8")):
            text = "\n".join(block.lines)
            assert not ("configurationDefaults" in text and "files.encoding" in text), f"{name(page)}:{block.line}"
