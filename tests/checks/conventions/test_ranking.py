"""The readings of the papers, found from printed cells alone; the errata of the data files are what to compare with."""

import dataclasses

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.checks.conventions.evidence import DerivedNumber, Evidence, evidence_number, packaged_evidence
from lwr_dyn.checks.conventions.hypotheses import table_hypotheses
from lwr_dyn.checks.conventions.printed_table import printed_table
from lwr_dyn.checks.conventions.ranking import decisions, equally_plain, rank_readings
from lwr_dyn.checks.conventions.ranking_text import global_maxima, lattice_warning, off_lattice, ranking_text
from lwr_dyn.checks.datasheet.datasheet import same_motion, zero_readings
from lwr_dyn.model.chain import Convention
from lwr_dyn.reproduction.papers import printed_tables


@pytest.fixture(scope="module")
def lwr():
    table = printed_table(open_paper("lwr4plus"))
    printed = printed_tables("lwr4plus")["table_iv"]["b"]
    numbers = tuple(DerivedNumber("worst inertia", i, evidence_number(b)) for i, b in enumerate(printed))
    return rank_readings(table, Evidence(numbers))


@pytest.fixture(scope="module")
def wam():
    table = printed_table(open_paper("wam7"))
    return rank_readings(table, packaged_evidence("wam7", table))


INVISIBLE = 1e-6
"""[kg m^2] Link 6's one product is 3.6e-7: nothing shows its sign; the errata keep it, the rule turns it."""


def assert_bodies(found, reading, atol=1e-15):
    for ours, link in zip(found.bodies, reading.chain.links, strict=True):
        assert ours.mass == link.body.mass
        np.testing.assert_allclose(ours.com, link.body.com, atol=1e-15)
        np.testing.assert_allclose(ours.inertia_com, link.body.inertia_com, atol=atol)


def test_lwr_table_2_is_one_row_too_high(lwr):
    assert [(f.convention.value, f.shift) for f in lwr.frames if not f.missed] == [("standard", 1)]
    np.testing.assert_array_equal(lwr.table.com[6], [0, 0, -0.01476472])


@pytest.mark.slow
def test_lwr_computed_is_found_from_table_4(lwr):
    assert_bodies(lwr.computed[0], lwr_dyn.load("lwr4plus", "computed"))
    assert all(row.holds for row in global_maxima(lwr.table, lwr.evidence, lwr.computed[0]))


@pytest.mark.slow
def test_lwr_c5z_is_fitted_to_b55_and_the_others_follow(lwr):
    first, *others = equally_plain(lwr.corrections)
    assert (first.cell.name, first.cell.value, first.fitted_to) == ("c5z", -0.0238, "b55")
    assert first.low < -0.0238 < first.high
    assert first.repeats == "c6z"
    assert first.followed == 4
    assert [r.cell.value for r in others] == [0.0238]


@pytest.mark.slow
def test_lwr_c5z_is_not_the_only_cell_that_mends_table_4(lwr):
    """Link 6 could be heavier across its axis: the numbers alone do not decide it, the copied neighbour does."""
    equal = {r.cell.name for r in lwr.corrections if r.exceptions == lwr.corrections[0].exceptions}
    assert equal == {"c5z", "I6xx", "c6y"}
    for r in lwr.corrections:
        if r.cell.name == "I6xx":
            changed = lwr.table.with_cell("inertia", 5, 0, r.cell.value)
            again = rank_readings(changed, lwr.evidence)
            assert not again.corrections
            assert all(row.holds for row in global_maxima(changed, lwr.evidence, again.computed[0]))
            break


@pytest.mark.slow
def test_another_wrong_cell_is_found_too(lwr):
    """With c5z corrected and c4z changed: it is found again, within the range fitted."""
    whole = lwr.table.with_cell("com", 4, 2, -0.0238)
    right = float(whole.com[3, 2])
    found = rank_readings(whole.with_cell("com", 3, 2, 0.4 * right), lwr.evidence)
    mended = [r for r in found.corrections if r.cell.name == "c4z" and r.low <= right <= r.high]
    assert mended, [(r.cell.name, r.low, r.high) for r in found.corrections]
    assert mended[0].fitted_to == "b44"


@pytest.mark.slow
def test_lwr_signs_do_not_show_in_table_4(lwr):
    made = {(d.question, d.link): d for d in decisions(lwr, lwr.computed, ("published numbers",))}
    for link in range(6):
        assert made["products", link].others == ("integral",)
        assert made["products", link].by == ()
    assert made["products", 6].answer == "no difference"
    assert made["about", None].decided
    assert made["about", None].by == ("published numbers",)


@pytest.mark.slow
def test_lwr_physical_is_found_from_bodies_and_mirror_images(lwr):
    """The reading `physical` less its rotors, which are no part of the table."""
    assert not lwr.agree
    assert_bodies(lwr.best, lwr_dyn.load("lwr4plus", "physical"), INVISIBLE)
    assert lwr.best.mirror_miss < 0.003
    assert min(c.mirror_miss for c in lwr.both) > 0.01


@pytest.mark.slow
def test_lwr_physical_stands_without_table_4(lwr):
    """About the origin with y and z exchanged and signs bound by repeated links: Table IV mends only c5z."""
    found = rank_readings(printed_table(open_paper("lwr4plus")), Evidence())
    choice = found.best.reading
    assert choice.table.about == "origin"
    assert [x.axes for x in choice.links[:4]] == ["xyz", "xzy", "xyz", "xzy"]
    assert [x.products == choice.links[0].products for x in choice.links[1:4]] == [False, False, False]


def test_wam_products_are_integrals_by_the_second_tensors(wam):
    assert_bodies(wam.best, lwr_dyn.load("wam7", "manual"))
    made = {(d.question, d.link): d for d in decisions(wam, wam.physical, ("feasibility", "second tensors"))}
    for link in (0, 2, 5):
        assert (made["products", link].answer, made["products", link].by) == ("integral", ("second tensors",))
    for link in (1, 3, 4, 6):
        assert made["products", link].others == ("tensor",)
        assert made["products", link].by == ("fewest exceptions",)
    assert made["about", None].by == ("feasibility", "second tensors")


def test_wam_sign_is_undecided_without_the_second_tensors(wam):
    found = rank_readings(printed_table(open_paper("wam7")), Evidence(convention="standard"))
    made = {(d.question, d.link): d for d in decisions(found, found.physical, ("feasibility",))}
    assert all(made["products", i].others for i in range(7))
    assert made["about", None].decided


def test_wam_origin_reading_is_no_body_on_four_links(wam):
    origin = next(w for w in wam.as_printed if (w.choice.about, w.choice.com_from) == ("origin", "own frame"))
    assert [i + 1 for i, left in enumerate(origin.feasible) if not left] == [1, 3, 4, 6]


def test_a_flipped_second_tensor_flips_the_sign(wam):
    table = printed_table(open_paper("wam7"))
    tensors = packaged_evidence("wam7", table).tensors
    turned = dataclasses.replace(table, inertia=np.where(np.eye(3, dtype=bool), table.inertia, -table.inertia))
    found = rank_readings(turned, Evidence(tensors=tensors, convention="standard"))
    assert {x.products for x in found.best.reading.links} == {"tensor"}


@pytest.mark.slow
def test_kr30_zero_and_signs_are_found_from_the_data_sheet():
    found = zero_readings(open_paper("kr30ha"))
    best, arm = found.best[0], lwr_dyn.load("kr30ha", "kuka")
    assert best.convention.value == "standard"
    assert best.signs == (-1,) * 6
    assert best.offsets_deg == (0.0, 0.0, 90.0, 0.0, 0.0, 180.0)
    assert best.failed == 0 < found.printed.failed
    for ours, link in zip(best.chain.links, arm.chain.links, strict=True):
        np.testing.assert_allclose(ours.after.matrix(), link.after.matrix(), atol=1e-15)
    rivals = [r for r in found.readings if r.failed == 0]
    assert all(same_motion(best, r) for r in rivals)
    assert not same_motion(best, found.printed)


@pytest.mark.slow
def test_largest_inertias_between_quarter_turns_are_named(lwr):
    """LWR links stand square: no B_ii is larger off the lattice; a tilted link's is, and the text warns of it."""
    assert off_lattice(lwr.evidence, lwr.as_printed[0]) == ()
    assert lattice_warning(lwr) == []
    tilted = lwr.table.with_cell("com", 2, 0, 0.1).with_cell("com", 3, 0, -0.15)
    plainest = table_hypotheses(tilted, lwr.evidence, [Convention.STANDARD])[0]
    missed = dict(off_lattice(lwr.evidence, plainest))
    assert missed.keys() >= {"b22"}
    assert missed["b22"] > 0.001


def test_the_text_names_what_is_undecided(lwr, wam):
    text = "\n".join(ranking_text(lwr))
    assert "the sign of c5z is undecided" in text
    assert "m c^2 is counted twice" in text
    assert "what the authors computed with" in text
    assert text.count("global search over the joint box [kg m^2], printed in brackets: ") == 1
    assert "link 1, 2, 3, 4, 5, 6: products of inertia tensor entries (UNDECIDED" in text
    assert "link 2, 4, 5, 7: products of inertia +integral (UNDECIDED" in "\n".join(ranking_text(wam))
