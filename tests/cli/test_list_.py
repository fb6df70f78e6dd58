"""`lwr-dyn list`: a row a robot, or where the numbers of one come from."""

import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper, robots
from lwr_dyn.cli.list_ import command


def test_a_row_a_robot_and_what_to_type_next(printed):
    out = printed(command.name)
    lines = out.splitlines()
    assert lines[0].split("  ")[0] == "robot"
    assert [line.split()[0] for line in lines[2 : 2 + len(robots())]] == list(robots())
    assert any(line.startswith("lwr4plus") and "physical, printed, computed" in line for line in lines)
    assert lines[-1] == f"where its numbers come from: lwr-dyn list {robots()[0]}"


@pytest.mark.parametrize("robot", ["lwr4plus", "wam7"])
def test_one_robot_by_reading_and_column(robot, printed):
    paper = open_paper(robot)
    out = printed("list", robot)
    head, *lines = out.splitlines()
    assert head.startswith(f"{robot}: {paper.document['title']}")
    assert (f"({paper.document.get('origin')})" in head) == bool(paper.document.get("origin"))
    readings = [f"  {name}: {paper.readings[name].about}" for name in paper.reading_names]
    assert [line.partition("; leaves ")[0] for line in lines[: len(readings)]] == readings
    left = [" and ".join(lwr_dyn.load(robot, name).caveats.left_in_place) for name in paper.reading_names]
    assert [line.partition("; leaves ")[2].partition(" in place, ")[0] for line in lines[: len(readings)]] == left
    columns = [tuple(line.split(maxsplit=2)) for line in lines[len(readings) :]]
    assert [x[:2] for x in columns] == [(name, c.kind) for name, c in paper.columns.items()]


def test_the_record_has_every_erratum_and_column(recorded):
    (record,) = recorded("list", "lwr4plus")["robots"]
    paper = open_paper("lwr4plus")
    assert record in recorded("list")["robots"]
    assert list(record["readings"]) == ["physical", "printed", "computed"]
    assert (record["name"], record["joints"], record["default_reading"]) == ("lwr4plus", 7, paper.reading.name)
    assert record["errata"] == {
        e.id: {"where": e.where, "printed": e.printed, "read_as": e.read_as} for e in paper.errata
    }
    column = record["columns"]["inertial.inertia"]
    assert (column["unit"], column["where"]) == (sorted(set(paper.columns["inertial.inertia"].unit)), "Table I")
