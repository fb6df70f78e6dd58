"""Every column names its place; no two papers share a column by accident."""

import itertools

from lwr_dyn.arms.papers.catalog import open_paper, studied
from lwr_dyn.arms.papers.schema import KINDS

SHARED = {("lwr4", "lwr4plus"): {"dh.alpha", "dh.a", "drawing.pedestal"}}
"""One arm in two documents: the twist angles of the exercise serve the paper, which prints none."""


def test_every_column_has_a_page_and_a_kind():
    for robot in studied():
        for name, column in open_paper(robot).columns.items():
            assert len(column.where) > 3, f"{robot} {name}"
            assert column.kind in KINDS


def test_no_two_papers_share_a_column_by_accident():
    for a, b in itertools.combinations(studied(), 2):
        first, second = open_paper(a).columns, open_paper(b).columns
        same = {name for name in first.keys() & second.keys() if first[name].values == second[name].values}
        constant = {name for name in same if len(set(first[name].values)) == 1 and name != "dh.a"}
        assert same - constant <= SHARED.get((a, b), set())


def test_every_erratum_is_used_by_a_reading_and_every_reading_loads():
    for robot in studied():
        paper = open_paper(robot)
        used = {erratum for reading in paper.readings.values() for erratum in reading.errata}
        assert used == {e.id for e in paper.errata if e.of_tables()}
        for reading in paper.readings:
            assert open_paper(robot, reading).reading.name == reading
