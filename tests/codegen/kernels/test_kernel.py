"""Kernels on disk: loaded without a compiler, rebuilt when damaged, safe with killed and concurrent processes."""

import hmac
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from importlib.metadata import version
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import kernel
from lwr_dyn.codegen.kernels.kernel import CacheWarning
from lwr_dyn.codegen.kernels.kernel_spec import kernel_spec
from lwr_dyn.codegen.rollouts import kernel as rollout_kernel
from lwr_dyn.foundation.errors import FileAccessError, MissingPackageError
from lwr_dyn.model.friction import symmetric

ARM = lwr_dyn.load("lwr4plus")
ONE = """
import sys, numpy as np, lwr_dyn
batch = lwr_dyn.batch_dynamics(lwr_dyn.load("lwr4plus"))
g = batch.gravity_vector(np.full((3, 7), 0.3))
print("casadi" in sys.modules, g[0, 1])
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A cache of its own, and a process that has loaded nothing."""
    monkeypatch.setenv("LWR_DYN_CACHE", str(tmp_path / "kernels"))
    monkeypatch.setattr(kernel, "_loaded", {})
    monkeypatch.setattr(kernel, "_warned", set())
    return tmp_path / "kernels"


def in_a_new_process():
    return subprocess.Popen([sys.executable, "-c", ONE], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def answer(process):
    """Whether it imported casadi, and its torque."""
    out, err = process.communicate()
    assert process.returncode == 0, err
    traced, value = out.split()
    return traced == "True", float(value)


def test_what_is_not_in_the_cache_or_damaged_is_made_and_kept(folder):
    calls = []

    def made():
        calls.append(len(calls))
        return b"code", RECORD

    def record(names=frozenset(RECORD)):
        return kernel._record_and_code("a", names, made)

    file = folder / "a.kernel"
    assert [record(), record()] == [(RECORD, b"code")] * 2
    assert len(calls) == 1
    file.write_bytes(file.read_bytes()[:-1])
    assert [record(), record()] == [(RECORD, b"code")] * 2
    assert len(calls) == 2
    record({"symbol", "more"})  # of another generator
    assert len(calls) == 3
    file.unlink()
    file.mkdir()
    with pytest.warns(CacheWarning, match="directory"):
        assert record() == (RECORD, b"code")
    assert len(calls) == 4


def test_a_folder_that_cannot_be_written_is_warned_of_once(tmp_path, folder, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("LWR_DYN_CACHE", str(tmp_path / "file" / "kernels"))
    with pytest.warns(CacheWarning, match="this process compiles its own; name another folder in LWR_DYN_CACHE"):
        kernel.write_cache("a", {}, b"code")
    kernel.write_cache("another", {}, b"code")  # no second warning: warnings are errors here
    assert kernel.read_cache("a") is None


@pytest.mark.slow
def test_processes_at_once_a_killed_one_and_a_later_one_that_loads_their_kernel(folder):
    several = [in_a_new_process() for _ in range(3)]
    time.sleep(0.8)
    several[0].send_signal(signal.SIGKILL)
    answers = [answer(process) for process in several[1:]]
    several[0].communicate()
    later = answer(in_a_new_process())
    assert True in {traced for traced, _ in answers}
    assert not later[0]  # nothing is traced or compiled again
    assert len({value for _, value in (*answers, later)}) == 1
    assert len(list(folder.glob("*.kernel"))) == 1
    assert os.stat(folder).st_mode & 0o777 == 0o700


def test_files_of_a_killed_process_are_deleted_later(folder):
    folder.mkdir(mode=0o700)
    old, young = folder / ".gravity.kernel.abc", folder / ".gravity.kernel.def"
    for path in (old, young):
        path.write_bytes(b"half")
    os.utime(old, (time.time() - 2 * 3600,) * 2)
    kernel.write_cache("a", {}, b"code")
    assert {path.name for path in folder.iterdir()} == {young.name, "a.kernel"}


def test_the_key_distinguishes_arms_choices_and_functions():
    rubbing = replace(ARM, friction=(symmetric(1.0, 0.1),) * 7)
    choices = [{}, {"dtype": "float32"}, {"inputs": ["gravity"]}, {"rotors": "none"}, {"layout": "blocks"}]
    specs = [kernel_spec(ARM, **choice) for choice in choices]
    specs += [kernel_spec(lwr_dyn.load("lwr4plus", "printed")), kernel_spec(rubbing, friction="arm")]
    keys = {kernel.key_of(spec, name) for spec in specs for name in ("gravity_vector", "mass_matrix")}
    assert len(keys) == 14
    assert kernel.key_of(kernel_spec(lwr_dyn.load("lwr4plus")), "mass_matrix") in keys


@pytest.mark.parametrize("package", ["llvmlite", "mpmath"])
@pytest.mark.parametrize(
    ("module", "key"),
    [
        (kernel, lambda: kernel.key_of(kernel_spec(ARM), "mass_matrix")),
        (rollout_kernel, lambda: rollout_kernel.plan_key("rollout", SimpleNamespace(digest="0"), "8")),
    ],
    ids=["kernel", "rollout"],
)
def test_the_key_distinguishes_versions_of_what_makes_the_code(monkeypatch, package, module, key):
    before = key()
    monkeypatch.setattr(module, "package_version", lambda name: "0.0" if name == package else version(name))
    assert key() != before


@pytest.mark.parametrize("package", ["llvmlite", "casadi", "mpmath"])
def test_an_absent_package_is_named(monkeypatch, package):
    monkeypatch.setattr(kernel, "find_spec", lambda name: None if name == package else object())
    for make in (lwr_dyn.batch_dynamics, lambda arm: lwr_dyn.dynamics_of(arm, "kernels")):
        with pytest.raises(MissingPackageError, match=rf"{package} is not installed.*pip install 'lwr_dyn\[batch\]'"):
            make(ARM)


def test_without_a_home_folder_kernels_are_not_kept(monkeypatch):
    for name in ("LWR_DYN_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")

    def no_home():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(kernel.Path, "home", no_home)
    assert kernel.read_cache("a") is None
    with pytest.warns(CacheWarning, match="no home folder"):
        kernel.write_cache("a", {}, b"code")


RECORD = {"symbol": "f"}


def exchanged(file, patch):
    """Two files exchanged: both are signed by this user, and each holds what the other's name says."""
    kernel.write_cache("b", RECORD, b"code of b")
    (file.parent / "b.kernel").replace(file)


def linked(file, patch):
    file.rename(file.with_name("elsewhere"))
    file.symlink_to("elsewhere")


def a_folder(file, patch):
    file.unlink()
    file.mkdir()


def signed_by_another(file, patch):
    """A kernel file as another user's process would write it: right in form, signed with another key."""
    content = b'{"symbol": "f"}\ncode'
    digest = hmac.digest(b"x" * 32, b"a\n" + content, "sha256").hex().encode() + b"\n"
    file.write_bytes(kernel._MARK + digest + content)


def content(made):
    return lambda file, patch: file.write_bytes(made(file.read_bytes()))


def record(text):
    return content(lambda _: kernel._MARK + kernel._digest("a", text) + text)


def mode(rights, of=lambda file: file):
    return lambda file, patch: of(file).chmod(rights)


NOT_READ = {
    "signed with another key": signed_by_another, "under the name of another": exchanged, "a link": linked,
    "a folder": a_folder, "of another user": lambda file, patch: patch.setattr(os, "getuid", lambda: -1),
    "cut": content(lambda whole: whole[:-1]), "empty": content(lambda whole: b""),
    "flipped": content(lambda whole: whole[:-2] + b"x" + whole[-1:]), "no kernel": content(lambda whole: b"else"),
    "of an older form": content(lambda whole: b"x" + whole[1:]),
    **{f"that others can write, {x:o}": mode(x) for x in (0o620, 0o602)},
    **{f"in a folder that others can write, {x:o}": mode(x, lambda file: file.parent) for x in (0o720, 0o702)},
    **{f"record {x[:4]!r}": record(x) for x in (b"[]\n", b"5\n", b"{\n", b"\n", b"[" * 100_000, b"\xff\n")},
}  # fmt: skip


@pytest.mark.parametrize("what", NOT_READ)
def test_what_is_not_whole_or_not_this_users_own_is_not_read(folder, monkeypatch, what):
    kernel.write_cache("a", RECORD, b"code")
    folder.chmod(0o755)  # others may read
    (folder / "a.kernel").chmod(0o644)
    assert kernel.read_cache("a") == (RECORD, b"code")
    NOT_READ[what](folder / "a.kernel", monkeypatch)
    assert kernel.read_cache("a") is None


def test_a_link_in_the_cache_is_not_written_through(folder, tmp_path):
    folder.mkdir(mode=0o700)
    (tmp_path / "elsewhere").write_bytes(b"mine")
    (folder / "a.kernel").symlink_to(tmp_path / "elsewhere")
    kernel.write_cache("a", RECORD, b"code")
    assert (tmp_path / "elsewhere").read_bytes() == b"mine"
    assert kernel.read_cache("a") == (RECORD, b"code")


@pytest.mark.parametrize("rights", [0o720, 0o770, 0o702])
def test_a_folder_that_others_can_write_is_not_written(folder, rights):
    folder.mkdir()
    folder.chmod(rights)
    reason = f"kernels is open to others: owner {os.getuid()}, mode {rights:o}"
    with pytest.warns(CacheWarning) as caught:
        kernel.write_cache("b", RECORD, b"code")
    assert str(caught[0].message) == (
        f"compiled kernels cannot be kept in {folder} ({reason}): this process compiles its own; "
        "name another folder in LWR_DYN_CACHE"
    )
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("count", "threads", "parts"),
    [
        (100_000, 1, [(0, 100_000)]),
        (3 * 2048 - 1, 2, [(0, 3072), (3072, 6143)]),
        (131_072, 2, [(16_384 * i, 16_384 * (i + 1)) for i in range(8)]),
        (20, 3, [(0, 20)]),
    ],
)
def test_states_are_shared_out_in_whole_blocks_and_what_is_invalid_is_added_up(count, threads, parts):
    """By code that notes its part; 4 a thread, none of fewer than 2048 states, blocks of 8 lanes."""
    calls = []

    def call(*given):
        calls.append(given)
        return len(given)

    made = kernel.Kernel(SimpleNamespace(lanes=8, buffer=3), np.dtype("f8"), SimpleNamespace(call=call))
    assert made.run([(1000, 7), (2000, 0)], 3000, count, threads) == 8 * len(parts)
    assert sorted(given[-2:] for given in calls) == parts
    assert {given[:5] for given in calls} == {(1000, 7, 2000, 0, 3000)}
    assert {given[5] % 64 for given in calls} == {0}


def test_the_key_is_the_users_own_and_secret(folder, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "user"))
    key = tmp_path / "user" / "lwr_dyn" / "key"
    assert kernel._digest("a", b"x") == kernel._digest("a", b"x")
    assert key.stat().st_mode & 0o777 == 0o600
    assert len(key.read_bytes()) == 32
    key.chmod(0o644)
    with pytest.raises(PermissionError):
        kernel._digest("a", b"x")
    key.chmod(0o600)
    key.write_bytes(b"short")
    with pytest.raises(FileAccessError, match="5 bytes; allowed: 32 secret bytes"):
        kernel._digest("a", b"x")
