"""`lwr-dyn lsp` without an editor, and what it makes of a URDF."""

import sys

import pytest

from lwr_dyn.cli.lsp import judged
from lwr_dyn.foundation.errors import FileAccessError


@pytest.mark.parametrize("name", [("lsp",), ("krl", "server")])
def test_at_a_terminal_it_says_that_an_editor_starts_it(name, lwr_dyn_command, monkeypatch):
    monkeypatch.setattr(sys, "stdin", type("Terminal", (), {"isatty": lambda _: True})())
    code, _, err = lwr_dyn_command(*name)
    assert (code, "an editor that speaks" in err) == (2, True)


def test_findings_of_a_text_stand_in_the_file_and_name_a_tag_where_they_have_one(tmp_path):
    joint = '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'
    text = f'<robot name="r"><link name="a"/>{joint}</robot>'
    found = next(x for x in judged(tmp_path / "r.urdf", text) if x.code == "link-unknown")
    assert (found.file, found.line, found.severity) == (str(tmp_path / "r.urdf"), 1, "error")
    assert text[found.column - 1 :].startswith('<child link="b"/>')
    assert found.message.startswith("joint j: ")
    with pytest.raises(FileAccessError):
        judged(tmp_path / "gone.urdf", None)
