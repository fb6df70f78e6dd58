"""Published sets: a reading takes a set's tables in place of the file's, with the errata of that set on top."""

import numpy as np
import pytest

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.foundation.errors import PaperError

SET = """
[[set]]
name = "maker"
about = "the maker's numbers"
where = "data sheet, page 3"
frames = "dh"
[set.inertial]
mass = { values = [3.0, 1.5], unit = "kg", where = "page 3", kind = "datasheet" }
com = { values = [[0, 0, 0.02], [0.01, 0, 0]], unit = "m", where = "page 3", kind = "datasheet" }
inertia = { values = [
    [[0.02, 0, 0], [0, 0.02, 0], [0, 0, 0.01]],
    [[0.03, 0, 0], [0, 0.03, 0], [0, 0, 0.01]],
], unit = "kg m^2", about = "origin", axes = "frame", products = "tensor", where = "page 3", kind = "datasheet" }

[[erratum]]
id = "mass-2"
set = "maker"
where = "page 3"
printed = "1.5"
read_as = "2.5"
why = "the total is printed too"
effect = "torques"
status = "proven"
severity = "model"
patch = [{ at = "inertial.mass.values[1]", printed = 1.5, read = 2.5 }]

[[erratum]]
id = "own-mass"
where = "Table 1"
printed = "2.0"
read_as = "4.0"
why = "as the sum says"
effect = "torques"
status = "proven"
severity = "model"
patch = [{ at = "inertial.mass.values[0]", printed = 2.0, read = 4.0 }]

[reading.printed]
about = "the file's own tables"
errata = ["own-mass"]

[reading.maker]
about = "the maker's set as printed"
set = "maker"

[reading.maker_mended]
about = "the maker's set, second mass mended"
set = "maker"
errata = ["mass-2"]
"""
OWN = template("own.toml", "own", "RR", "modified")


def read(reading):
    return parse_paper(OWN + SET, "own.toml", reading)


def test_a_reading_takes_the_tables_of_its_set_and_the_errata_on_top():
    masses = {name: read(name).columns["inertial.mass"].si().tolist() for name in read("printed").reading_names}
    assert masses == {"printed": [4.0, 2.0], "maker": [3.0, 1.5], "maker_mended": [3.0, 2.5]}
    assert read("maker").printed["inertial"]["mass"]["values"] == [3.0, 1.5]
    mended = read("maker_mended").columns["inertial.mass"]
    assert mended.errata == {1: ("mass-2",)}
    assert mended.where == "page 3"


def test_the_tensors_of_a_set_are_about_its_own_point():
    arm = arm_from_paper(read("maker"))
    shift = 3.0 * 0.02**2
    np.testing.assert_allclose(
        arm.chain.bodies[0].inertia_com, np.diag([0.02 - shift, 0.02 - shift, 0.01]), rtol=0, atol=1e-15
    )


def test_what_a_reading_leaves_in_place_is_of_the_tables_it_uses():
    paper = read("printed")
    assert {name: paper.left_in_place(name) for name in paper.reading_names} == {
        "printed": (), "maker": ("mass-2",), "maker_mended": (),
    }  # fmt: skip


FAULTS = {
    "two sets of one name": (SET[: SET.index("[[erratum]]")], SET[: SET.index("[[erratum]]")] * 2, "'maker' twice"),
    "frames not stated": ('frames = "dh"\n', "", r"set\[0\].frames: missing"),
    "frames of no kind": ('frames = "dh"', 'frames = "world"', r"set\[0\].frames: 'world'; allowed: one of dh"),
    "a set without tables": ("[set.inertial]", "[inertials]", r"set\[0\]: no table; allowed: one or more of base, dh"),
    "unknown table": ("[set.inertial]", "[set.inertials]", r"set\[0\].inertials: unknown field"),
    "a set that is not there": ('set = "maker"\nerrata', 'set = "made"\nerrata', "set: 'made'; allowed: one of maker"),
    "an erratum of another set": ('errata = ["own-mass"]', 'errata = ["mass-2"]', "errata: 'mass-2', of set maker"),
    "an erratum of a table that the set brings": (
        'errata = ["mass-2"]', 'errata = ["own-mass"]', "'own-mass', of the file's own inertial",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_a_breach_is_refused(name):
    old, new, message = FAULTS[name]
    assert old in SET, "the fault does not touch the text any more"
    with pytest.raises(PaperError, match=message):
        parse_paper(OWN + SET.replace(old, new, 1), "own.toml", "maker_mended")
