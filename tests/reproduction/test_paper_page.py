"""The outcome of a paper in counts, words and cells of its page: exact texts, of one short paper."""

from dataclasses import replace
from functools import cache

import pytest

from lwr_dyn.reproduction import paper_page
from lwr_dyn.reproduction.basis import with_bases
from lwr_dyn.reproduction.case import Proof, ledger
from lwr_dyn.reproduction.compare import DIFFERS, compare_numbers
from lwr_dyn.reproduction.own_paper import own_study
from lwr_dyn.reproduction.paper_page import summary_text, verdict_sentence
from lwr_dyn.reproduction.paper_study import paper_study
from lwr_dyn.reproduction.papers import printed_tables
from tests.reproduction.test_basis import found
from tests.reproduction.two_links import RESULTS, TEXT

KINDS = ("computed", "structural", "repeated in print")


@cache
def entries():
    study = paper_study("wam7")
    return ledger(study.data, study.proofs)


def number(path, paper="wam7", **changes):
    return replace(next(n for n in found(paper).numbers if n.cell.path == f"results.{path}"), **changes)


def test_the_counts_of_a_paper():
    counted = paper_page.counts(found("wam7"), entries())
    printed, derived = (
        {kind: tuple(counted[part][kind].values()) for kind in KINDS} for part in ("printed", "derived")
    )
    assert printed == {"computed": (29, 24, 5, 0), "structural": (1, 0, 1, 0), "repeated in print": (25, 21, 4, 0)}
    assert derived == {"computed": (156, 156, 0, 0), "structural": (3, 3, 0, 0), "repeated in print": (63, 63, 0, 0)}
    assert counted["printed"]["under assumed conditions"] == {"all": 10, "near": 10, "not near": 0}
    assert counted["errata"] == {
        "all": 10, "proven": 4, "proofs that hold": 4, "contradiction": 1, "model": 2, "result": 0, "text": 2,
    }  # fmt: skip
    rows = paper_page.count_table({"one": counted, "two": counted}).text().splitlines()[2:5]
    assert rows[0].split()[1:] == ["65", "29", "24", "5", "0", "1", "25", "10", "10", "0", "222", "156", "10", "4"]
    assert rows[2].split() == ["all", "130", "58", "48", "10", "0", "2", "50", "20", "20", "0", "444", "312", "20", "8"]
    assert len(paper_page.count_table({"one": counted}).rows) == 1


def test_the_outcome_in_words(own):
    assert " 108 more agree, but are structural or repeated in print." in dict(
        verdict_sentence(found("lwr4"), (), holds=True)
    )
    assert summary_text(found("wam7"), entries(), holds=True) == (
        "Of 65 printed numbers 29 are computed from other numbers: 24 are reproduced as printed, 5 after an erratum, "
        "0 differ. 1 is structural and 25 repeated in print: compared, not computed; 0 of them differ. "
        "10 are recomputed under assumed conditions (gains.kp, gains.kd not printed): 10 near, 0 not near "
        "(near: within the digits or axes printed, or 15% of the range printed in the row). "
        "Of 222 derived numbers 156 are computed. Of 10 errata 4 are proven. "
        "Of these 2 change the model, 0 a result, 2 are slips of the text. "
        "In 1 erratum two statements exclude each other; which one is wrong is not shown."
    )
    assert verdict_sentence(found("wam7"), entries(), holds=False) == (
        ("29 of 65", True),
        (" printed numbers come out: 24 as printed, 5 after an erratum.", False),
        (" 26 more agree, 5 of them after an erratum, but are structural or repeated in print.", False),
        (" For 10 the paper leaves out gains kp, gains kd: with assumed values 10 come near.", False),
        (" Something computed, checked or claimed is NOT explained.", True),
    )
    assert summary_text(own, (), holds=False) == (
        "Of 6 printed numbers 4 are computed from other numbers: 3 are reproduced as printed, 0 after an erratum, "
        "1 differs. 0 are structural and 1 repeated in print: compared, not computed; 0 of them differ. "
        "1 is recomputed under assumed conditions (the payload not printed): 0 near, 1 not near "
        "(near: within the digits or axes printed, or 15% of the range printed in the row). "
        "It is not explained why 1 is not near. Something computed, checked or claimed is NOT explained."
    )
    wrong = replace(found("wam7"), numbers=(number("motion.travel[0]", verdict=DIFFERS, value=0.502),))
    assert verdict_sentence(wrong, (), holds=True)[-1] == (" 1 differ.", True)
    assert paper_page.difference_table(wrong).text().splitlines()[-1].split() == [
        "motion.travel[0]",
        "0.5",
        "0.502",
        "+0.002",
        "+0.02",
    ]


@pytest.mark.parametrize(
    ("path", "note"),
    [
        ("motion.travel[0]", ""),
        ("caption_4.ddq_c[0]", "can be read within 0.0825 to 0.0835"),
        (
            "figure_4.position[0]",
            "after erratum; compared, not computed: printed elsewhere too, or fitted to; can be read within -0.6 to 0",
        ),
        (
            "figure_7.joint_1[0]",
            "not printed: gains.kp, gains.kd; ours is under assumed ones; near: within the digits or axes printed, or "
            "15% of the range printed in the row; ours less printed: +0 rad, +0 last digits; can be read within 0 to "
            "6e-3",
        ),
        ("mass_revised.mass[0]", "under the reading revised_wrist"),
    ],
)
def test_what_a_cell_says(path, note):
    one = number(path)
    cell = paper_page._cell(one)
    assert cell.note == note
    assert (cell.printed, cell.verdict, cell.errata) == (one.cell.printed, one.outcome, one.errata)
    assert cell.source == f"{one.block.where} (results.{path})"
    assert cell.conversion == f"in {one.cell.unit}, as printed; by {one.block.compute}"


@pytest.mark.parametrize(
    ("printed", "value", "text"),
    [
        ("0.5", 0.5, "0.500"),
        ("3", 3.0000000001, "3"),
        ("3", 3.25, "3.25"),
        ("-0.01", -1e-9, "0.0000"),
        ("6e-3", 0.0061234567, "0.00612346"),
        ("12", 2.5e9 + 0.5, "2.5e+09"),
        ("1", None, ""),
    ],
)
def test_ours_has_two_digits_more_than_the_printed_number(printed, value, text):
    one = number("motion.travel[0]")
    assert paper_page._ours(replace(one, cell=replace(one.cell, printed=printed), value=value)) == text


def test_tables_are_the_blocks_and_matrices_have_their_names_in_the_rows():
    (motion,) = paper_page._tables([n for n in found("wam7").numbers if n.block.name == "motion"])
    assert (motion.id, motion.title, motion.columns, motion.unit) == (
        "motion", "section 4", ("travel", "velocity"), "rad, rad/s",
    )  # fmt: skip
    assert motion.where == "a rotation of 0.5 rad at a velocity of 0.083 rads/sec'; Figures 4 and 7 for its times"
    entry = number("matrices.A3[2][3]", "lwr4")
    assert paper_page._place(entry) == ("A3: 3", "4")
    assert printed_tables("lwr4")["matrices"]["A3"][2][3] == paper_page._cell(entry).printed
    (tool,) = paper_page._tables([n for n in found("lwr4").numbers if n.block.name == "tool"])
    assert tool.title == "derived: tool point P_d in frame 0"


def test_files_beside_a_page_are_listed_with_their_hashes(tmp_path):
    for name in ("b.png", "report.html", "sub/a.npz"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("")
    empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"
    assert [(f.name, f.size, f.sha256, f.what) for f in paper_page._files(tmp_path)] == [
        ("b.png", 0, empty, "plot"), ("sub/a.npz", 0, empty, "run"),
    ]  # fmt: skip


@pytest.fixture
def own(tmp_path):
    """Numbers of a user's own paper: one differs, one is under assumed conditions, one is a cell of the tables."""
    results = RESULTS.replace("0.930", "0.950").replace('printed = "38"', 'assumed = ["the payload"]\nprinted = "41"')
    more = (
        '[[result]]\nid = "mass"\nwhere = "Table IV, m1"\nprinted = "2.0"\nunit = "kg"\ncompute = "inertial.mass[1]"\n'
    )
    (tmp_path / "two.toml").write_text(TEXT + results + more, encoding="utf-8")
    study = own_study(tmp_path / "two.toml")
    return with_bases(study, compare_numbers(study))


def test_the_table_of_an_own_paper(own):
    table = paper_page.number_table(own, ())
    assert [row[0] for row in table.rows] == ["b11", "holding[1]", "holding[2]", "share", "reach", "mass"]
    assert [row[4] for row in table.rows] == [
        "differs by -0.02, -20 last digits", "reproduced", "reproduced", "not near, assumed: the payload", "reproduced",
        "reproduced, repeated in print",
    ]  # fmt: skip
    assert table.rows[0][1:4] == ("0.950", "0.93000", "kg m^2")
    unproven = replace(entries()[0], proof=Proof("nothing shows it", False))
    assert f"erratum {unproven.erratum.id}: nothing shows it" in paper_page.number_table(own, (unproven,)).text()


def test_results_of_one_place_share_its_table(own):
    tables = {table.title: table for table in paper_page._tables(own.numbers)}
    assert list(tables) == ["Table IV", "section 3", "conclusion"]
    assert [row.label for row in tables["Table IV"].rows] == ["b11", "mass"]
    assert [row.label for row in tables["section 3"].rows] == ["holding[1]", "holding[2]"]
    assert tables["Table IV"].unit == "kg m^2, kg"
    assert len({table.id for table in tables.values()}) == 3
