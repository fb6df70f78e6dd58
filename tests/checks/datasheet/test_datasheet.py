"""The data sheet as a check: no length 1 cm off, no angle 90 deg off, no sign turned gets past it."""

import json
import re
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest
from click.testing import CliRunner

import lwr_dyn
from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.checks.datasheet.datasheet import datasheet_verdicts, zero_readings, zero_text
from lwr_dyn.cli.check import command
from lwr_dyn.foundation.errors import MissingDataError, PaperError
from lwr_dyn.kinematics.forward import joint_axes

TEXT = resources.files("lwr_dyn.arms.papers").joinpath("kr30ha.toml").read_text(encoding="utf-8")
MUTATED = {
    "alpha": (90, -90), "a": (10, -10), "d": (10, -10), "theta_offset": (90, -90, 180),
    "lower": (90, -90), "upper": (90, -90), "mastering": (90, -90),
}  # fmt: skip
CASES = [(column, i, by) for column, steps in MUTATED.items() for i in range(6) for by in steps]


def row_of(column):
    """The text of a column's values and what is in it."""
    result = re.search(rf"^{column} = {{{{? values = \[([^]]*)\]", TEXT, re.M)
    return result.group(0), [float(x) for x in result.group(1).split(",")]


def verdicts_of(text):
    paper = parse_paper(text, "kr30ha.toml")
    return datasheet_verdicts(arm_from_paper(paper), paper)


def verdicts_with(column, values):
    """Verdicts of the data file with another row; the errata then find what they expect as they did."""
    old, _ = row_of(column)
    text = TEXT.replace(old, old[: old.index("[")] + str(values), 1)
    for i, cell in enumerate(values if column == "theta_offset" else ()):
        text = re.sub(rf'(at = "dh.theta_offset.values\[{i}\]", printed = )\S+,', rf"\g<1>{cell},", text)
    return verdicts_of(text)


def test_the_data_file_as_it_is_holds_and_papers_without_a_data_sheet_have_no_such_check():
    assert [v.holds for v in datasheet_verdicts(lwr_dyn.load("kr30ha"), open_paper("kr30ha"))] == [True] * 12
    assert datasheet_verdicts(lwr_dyn.load("lwr4plus"), open_paper("lwr4plus")) == []


@pytest.mark.slow
@pytest.mark.parametrize(("column", "i", "by"), CASES)
def test_one_number_off_is_detected(column, i, by):
    _, values = row_of(column)
    values[i] += by
    low, up = ([*row_of(side)[1]] for side in ("lower", "upper"))
    if (values[i] >= up[i]) if column == "lower" else (column == "upper" and values[i] <= low[i]):
        with pytest.raises(PaperError, match="below the upper"):
            verdicts_with(column, values)
        return
    # the erratum overwrites this cell whatever was printed; the reading is the same arm
    patched = column == "theta_offset" and i in (1, 2, 5)
    assert all(v.holds for v in verdicts_with(column, values)) == patched


def misread(i, by):
    """An erratum that reads an offset wrong."""
    at, read = (("values[1]", 0), ("values[2]", 90), ("values[5]", 180))[i]
    old = re.search(rf'at = "dh.theta_offset.{re.escape(at)}", printed = \d+, read = {read} ', TEXT).group(0)
    return TEXT.replace(old, old.replace(f"read = {read}", f"read = {read + by}"))


def turned(i):
    """An axis counted the other way."""
    signs = [1 if k == i else -1 for k in range(6)]
    return TEXT.replace("read = [-1, -1, -1, -1, -1, -1]", f"read = {signs}")


WRONG = {f"offset {i} {by:+}": misread(i, by) for i in range(3) for by in (90, -90)}
WRONG |= {f"axis {i + 1} counted the other way": turned(i) for i in range(6)}


@pytest.mark.parametrize("case", WRONG)
def test_an_erratum_that_reads_an_offset_or_a_sign_wrong_is_detected(case):
    assert WRONG[case] != TEXT
    assert any(not v.holds for v in verdicts_of(WRONG[case]))


def test_table_2_as_printed_is_another_arm():
    verdicts = datasheet_verdicts(lwr_dyn.load("kr30ha", "printed"), open_paper("kr30ha", "printed"))
    assert {v.name for v in verdicts if not v.holds} >= {
        "flange at zero against the print", "envelope volume ahead of axis 1 (r >= 0) against the data sheet"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("given", "name"), [("reach", "reach against the data sheet"), ("envelope_volume", "envelope volume")]
)
def test_a_sheet_with_one_of_reach_and_volume_has_its_check(given, name):
    arm, paper = lwr_dyn.load("kr30ha"), open_paper("kr30ha")
    other = {"reach", "envelope_volume"} - {given}
    part = replace(arm, ratings=replace(arm.ratings, **dict.fromkeys(other)))
    found = [v for v in datasheet_verdicts(part, paper) if v.name.startswith(("reach", "envelope"))]
    assert [(v.name.startswith(name), v.holds) for v in found] == [(True, True)]


def test_the_reading_of_zero_and_signs_is_said():
    """2^1 conventions times (2 signs, 4 quarter turns)^6; the best changes three offsets."""
    found = zero_readings(open_paper("kr30ha", "printed"))
    best = found.best[0]
    assert (best.record(), best.changes) == (
        {"convention": "standard", "signs": [-1] * 6, "offsets_deg": [0, 0, 90, 0, 0, 180], "failed": 0}, 3
    )  # fmt: skip
    checks = "axes at zero against the maker's, flange at zero against the print, flange at zero: rotation against "
    checks += "the maker's, flange at mastering: rotation against the maker's, wrist centre at mastering against the "
    checks += "print, envelope volume ahead of axis 1 (r >= 0) against the data sheet"
    assert zero_text(found) == [
        "zero and signs: of 524288 ways (DH convention, sign and quarter-turn offset of every joint) "
        "256 have the maker's axes at zero",
        f"as printed, standard DH: 5 of 11 checks hold; not: {checks}",
        "standard DH: 256 with these axes; the best: 11 of 11 checks hold",
        "modified DH: 0 with these axes",
        "reading: standard DH, signs (-1, -1, -1, -1, -1, -1), offsets (0, 0, 90, 0, 0, 180) deg: 11 of 11 checks hold",
        "decided by the poses: every other reading breaks a check; 1 more move the flange the same in every pose, "
        "frames turned inside",
    ]
    ranks = [(r.failed, r.changes) for r in found.readings]
    assert ranks == sorted(ranks)
    axes = open_paper("kr30ha").columns["poses.axis"].si()
    assert all(np.abs(joint_axes(r.chain, np.zeros(6)).z - axes).max() < 1e-9 for r in found.readings)
    undecided = replace(found, readings=(best, replace(found.readings[5], verdicts=best.verdicts)))
    assert zero_text(undecided)[-1].startswith("UNDECIDED: 1 other readings hold as well and move otherwise")
    with pytest.raises(MissingDataError, match="axes of the joints at zero"):
        zero_readings(open_paper("lwr4plus"))


@pytest.mark.slow
def test_the_check_command_holds_and_the_printed_table_fails():
    done = CliRunner().invoke(command, ["kr30ha", "--json"])
    assert done.exit_code == 0
    record = json.loads(done.stdout)
    assert "envelope volume ahead of axis 1 (r >= 0) against the data sheet" in [v["name"] for v in record["verdicts"]]
    assert record["notes"] == ["no rotor inertia is given"]
    assert CliRunner().invoke(command, ["kr30ha", "--reading", "printed"]).exit_code == 1
