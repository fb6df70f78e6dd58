"""Paths that are hostile: pipes, devices, null characters, names that are too long, links."""

import os
import stat

import pytest

import lwr_dyn
from lwr_dyn.checks.tables.rules import sheet_of_file
from lwr_dyn.foundation.errors import FileAccessError, LwrDynError
from lwr_dyn.foundation.files import LARGEST, check_readable, check_writable, read_bytes, write_file
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.krl.project.program import load_program
from lwr_dyn.krl.writing.point_program import read_point_program
from lwr_dyn.model.run import Run

DEVICES = ("zero", "full", "null", "stdin")
READERS = {
    ".toml": (lwr_dyn.load, sheet_of_file, lambda path: read_point_program(path, lwr_dyn.load("kr30ha"))),
    ".urdf": (lwr_dyn.load,),
    ".csv": (read_log, sheet_of_file),
    ".parquet": (read_log,),
    ".npz": (Run.load,),
    ".src": (load_program,),
}


READ = [
    pytest.param(ending, read, id=f"{ending}-{k}") for ending, some in READERS.items() for k, read in enumerate(some)
]


@pytest.mark.parametrize(("ending", "read"), READ)
def test_what_is_no_regular_file_or_has_no_name_is_refused_at_once(ending, read, tmp_path):
    """A pipe that no one writes, links to devices, a null character, a long name, a file of 3 GB."""
    pipe, large = tmp_path / f"pipe{ending}", tmp_path / f"large{ending}"
    os.mkfifo(pipe)
    with pytest.raises(FileAccessError, match=r"pipe\.\w+: a pipe or a device; allowed: a regular file"):
        read(pipe)
    for device in DEVICES:
        link = tmp_path / f"{device}{ending}"
        link.symlink_to(f"/dev/{device}")
        with pytest.raises(FileAccessError):
            read(link)
    for name in (f"a\0b{ending}", "n" * 300 + ending):
        with pytest.raises(LwrDynError):
            read(name)
    with open(large, "wb") as stream:
        stream.truncate(3_000_000_000)  # takes no room on the disk
    check_readable(large, "a file")
    if ending in (".toml", ".urdf", ".src", ".npz"):
        with pytest.raises(FileAccessError, match=r"3000000000 bytes; allowed: at most \d+ bytes"):
            read(large)


def test_what_is_no_regular_file_is_not_replaced(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    link = tmp_path / "null"
    link.symlink_to("/dev/null")
    for path in (pipe, link, "/dev/null", "/dev/full"):
        for write in (check_writable, lambda x: write_file(x, "text")):
            with pytest.raises(FileAccessError, match="a pipe or a device; allowed: a file in an existing"):
                write(path)
    assert (stat.S_ISFIFO(pipe.lstat().st_mode), link.is_symlink(), LARGEST < 100_000_000) == (True, True, True)
    for device in DEVICES:
        with pytest.raises(FileAccessError, match=r"a pipe or a device|no such"):
            read_bytes(f"/dev/{device}", "a file")
    for name in ("a\0b", "n" * 300):
        with pytest.raises(FileAccessError):
            write_file(name, b"")


def test_a_link_stays_a_link_and_its_file_keeps_its_rights(tmp_path):
    (tmp_path / "there").mkdir()
    file, link = tmp_path / "there" / "file", tmp_path / "link"
    file.write_text("old")
    file.chmod(0o640)
    link.symlink_to(file)
    write_file(link, "new")
    assert (link.is_symlink(), file.read_text(), stat.S_IMODE(file.stat().st_mode)) == (True, "new", 0o640)
    dangling = tmp_path / "dangling"
    dangling.symlink_to(tmp_path / "there" / "made")
    write_file(dangling, "made")
    assert (dangling.is_symlink(), (tmp_path / "there" / "made").read_text()) == (True, "made")
    assert sorted(x.name for x in tmp_path.rglob("*")) == ["dangling", "file", "link", "made", "there"]
    loop = tmp_path / "loop"
    loop.symlink_to(loop)
    with pytest.raises(FileAccessError):
        write_file(loop, "x")


def test_the_command_names_the_file_that_it_cannot_write(lwr_dyn_command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name = "n" * 300
    for arguments in (("urdf", "lwr4", "--out", name), ("simulate", "lwr4plus", "--out", f"{name}.npz")):
        code, out, err = lwr_dyn_command(*arguments)
        assert (code, out, err.count("\n"), "stdout" in err) == (2, "", 1, False)
        assert err.startswith(f"lwr-dyn: {name}")
    assert list(tmp_path.iterdir()) == []
