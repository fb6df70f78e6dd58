"""The harness of planted slips itself: it replaces one text, and tells what a check does not see."""

import sys
from importlib import import_module
from types import ModuleType

import pytest

from tests.slips import slipped, uncaught

GAINS = "lwr_dyn.control.gains"
SLIPS = (("omega_n**2 * b", "omega_n * b"), ("2 * xi * omega_n * b", "xi * omega_n * b"))


def check_Kp(module: ModuleType) -> None:
    assert module.second_order_gains([2.0], 10.0).Kp[0] == 200.0


def test_slip_is_in_the_copy_alone() -> None:
    whole = import_module(GAINS)
    before = dict(sys.modules)
    assert slipped(GAINS, *SLIPS[0]).second_order_gains([2.0], 10.0).Kp[0] == 20.0
    check_Kp(whole)
    assert sys.modules == before


def test_check_that_looks_at_half_misses_the_other_half() -> None:
    assert uncaught(GAINS, SLIPS, check_Kp) == [f"{SLIPS[1][0]!r} -> {SLIPS[1][1]!r}"]


@pytest.mark.parametrize("text", ["nowhere in it", "omega_n"])
def test_text_must_stand_there_once(text: str) -> None:
    with pytest.raises(AssertionError, match="times in it"):
        slipped(GAINS, text, "x")


def test_badly_written_slip_is_no_catch() -> None:
    with pytest.raises(NameError):
        uncaught(GAINS, [("omega_n**2 * b", "not_there * b")], check_Kp)
