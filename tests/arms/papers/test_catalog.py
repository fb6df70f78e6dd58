"""Robots by name: a command parses a robot's data file once, and the template of a new arm is a valid file."""

import re
import tomllib
from copy import deepcopy
from importlib.util import find_spec

import pytest

from lwr_dyn.arms.papers import catalog, reader
from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper, published, readings, robots, studied, template
from lwr_dyn.arms.papers.reader import apply_errata, parse_paper
from lwr_dyn.foundation.errors import OptionError, UnknownNameError

Q = "--q=0,0,0,0,0,0,0"
HOLD = "simulate lwr4plus --task hold --from-deg 0,0,0,0,0,0,0 --duration 0.01"
COMMANDS = ["check lwr4plus", f"fk lwr4plus {Q}", "urdf lwr4plus", "urdf lwr4plus --out out.urdf", HOLD]
COMMANDS += ["fk lwr4plus --symbolic"] * bool(find_spec("sympy"))


@pytest.fixture
def parsed(monkeypatch):
    """The names of the data files that are parsed, in order."""
    names, loads = [], tomllib.loads

    def counted(text, **options):
        tables = loads(text, **options)
        names.append(tables["name"])
        return tables

    monkeypatch.setattr(tomllib, "loads", counted)
    for cached in (reader.parse_paper, reader.parse_readings):
        cached.cache_clear()
    return names


@pytest.mark.parametrize("command", ["list", *(pytest.param(x, marks=pytest.mark.slow) for x in COMMANDS)])
def test_a_command_parses_a_data_file_once(lwr_dyn_command, command, parsed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, _, err = lwr_dyn_command(*command.split())
    assert not code, err
    assert parsed == (list(robots()) if command == "list" else ["lwr4plus"])


def test_robots_are_those_of_papers_and_of_published_sets_each_with_its_default_reading_first():
    assert set(studied()) & set(published()) == set()
    assert robots() == tuple(sorted({*studied(), *published()}))
    for robot in robots():
        paper, under_each = open_paper(robot), catalog.open_readings(robot)
        assert readings(robot) == paper.reading_names == tuple(each.reading.name for each in under_each)
        assert readings(robot)[0] == paper.default_reading == paper.reading.name
        assert set(readings(robot)) == set(paper.readings)
        assert {each.digest for each in under_each} == {paper.digest}
    files = catalog.data_files("lwr4plus")
    assert list(files) == ["lwr4plus.toml", *sorted(name for name in files if "/" in name)]
    assert tomllib.loads(files["lwr4plus.toml"])["name"] == "lwr4plus"
    assert next(iter(catalog.data_files("panda"))) == "panda.toml"
    for open_it in (catalog.data_files, open_paper):
        with pytest.raises(UnknownNameError, match="no robot named 'panta'"):
            open_it("panta")


@pytest.mark.parametrize("robot", studied())
def test_printed_tables_are_the_same_under_every_reading_and_free_of_errata(robot):
    papers = [open_paper(robot, reading) for reading in readings(robot)]
    for paper in papers:
        assert paper.printed == papers[0].printed
    for erratum in papers[0].errata:  # each states what is printed in its cells, so it applies to them
        assert re.fullmatch(r"[a-z0-9-]+", erratum.id)
        tables = deepcopy(dict(papers[0].printed))
        assert bool(apply_errata(tables, (erratum,), robot)) == (tables != papers[0].printed)


@pytest.mark.parametrize("convention", ["standard", "modified"])
@pytest.mark.parametrize("joints", ["R", "RRRRRR", "RPR", "PP"])
def test_the_template_is_a_valid_file(joints, convention):
    paper = parse_paper(template("own.toml", "own", joints, convention), "own.toml")
    assert (paper.name, paper.n, paper.convention.value) == ("own", len(joints), convention)
    assert "".join(kind.value[0].upper() for kind in paper.kinds) == joints
    assert arm_from_paper(paper).require_dynamics().n == len(joints)


def test_the_numbers_of_the_template_are_those_of_an_arm_to_begin_with():
    """Axes to and fro by a right angle, every second row 0.3 m on, a sliding joint half a metre long."""
    raw = tomllib.loads(template("a/own.toml", "mine", "RPRP", "modified"))
    values = {f"{table}.{name}": x["values"] for table in ("dh", "limits", "inertial") for name, x in raw[table].items()
              if isinstance(x, dict)}  # fmt: skip
    assert values["dh.alpha"] == [90, -90, 90, 0]
    assert values["dh.d"] == [0.3, 0, 0.3, 0]
    assert (values["dh.a"], values["limits.effort"]) == ([0] * 4, [100] * 4)
    assert (values["limits.lower"], values["limits.upper"]) == ([-170, 0] * 2, [170, 0.5] * 2)
    assert values["limits.velocity"] == [120, 0.5] * 2
    assert (values["inertial.mass"], values["inertial.com"]) == ([2.0] * 4, [[0, 0, -0.05]] * 4)
    assert values["inertial.inertia"] == [[[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.004]]] * 4
    units = {name: raw["limits"][name]["unit"] for name in ("lower", "velocity", "effort")}
    assert units == {"lower": ["deg", "m"] * 2, "velocity": ["deg/s", "m/s"] * 2, "effort": ["N m", "N"] * 2}
    assert tomllib.loads(template("own.toml", "own", "RR"))["limits"]["lower"]["unit"] == "deg"
    assert tomllib.loads(template("own.toml", "own"))["dh"]["convention"] == "standard"
    assert len(tomllib.loads(template("own.toml", "own"))["joints"]["kinds"]) == 6
    assert "a/own.toml" in template("a/own.toml", "mine")


@pytest.mark.parametrize(("joints", "convention"), [("", "standard"), ("RX", "standard"), ("R", "craig")])
def test_the_template_refuses_other_joints_and_conventions(joints, convention):
    with pytest.raises(OptionError):
        template("own.toml", "own", joints, convention)
