"""The order of candidates: repeated links first, then price, then fuller bodies; the same reading once."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from lwr_dyn.checks.conventions import candidates
from lwr_dyn.checks.conventions.printed_table import CellChange, LinkChoice, TableChoice, TableReading
from lwr_dyn.model.chain import Convention

TABLE = TableChoice(Convention.STANDARD, "com")
PLAIN, ODD = LinkChoice(), LinkChoice("integral", "zxy", "row")
READING = TableReading(TABLE, (PLAIN, ODD), 1, (CellChange("com", 4, 2, 0.0044, -0.0238),))
BEST = candidates.Candidate(READING, (), 2, float("nan"), 0.5, ("link_2",), 3.0, (), ())


def other(axes, **values):
    return replace(BEST, reading=replace(READING, links=(PLAIN, LinkChoice(axes=axes))), **values)


def test_a_candidate_as_values():
    assert BEST.record() | {"mirror_miss": None} == {
        "convention": "standard", "about": "com", "com_from": "own frame", "products": ["tensor", "integral"],
        "axes": ["xyz", "zxy"], "axes_move": ["tensor", "row"], "rows_lower": 1,
        "cells": {"c5z": {"printed": 0.0044, "read": -0.0238}}, "exceptions": 2, "mirror_miss": None,
        "infeasible": ["link_2"], "fullness": 3.0,
    }  # fmt: skip


def test_exceptions_and_their_price():
    choices = (ODD, PLAIN, LinkChoice(axes="zxy"))
    counts = [[candidates.exceptions_of(x, rule) for rule in ("integral", "tensor")] for x in choices]
    assert (counts, BEST.price) == ([[2, 3], [1, 0], [2, 1]], 6.5)
    assert [replace(BEST, log_inertia_volume=x).volume_level for x in (3.1, 3.4, -float("inf"))] == [
        6, 7, round(2 * candidates.NO_BODY),
    ]  # fmt: skip


def test_the_fewest_exceptions_are_those_of_the_better_rule():
    """Two of three links can only be integrals: with that rule one link is read apart."""
    options = [SimpleNamespace(choices=((x,),), log_inertia_volume=[0.0]) for x in (PLAIN, ODD, LinkChoice("integral"))]
    two = SimpleNamespace(choices=((ODD,), (ODD, LinkChoice("integral"))), log_inertia_volume=[9.0, 0.0])
    hypothesis = SimpleNamespace(options=[options[0], two, options[2]])
    assert candidates.fewest_exceptions(hypothesis, [(0,), (0, 1), (0,)]) == 1
    assert candidates.fewest_exceptions(hypothesis, [(0,), (0,), (0,)]) == 3


def test_mirror_misses_within_a_factor_count_as_equal():
    near, far = (replace(BEST, mirror_miss=x) for x in (candidates.FACTOR * 0.01, candidates.FACTOR * 0.01 + 1e-9))
    assert (near.is_mirrored(0.01), far.is_mirrored(0.01), BEST.is_mirrored(0.0)) == (True, False, True)
    assert candidates.best_mirror_miss([far, near, BEST]) == near.mirror_miss
    assert candidates.best_mirror_miss([BEST]) == 0.0


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ({"mirror_miss": 0.01, "exceptions": 5}, {"mirror_miss": 0.03, "exceptions": 0}),
        ({"mirror_miss": 0.019, "exceptions": 0}, {"mirror_miss": 0.01, "exceptions": 1}),
        ({"exceptions": 1, "misfit": 0.0}, {"exceptions": 0, "misfit": 3.6}),
        ({"exceptions": 0, "misfit": 3.1}, {"exceptions": 1, "misfit": 0.0}),
        ({"exceptions": 1, "log_inertia_volume": 1.0}, {"exceptions": 2, "log_inertia_volume": 9.0}),
        ({"log_inertia_volume": 4.0}, {"log_inertia_volume": 3.0}),
    ],
)
def test_the_order(first, second):
    a, b = other("xzy", **first), other("yxz", **second)
    assert candidates.ranked([a, b]) == candidates.ranked([b, a]) == (a, b)


def test_a_reading_stands_once_and_the_list_is_bounded():
    worse = replace(BEST, exceptions=3, reading=replace(READING, shift=0))
    assert candidates.ranked([worse, BEST]) == (BEST,)
    assert (
        len(candidates.ranked([other(f"a{k}") for k in range(candidates.MOST_CANDIDATES + 5)]))
        == candidates.MOST_CANDIDATES
    )
