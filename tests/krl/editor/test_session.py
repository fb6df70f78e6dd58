"""To which project a file belongs; a folder with too many entries is none, and nothing of it is read."""

import pytest

from lwr_dyn.krl.editor import session as module
from lwr_dyn.krl.editor.session import Session, backup_above, has_more_entries
from tests.krl.small_backup import MAIN, write_backup


@pytest.mark.parametrize(
    ("path", "folder"),
    [
        ("/cells/left/KRC/R1/Program/a.src", "/cells/left"),
        ("/cells/left/R1/Program/a.src", "/cells/left"),
        ("/cells/left/krc/steu/Mada/a.dat", "/cells/left"),
        ("/R1/old/KRC/R1/a.src", "/R1/old"),
        ("/cells/left/Program/a.src", None),
        ("/cells/R1.src", None),
    ],
)
def test_a_backup_is_the_folder_that_holds_the_parts_of_a_controller(path, folder):
    found = backup_above(module.Path(path))
    assert (found and found.as_posix()) == folder


def test_entries_are_counted_below_but_for_hidden_folders(tmp_path):
    for name in ("a/b", "a/c", ".git/x", ".git/y"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("")
    assert has_more_entries(tmp_path, 2)
    assert not has_more_entries(tmp_path, 3)


def test_in_a_root_with_too_many_entries_a_file_belongs_to_its_backup(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "has_more_entries", lambda folder: folder == tmp_path)
    backup = write_backup(tmp_path / "cells" / "left")
    (tmp_path / "loose.src").write_text("DEF loose( )\nEND\n")
    session = Session()
    session.add_folder(tmp_path)
    project, name = session.place(backup / MAIN)
    assert (project.folder, project.whole, name) == (backup, True, MAIN)
    assert session.place(tmp_path / "loose.src")[0].whole is False
    assert session.place(tmp_path / "cells" / "a.src")[0].folder == tmp_path / "cells"
    names = {x.file.name for each in session.projects() for x in each.project.files}
    assert names >= {MAIN, "loose.src"}
    assert not any(x.startswith("cells/") for x in names)


def test_a_backup_with_too_many_entries_is_not_read_either(tmp_path, monkeypatch):
    backup = write_backup(tmp_path)
    monkeypatch.setattr(module, "has_more_entries", lambda _: True)
    project, name = Session().place(backup / MAIN)
    assert (project.whole, name) == (False, "main.src")


def test_without_a_folder_a_file_of_a_backup_sees_all_of_it(tmp_path):
    project, name = Session().place(write_backup(tmp_path) / MAIN)
    assert (project.folder, project.diagnostics(name)[name]) == (tmp_path, ())


def test_a_file_that_is_no_text_is_not_read(tmp_path):
    backup = write_backup(tmp_path)
    (backup / "KRC" / "R1" / "icons.dat").write_bytes(b"\0\1" * 5_000_000)
    project, _ = Session().place(backup / MAIN)
    assert not any("icons" in x.file.name for x in project.project.files)
