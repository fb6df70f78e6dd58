"""Files are read with one clear error and written completely or not at all."""

import os
import sys
import time

import pytest

from lwr_dyn.foundation import files
from lwr_dyn.foundation.errors import FileAccessError


def test_what_is_written_is_read_back(tmp_path):
    files.write_folder(tmp_path / "a" / "b", {"text.txt": "µ\n", "bytes.bin": b"\xff"})
    assert files.read_text(tmp_path / "a" / "b" / "text.txt", "a text") == "µ\n"
    assert files.read_bytes(tmp_path / "a" / "b" / "bytes.bin", "bytes") == b"\xff"
    assert sorted(path.name for path in (tmp_path / "a" / "b").iterdir()) == ["bytes.bin", "text.txt"]


def test_what_cannot_be_read_names_the_path_and_what_is_needed(tmp_path):
    with pytest.raises(FileAccessError, match=r"none\.txt: no such file or directory; allowed: a text"):
        files.read_text(tmp_path / "none.txt", "a text")
    (tmp_path / "latin.txt").write_bytes(b"\xb5")
    with pytest.raises(FileAccessError, match=r"latin\.txt: not UTF-8 text; allowed: a text"):
        files.read_text(tmp_path / "latin.txt", "a text")
    with pytest.raises(FileAccessError, match=r"latin\.txt: 1 bytes; allowed: at most 0 bytes"):
        files.read_bytes(tmp_path / "latin.txt", "a text", largest=0)


def test_a_file_keeps_its_rights_and_a_link_stays_one_unless_it_is_in_a_folder_of_ours(tmp_path):
    path, link, mask = tmp_path / "x", tmp_path / "link", os.umask(0o027)
    try:
        files.write_file(path, "new")
    finally:
        os.umask(mask)
    assert path.stat().st_mode & 0o777 == 0o640
    path.chmod(0o604)
    link.symlink_to(path)
    files.write_file(link, "through it")
    assert (link.is_symlink(), path.read_text(), path.stat().st_mode & 0o777) == (True, "through it", 0o604)
    files.write_in_place(link, "in its place")
    assert (link.is_symlink(), path.read_text(), link.read_text()) == (False, "through it", "in its place")


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    files.write_file(tmp_path / "x", "old")
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(FileAccessError, match="no space left on device"):
        files.write_files({tmp_path / "x": "new", tmp_path / "y": "new"})
    assert [path.name for path in tmp_path.iterdir()] == ["x"]
    assert (tmp_path / "x").read_text() == "old"


def test_a_place_that_cannot_be_written_is_refused_at_once(tmp_path):
    files.check_writable(tmp_path / "x")
    (tmp_path / "file").write_text("")
    with pytest.raises(FileAccessError, match="allowed: a file in an existing, writable"):
        files.write_files({tmp_path / "none" / "x": ""})
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("link")
    for place, reason in (
        (tmp_path, "is a directory"), (tmp_path / "none" / "x", "no directory"), (tmp_path / "pipe", "a pipe or a"),
        ("x\0", "a null character"), (tmp_path / "link", "a link that leads to itself"),
    ):  # fmt: skip
        with pytest.raises(FileAccessError, match=f"{reason}.*; allowed: a file in an existing, writable"):
            files.check_writable(place)
    with pytest.raises(FileAccessError, match=r"does not end in \.urdf; allowed: a path that ends in \.urdf"):
        files.check_writable(tmp_path / "x", ".urdf")
    with pytest.raises(FileAccessError, match="a directory that exists or can be made, and can be written"):
        files.make_folder(tmp_path / "file" / "x")


def test_what_a_killed_process_left_is_deleted_by_a_later_write(tmp_path):
    old, young, other = (tmp_path / name for name in (".x[1].abcdefgh.part", ".x[1].ijklmnop.part", ".x[1].bak"))
    for path in (old, young, other):
        path.write_text("half")
        if path != young:
            os.utime(path, (time.time() - 3660.0,) * 2)
        else:
            os.utime(path, (time.time() - 3540.0,) * 2)
    files.write_file(tmp_path / "x[1]", "whole")
    assert sorted(path.name for path in tmp_path.iterdir()) == [".x[1].bak", ".x[1].ijklmnop.part", "x[1]"]


@pytest.mark.skipif(sys.platform != "linux", reason="the cache folder of Linux")
def test_the_cache_folder_is_the_one_that_is_named_or_below_the_home(tmp_path, monkeypatch):
    for name in ("LWR_DYN_CACHE", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    for system, caches in (("win32", "AppData/Local"), ("darwin", "Library/Caches"), ("linux", ".cache")):
        monkeypatch.setattr(sys, "platform", system)
        assert files.cache_folder() == tmp_path / caches / "lwr_dyn"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "caches"))
    assert files.cache_folder() == tmp_path / "caches" / "lwr_dyn"
    monkeypatch.setenv("LWR_DYN_CACHE", str(tmp_path / "kernels"))
    assert files.cache_folder() == tmp_path / "kernels"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(files.Path, "home", lambda: (_ for _ in ()).throw(RuntimeError()))
    with pytest.raises(FileAccessError, match="~: no home folder; allowed: a folder in HOME"):
        files.user_folder()


def test_only_a_regular_file_of_at_most_the_given_size_is_readable(tmp_path):
    (tmp_path / "full").write_bytes(b"abc")
    os.mkfifo(tmp_path / "pipe")
    files.check_readable(tmp_path / "full", "a file", 3)
    for name, largest, message in (
        ("full", 2, "3 bytes; allowed: at most 2 bytes"),
        ("pipe", None, "a pipe or a device; allowed: a regular file: a file"),
        ("", None, "is a directory; allowed: a file"),
        ("none", None, "no such file or directory; allowed: a file"),
        ("x\0", None, "a null character; allowed: a file"),
    ):
        with pytest.raises(FileAccessError, match=message):
            files.check_readable(tmp_path / name, "a file", largest)
