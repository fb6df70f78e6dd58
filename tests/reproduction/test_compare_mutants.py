"""Every number matters: a seeded share of all mutants of the data; `scripts/soak.py mutants` runs them all."""

import random

import pytest

from lwr_dyn.reproduction.paper_study import paper_study
from lwr_dyn.reproduction.papers import studies
from tests.reproduction import mutants as changes
from tests.reproduction.mutants import fate, mutants, usual_judgement

SHARE, SLOW_SHARE = 28, {"kr30ha": 10}
"""Mutants a paper."""
SEEN = 0.75
"""Least share of them that is seen; the full counts stand in the README."""


@pytest.mark.slow
@pytest.mark.parametrize("paper", studies())
def test_no_mutant_moves_a_number_unseen(paper):
    chosen = random.Random(20261121).sample(list(mutants(paper)), SLOW_SHARE.get(paper, SHARE))
    found = changes.survey(paper, chosen)
    assert [(f.mutant.place, f.mutant.kind, f.mover, f.moved) for f in found.missed] == []
    assert found.share > SEEN, found.survivors()


def test_each_kind_of_change_is_made():
    kinds = [m.kind for m in mutants("lwr4plus")]
    assert set(kinds) == set(changes.KINDS)
    masses = [m for m in mutants("lwr4plus") if m.place == "inertial.mass.values[4]"]
    assert [(m.kind, m.after) for m in masses] == [
        ("sign", -1.8789), ("times ten", 18.789), ("neighbour", 1.2172), ("one percent", 1.8789 * 1.01),
    ]  # fmt: skip
    printed = {m.kind: m.after for m in mutants("lwr4plus") if m.place == "results.table_iv.cells.b[6]"}
    assert printed == {"sign": "-0.001756", "times ten": "0.017560", "one percent": "0.001774"}


def test_an_exchange_changes_both_cells_and_the_original_stays():
    raw = paper_study("lwr4plus").data.tables
    (exchange,) = (m for m in mutants("lwr4plus") if m.place == "inertial.mass.values[4]" and m.kind == "neighbour")
    found = changes.mutated(raw, exchange)["inertial"]["mass"]["values"]
    assert found[4:6] == [1.2172, 1.8789]
    assert raw["inertial"]["mass"]["values"][4] == 1.8789


@pytest.mark.slow
def test_the_printed_value_of_an_erratum_must_be_there():
    (mutant,) = (m for m in mutants("lwr4plus") if m.place == "rotors.inertia.values[0]" and m.kind == "sign")
    assert fate(mutant, usual_judgement("lwr4plus")).seen == changes.REFUSED


@pytest.mark.slow
@pytest.mark.parametrize(
    ("paper", "column", "untouched"),
    [
        ("wam7", "friction.positive_coulomb.values", ("mass", "torque", "flange", "tensor", "motor")),
        ("wam7", "transmission.ratio.values", ("mass", "torque", "flange", "cruise", "friction")),
        ("lwr4plus", "limits.effort.values", ("table_iv", "table_vi", "figure_1", "shell", "flange")),
    ],
)
def test_only_what_depends_on_a_number_turns(paper, column, untouched):
    usual = usual_judgement(paper)
    found = [fate(m, usual) for m in mutants(paper) if m.place.startswith(column) and m.kind == "times ten"]
    assert len(found) >= 7
    assert {f.seen for f in found} <= {changes.VERDICT, changes.REFUSED}
    turned = {path for f in found for path in f.turned}
    assert turned
    assert [path for path in turned if path.split(".")[1].startswith(untouched)] == []


def test_a_number_that_no_check_covers_is_listed():
    usual = usual_judgement("lwr4plus")
    idle = changes.Mutant("lwr4plus", "results", ("table_vii", "cells", "average", 0), "one percent", "4.6", "4.7")
    found = fate(idle, usual)
    assert (found.seen, found.missed, found.moved) == (changes.UNSEEN, False, 0.0)


def test_texts_that_are_numbers_are_cells_and_others_are_not():
    cells = dict(changes.numeric_cells({"a": ["1.5", "-", "cos(q1)", 2], "unit": "1", "on": True}))
    assert cells == {("a", 0): "1.5", ("a", 3): 2}
