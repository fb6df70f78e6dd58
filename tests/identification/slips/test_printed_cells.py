"""The cells of a table: what they stand for, what motions show of them, how far an arm may be; their slips undone."""

import re
from collections import Counter
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.identification.slips.hypotheses import as_printed, log_evidence
from lwr_dyn.identification.slips.printed_cells import MASS, Cell, link_discrepancies, printed_cells
from lwr_dyn.identification.slips.repairs import exchanges, of_cells, of_columns, possible, repeats
from lwr_dyn.model.spatial import from_rpy
from tests.identification.slip_study import single_faults

READINGS = [("lwr4plus", "printed"), ("lwr4plus", "physical"), ("wam7", None), ("kr30ha", None)]


@pytest.fixture(scope="module")
def physical():
    return printed_cells(open_paper("lwr4plus", "physical"))


@pytest.mark.parametrize(("robot", "reading"), READINGS)
def test_the_cells_stand_for_the_parameters_of_the_arm(robot, reading):
    paper, arm = open_paper(robot, reading), lwr_dyn.load(robot, reading)
    for source in (paper, arm):
        table = printed_cells(source)
        for i, link in enumerate(arm.chain.links):
            assert link.body is not None
            own = body_parameters(link.body)
            known = ~table.open_parameters[i, :10]
            got = table.parameters()[10 * i : 10 * i + 10]
            np.testing.assert_allclose(got[known], own[known], rtol=1e-12, atol=1e-12 * abs(own).max())
            if link.rotor is not None:
                np.testing.assert_allclose(table.parameters()[10 * arm.n + i], link.rotor.armature, rtol=1e-12)


def test_the_derivative_is_exact():
    table = printed_cells(open_paper("lwr4plus", "printed"))  # about the centres of mass: squares of the cells
    D = table.derivatives(table.cells)
    for k in (1, 3, 30, 58, 76):
        cell, step = table.cells[k], 1e-7
        up, down = (table.with_cell(cell, table.value(cell) + s).parameters() for s in (step, -step))
        np.testing.assert_allclose(D[:, k], (up - down) / (2 * step), atol=1e-7)


HIDDEN = ["m1", "c1x", "c1y", "c1z", "I1xx", "I1xy", "I1xz", "I1yz", "I1zz", "c2y"]
PAIRS = [["I1yy", "rotor1"], ["m2", "c2z"], ["I2yy", "rotor2"], ["c3z", "c4y"], ["c5z", "c6y"]]


def test_the_discrepancy_of_a_link_moves_its_centre_alike_in_all_directions(physical):
    """By 5 cm times the share and more, also where the link is thin; masses and rotors by the share."""
    table, off = physical, 0.04
    spread = link_discrepancies(table, off, range(table.n))
    mass, rotors = table.values[:, 0], table.parameters()[70:]
    for one in spread:
        assert np.linalg.eigvalsh(one)[0] > -1e-12
    # the part of the first moment that is not the mass's: of a centre that moves
    moved = spread[:, 1:4, 1:4] - np.einsum("na,nb,n->nab", spread[:, 0, 1:4], spread[:, 0, 1:4], 1 / spread[:, 0, 0])
    assert (np.linalg.eigvalsh(moved) >= (0.05 * off * mass[:, None]) ** 2 * (1.0 - 1e-9)).all()
    assert (np.sqrt(spread[:, 0, 0]) >= off * mass).all()
    np.testing.assert_allclose(np.sqrt(spread[:, 10, 10]), off * np.abs(rotors))


def test_some_links_have_the_discrepancies_that_they_have_among_all(physical):
    table = physical
    every = link_discrepancies(table, 0.05, range(table.n))
    np.testing.assert_array_equal(link_discrepancies(table, 0.05, [4, 1]), every[[4, 1]])
    massless = table.with_values(np.where(np.arange(7)[:, None] == 2, 0.0, table.values))
    assert not link_discrepancies(massless, 0.05, [2]).any()
    slipped = table.with_cell(Cell(3, 9), -0.5)  # no body has it
    assert np.isfinite(link_discrepancies(slipped, 0.05, [3])).all()


def test_ten_cells_show_in_no_motion_and_ten_only_as_pairs(study):
    assert [c.name for c in study.shown.hidden] == HIDDEN
    assert [[c.name for c in group] for group in study.shown.together] == PAIRS
    assert len(study.shown.alone) == 57
    assert study.shown.like(Cell(4, 3)) == (Cell(4, 3), Cell(5, 2))


@pytest.fixture(scope="module")
def full(physical):
    """A table whose cells are all known and differ."""
    values = np.random.default_rng(0).permutation(np.arange(1.0, 78.0)).reshape(7, 11) / 10.0
    return replace(physical, values=values, known=np.ones_like(physical.known))


def test_exchanges_are_all_pairs_that_hands_confuse(full):
    """Of a link 3 pairs each of its centre, diagonal and products, 6 of axes, 6 quarter turns of its centre; every cell
    with those of the next two links; bodies, centres and tensors of neighbours; every column one row up and down."""
    found = {repair.text: repair for repair in exchanges(full)}
    kinds = {"exchange": 7 * (3 + 3 + 3 + 6) + 11 * (6 + 5), "axes": 7 * 6, "rows": 6 * 3 + 4 * 2}
    assert Counter(repair.kind for repair in found.values()) == kinds
    for repair in found.values():
        moved = {Cell(*at) for at in np.argwhere(repair.table.values != full.values).tolist()}
        assert moved == set(repair.cells)
        np.testing.assert_array_equal(np.sort(np.abs(repair.table.values), axis=None), np.sort(full.values, axis=None))

    def row(text, link):
        return found[text].table.values[link]

    m, c, tensor, rotor = full.values[1, 0], full.values[1, 1:4], full.values[1, 4:10], full.values[1, 10]
    T = np.zeros((3, 3))
    T[np.triu_indices(3)] = tensor
    yx = np.eye(3)[[1, 0, 2]]
    turned = (yx @ (T + T.T - np.diag(np.diag(T))) @ yx)[np.triu_indices(3)]
    assert row("axes x and y of the tensor of link 2 exchanged", 1).tolist() == [m, *c, *turned, rotor]
    assert row("axes x and y of link 2 exchanged", 1).tolist() == [m, *(yx @ c), *turned, rotor]
    for k, axis in enumerate("xyz"):
        for sign in (1, -1):
            R = from_rpy(sign * np.pi / 2 * np.eye(3)[k]).round()
            assert row(f"com of link 2 turned by {90 * sign:+d} deg about {axis}", 1)[1:4].tolist() == (R @ c).tolist()
    lower = found["com: every row belongs one lower"].table.values
    np.testing.assert_array_equal(lower[:, 1:4], np.roll(full.values[:, 1:4], 1, axis=0))
    assert row("row of links 2 and 3 exchanged", 2).tolist() == [*full.values[1, :10], full.values[2, 10]]


def test_cells_and_columns_are_slipped_by_signs_points_and_units(full):
    cells, ratio = Counter(), np.sqrt(full.rotor_factor)
    for repair in of_cells(full):
        (cell,) = repair.cells
        factor = repair.table.values[cell] / full.values[cell]
        cells[repair.kind, round(factor, 9) if repair.kind != "gear ratio" else 0] += 1
        shown = full.shown(cell, repair.table.value(cell))
        assert repair.text == f"{cell.name} = {shown}, printed {full.shown(cell)}"
        if repair.kind == "gear ratio":
            assert np.abs(np.log(factor) / np.log(ratio[cell.link])).round(9) in (1.0, 2.0)
    powers = {10.0: "power of ten", 100.0: "two powers of ten", 1000.0: "unit"}
    wanted = {(kind, f): 77 for factor, kind in powers.items() for f in (factor, 1.0 / factor)}
    assert cells == {("sign", -1.0): 7 * 9, **wanted, ("gear ratio", 0): 4 * np.count_nonzero(ratio != 1.0)}
    texts = [repair.text for repair in of_columns(full)]
    assert len(set(texts)) == len(texts) == 2 + 6 + 12 + 10 + 1 + 2 * 8 + 7
    for repair in of_columns(full):
        if repair.kind == "column":  # units are confused both ways
            column, factor = re.fullmatch(r"(\w+) of all links times (\S+)", repair.text).groups()
            assert f"{column} of all links times {1.0 / float(factor):g}" in texts
            assert {cell.column for cell in repair.cells} == {column}
            for cell in full.cells:
                changed = repair.table.value(cell) / full.value(cell)
                assert changed == pytest.approx(float(factor) if cell.column == column else 1.0)


@pytest.mark.parametrize(("about_origin", "point"), [(True, "centre of mass"), (False, "link's origin")])
def test_conventions_are_turned_of_all_links_and_of_each(full, about_origin, point):
    table = replace(full, about_origin=np.full(7, about_origin))
    found = {repair.text: repair for repair in of_columns(table)}
    for i, whose in enumerate(["all links", *(f"link {i}" for i in range(1, 8))]):
        links = np.arange(7) == i - 1 if i else np.ones(7, dtype=bool)
        for text, kind, quantities, flag in (
            (f"com of {whose} times -1", "sign", (1, 2, 3), None),
            (f"products of inertia of {whose} of the other sign", "sign", (5, 6, 8), "integral"),
            (f"tensor of {whose} about the {point}", "rows", range(4, 10), "about_origin"),
        ):
            repair, values = found[text], table.values.copy()
            assert repair.kind == (kind if i or flag is None else "convention")
            assert repair.cells == tuple(Cell(*at) for at in product(np.flatnonzero(links).tolist(), quantities))
            for name in ("integral", "about_origin"):
                assert (getattr(repair.table, name) != getattr(table, name)).tolist() == (
                    links & (name == flag)
                ).tolist()
            values[links, 1:4] *= -1.0 if flag is None else 1.0
            np.testing.assert_array_equal(repair.table.values, values)


def test_a_mass_rotor_or_moment_that_becomes_negative_and_was_not_is_impossible(full):
    for quantity in range(11):
        below, none = (full.with_cell(Cell(2, quantity), value) for value in (-0.1, 0.0))
        signed = quantity in (1, 2, 3, 5, 6, 8)  # a centre, a product
        verdicts = [possible(*pair) for pair in ((below, full), (below, none), (none, full), (below, below))]
        assert verdicts == [signed, signed, True, True]


@pytest.mark.parametrize("reading", ["printed", "physical"])
def test_a_repair_done_again_on_what_it_made_is_said_and_changes_something(reading):
    table = printed_cells(open_paper("lwr4plus", reading))
    for repair in exchanges(table):
        assert repair.cells
        if "exchanged" in repair.text:
            np.testing.assert_array_equal(repair.again(repair.table).table.values, table.values)
    for repair in (*of_cells(table), *of_columns(table)):
        again = repair.again(table)
        assert again.text == repair.text
        np.testing.assert_array_equal(again.table.parameters(), repair.table.parameters())
    assert all((repair.table.parameters() != table.parameters()).any() for repair in of_cells(table))


def test_a_number_repeats_that_of_the_row_before_or_behind_it(full):
    values = full.values.copy()
    values[:, MASS] = [3.0, 2.0, -2.0 * (1.0 + 9e-7), 1.0, 0.0, 0.0, 1.0]
    table = full.with_values(values)
    found = [repeats(table, Cell(i, MASS)) for i in range(7)]
    assert found == [None, Cell(2, MASS), Cell(1, MASS), None, None, None, None]
    assert repeats(table.with_cell(Cell(2, MASS), 2.0 * (1.0 + 2e-6)), Cell(1, MASS)) is None


def test_chi2_is_that_of_the_log_with_friction_at_its_best(study):
    information = study.log(0.0, np.random.default_rng(3))
    fault = single_faults(study.table)[40]
    evidence = log_evidence(information, fault.table, 0.0)
    columns, base, R = information.columns, information.base, information.factor
    own = [*range(70), *columns.rotor_indices]
    others = np.setdiff1d(np.arange(columns.count), own)
    away = R @ (base.grouping[:, own] @ fault.table.parameters() - information.values)
    friction = np.linalg.lstsq(R @ base.grouping[:, others], -away, rcond=None)[0]
    left = away + R @ base.grouping[:, others] @ friction
    assert as_printed(evidence, fault.table).chi2 == pytest.approx(left @ left, rel=1e-7)
    assert evidence.directions == 48  # bodies with rotors: 69 with viscous, Coulomb and offset
