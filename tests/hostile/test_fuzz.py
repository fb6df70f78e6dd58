"""A seeded share of the fuzzed inputs, and any bytes: only our errors come out; `scripts/soak.py fuzz` has all."""

import contextlib
import random
import warnings

import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.checks.tables.rules import lint, sheet_of_file
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.krl.project.program import load_program
from lwr_dyn.model.run import Run
from tests.examples import examples
from tests.hostile.changes import changed, flipped
from tests.hostile.readers import READERS, one_input

COUNT = 80
SHARE = 0.25
"""Of its inputs that each reader must read: else only its first checks are tried."""


def linted(path):
    return lint(sheet_of_file(path))


BYTES = {
    ".toml": (lwr_dyn.load, linted), ".urdf": (lwr_dyn.load,), ".csv": (linted, read_log),
    ".parquet": (read_log,), ".npz": (Run.load,), ".src": (load_program,),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_changed_good_files_are_read_or_refused(name, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        read = sum(one_input(name, 7, number, tmp_path) for number in range(COUNT))
    assert read >= SHARE * COUNT
    if name != "URDF judged":  # which also judges what no one can read
        assert read < COUNT


@pytest.mark.slow
@pytest.mark.parametrize("ending", BYTES)
@examples(20)
@given(data=st.binary(max_size=300) | st.text(max_size=300).map(lambda text: text.encode("utf-8", "replace")))
def test_any_bytes_are_read_or_refused(ending, data, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / f"any{ending}"
    path.write_bytes(data)
    for read in BYTES[ending]:
        with contextlib.suppress(LwrDynError):
            read(path)


def test_the_changes_change_and_follow_their_seed():
    text = "a = 1.5\nb = [2.5, 3.5]\n"
    outcomes, again = ([changed(text, random.Random(k)) for k in range(200)] for _ in range(2))
    assert outcomes == again
    assert sum(x != text for x in outcomes) > 150
    assert len(set(outcomes)) > 100
    assert flipped(b"abcd" * 20, random.Random(1)) == flipped(b"abcd" * 20, random.Random(1)) != b"abcd" * 20
