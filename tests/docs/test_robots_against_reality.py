"""The tables of the page that need no log from elsewhere are those that the program makes now."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_the_tables_are_fresh(monkeypatch):
    monkeypatch.setattr(sys, "path", [str(ROOT / "scripts"), *sys.path])
    import robots_against_reality as made

    page = made.PAGE.read_text("utf-8")
    found = {"shipped": made.shipped(), "copies": made.copies(), "panda-b": made.ranked("panda-b")}
    assert "panda:gaz" in found["shipped"]
    assert "`ur10e:maker` | tensors | `ur10:maker`" in found["copies"]
    assert made.with_tables(page, found) == page
