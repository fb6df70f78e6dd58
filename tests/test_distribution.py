"""What a worker of pytest-xdist takes as one piece, and what begins first."""

from pathlib import Path
from types import SimpleNamespace

from tests.distribution import LONGEST, SPREAD, in_order, scope

ROOT = Path(__file__).resolve().parents[1]


def test_a_file_is_one_piece_and_a_spread_one_many():
    assert scope("tests/a/test_b.py::TestC::test_d[x::y]") == "tests/a/test_b.py"
    assert scope(f"{SPREAD[0]}::test_e[f]") == f"{SPREAD[0]}::test_e[f]"


def test_the_longest_begin_and_others_keep_their_order():
    names = ["tests/model/test_a.py::b", f"{LONGEST[1]}::c", "tests/cli/test_d.py::e", f"{LONGEST[0]}::f"]
    items = in_order(SimpleNamespace(nodeid=name) for name in names)
    assert [item.nodeid for item in items] == [names[3], names[1], names[0], names[2]]


def test_what_is_named_is_there_and_what_is_spread_shares_nothing():
    assert all((ROOT / name).exists() for name in (*LONGEST, *SPREAD))
    for name in SPREAD:
        assert 'scope="module"' not in (ROOT / name).read_text(encoding="utf-8")
