"""To which project a file belongs; a folder with too many entries is none, and nothing of it is read."""

from pathlib import Path

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
        ("/R1/Program/a.src", "/"),
        ("/cells/left/Program/a.src", None),
        ("/cells/R1.src", None),
        ("/cells/R1", None),
    ],
)
def test_a_backup_is_the_folder_that_holds_the_parts_of_a_controller(path, folder):
    found = backup_above(Path(path))
    assert (found and found.as_posix()) == folder


def test_entries_are_counted_below_but_for_hidden_folders(tmp_path):
    for name in ("a/b", "a/c", ".git/x", ".git/y"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("")
    assert (has_more_entries(tmp_path, 2), has_more_entries(tmp_path, 3)) == (True, False)


def placed(session, path):
    project, name = session.place(path)
    return project.folder, project.whole, name


def test_in_a_root_with_too_many_entries_a_file_belongs_to_its_backup(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "has_more_entries", lambda folder: folder == tmp_path)
    backup = write_backup(tmp_path / "cells" / "left")
    (tmp_path / "loose.src").write_text("DEF loose( )\nEND\n")
    session = Session()
    session.add_folder(tmp_path)
    assert placed(session, backup / MAIN) == (backup, True, MAIN)
    assert placed(session, tmp_path / "loose.src") == (tmp_path, False, "loose.src")
    assert placed(session, tmp_path / "cells" / "a.src") == (tmp_path / "cells", False, "a.src")
    names = {x.file.name for each in session.projects() for x in each.project.files}
    assert names >= {MAIN, "loose.src"}
    assert not any(x.startswith("cells/") for x in names)


def test_a_backup_with_too_many_entries_is_not_read_either(tmp_path, monkeypatch):
    backup = write_backup(tmp_path)
    monkeypatch.setattr(module, "has_more_entries", lambda _: True)
    session = Session()
    assert placed(session, backup / MAIN) == ((backup / MAIN).parent, False, "main.src")
    session.add_folder(tmp_path)
    assert [x.folder for x in session.projects()] == [(backup / MAIN).parent]


def test_the_innermost_folder_of_the_editor_counts_and_outside_of_all_the_files_beside_it(tmp_path):
    backup = write_backup(tmp_path / "backup")
    session = Session()
    assert placed(session, backup / MAIN) == (backup, True, MAIN)  # no folder is open: the backup
    assert session.place(backup / MAIN)[0].diagnostics(MAIN)[MAIN] == ()
    for folder in (tmp_path, backup / "KRC"):
        session.add_folder(folder)
    assert placed(session, backup / MAIN) == (backup / "KRC", True, "R1/Program/main.src")
    for folder in (backup / "KRC", backup, tmp_path):
        session.remove_folder(folder)
    project, name = session.place(backup / "loose.src")
    assert (project.whole, name) == (False, "loose.src")
    project.set_text(name, "DEF loose( )\nSPEED = 1\nEND\n")
    assert [(d.position.line, d.code) for d in project.diagnostics(name)[name]] == [(2, "undeclared")]
    assert [x.file.name for x in project.project.files] == ["loose.src"]


def test_a_file_that_is_no_text_is_not_read(tmp_path):
    backup = write_backup(tmp_path)
    (backup / "KRC" / "R1" / "icons.dat").write_bytes(b"\0\1" * 5_000_000)
    project, _ = Session().place(backup / MAIN)
    assert not any("icons" in x.file.name for x in project.project.files)
