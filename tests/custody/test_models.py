"""Custody: the committed models are fresh, and every number in them is made from the cells its sidecar names.

The sidecar is recomputed from itself: an own walk over the XML finds the numbers, own formulas make them from cells.
"""

import json
import re
import runpy
import tomllib
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied
from lwr_dyn.arms.papers.schema import to_si
from lwr_dyn.arms.urdf.elements import CHOICE, DRAWN, UNKNOWN, WEIGHTLESS
from lwr_dyn.arms.urdf.model_files import UNSOURCED, model_files, model_stem, provenance_text, quantity_sources
from lwr_dyn.model.spatial import rot_x, rot_y, rot_z, steiner
from tests.tolerances import EXACT

ROOT = Path(__file__).parents[2]
CASES = [(robot, reading) for robot in studied() for reading in lwr_dyn.readings(robot)]
WORDS = {DRAWN, UNKNOWN, CHOICE, WEIGHTLESS}
DRAKE = "{https://drake.mit.edu/}"


@pytest.fixture(params=CASES, ids="-".join)
def arm(request):
    return lwr_dyn.load(*request.param)


def walk(element, path):
    """Path -> text of every attribute that is made of numbers."""
    found = {}
    for name, text in element.attrib.items():
        if re.fullmatch(r"[-+.\deE\s]*\d[-+.\deE\s]*", text):
            found[f"{path}/@{name}"] = text
    seen = {}
    for child in element:
        tag = child.tag.replace(DRAKE, "drake:")
        seen[tag] = seen.get(tag, 0) + 1
        step = f"{tag}[@name='{child.get('name')}']" if tag in ("link", "joint", "material", "transmission") else tag
        found |= walk(child, f"{path}/{step}[{seen[tag]}]" if tag in ("visual", "collision") else f"{path}/{step}")
    return found


def si(cell):
    return np.vectorize(lambda v: to_si(v, cell["unit"]))(np.array(cell["value"], dtype=float))


def cells_of(side, quantity):
    """Column -> value in SI."""
    return {c["cell"].partition(".values")[0]: si(c) for c in side["quantities"][quantity]}


def pose(rotation=None, position=(0.0, 0.0, 0.0)):
    out = np.eye(4)
    out[:3, 3] = position
    if rotation is not None:
        out[:3, :3] = rotation
    return out


def constant_pose(side, quantity):
    """The 4x4 matrix that a quantity's cells make."""
    cells = {name: value.tolist() for name, value in cells_of(side, quantity).items()}
    if quantity == "flange":
        r, p, y = cells.get("flange.rpy", (0.0, 0.0, 0.0))
        return pose(rot_z(y) @ rot_y(p) @ rot_x(r), cells.get("flange.xyz", (0.0, 0.0, 0.0)))
    alpha, a, d, theta = (cells.get(f"dh.{x}", 0.0) for x in ("alpha", "a", "d", "theta_offset"))
    turn = pose(rot_x(np.pi) if cells.get("dh.sign", 1.0) < 0 else None)
    twist = pose(rot_x(alpha)) @ pose(position=(a, 0, 0))
    if quantity.endswith(".before"):
        return twist @ turn
    return turn @ pose(rot_z(theta)) @ pose(position=(0, 0, d)) @ twist


def product(side, quantities):
    out = np.eye(4)
    for quantity in quantities:
        out = out @ constant_pose(side, quantity)
    return out


def recomputed(side, path, quantities):
    """The numbers of an attribute from the cells of its quantities."""
    attribute, first = path.rpartition("@")[2], quantities[0]
    if "/inertial/" not in path and path.endswith(("origin/@xyz", "origin/@rpy")):
        return position_or_rotation(product(side, quantities), attribute)
    kind = first.rpartition(".")[2]
    if kind == "com":
        return (product(side, quantities[1:]) @ [*cells_of(side, first)["inertial.com"], 1.0])[:3]
    if kind == "inertia":
        tensor = tensor_about_com(side, first)
        turn = product(side, quantities[1:])[:3, :3]
        return [(turn @ tensor @ turn.T)["xyz".index(attribute[1]), "xyz".index(attribute[2])]]
    values = cells_of(side, first)
    return [float(sum(values.values()))]


def tensor_about_com(side, quantity):
    cells = {c["cell"].partition(".values")[0]: c for c in side["quantities"][quantity]}
    tensor, how = si(cells["inertial.inertia"]), cells["inertial.inertia"]["conversion"]
    if "products negated" in how:
        tensor = 2 * np.diag(np.diag(tensor)) - tensor
    if "Steiner" in how:
        tensor = tensor - steiner(float(si(cells["inertial.mass"])), si(cells["inertial.com"]))
    return tensor


def position_or_rotation(matrix, attribute):
    return matrix[:3, 3] if attribute == "xyz" else matrix[:3, :3]


def agrees(written, expected):
    expected = np.asarray(expected)
    if expected.shape == (3, 3):
        r, p, y = written
        written = rot_z(y) @ rot_y(p) @ rot_x(r)
    return np.abs(np.asarray(written) - expected).max() <= EXACT * max(1e-3, np.abs(expected).max())


def faults(text, side):
    """What is wrong between a URDF and its sidecar, one line each."""
    found, entries = walk(ElementTree.fromstring(text), "/robot"), side["attributes"]
    out = [f"no entry: {p}" for p in found if p not in entries] + [f"no number: {p}" for p in entries if p not in found]
    for path in found.keys() & entries.keys():
        entry = entries[path]
        quantities = entry.get("quantities", [])
        if entry["written"] != [float(x) for x in found[path].split()]:
            out.append(f"another number: {path}")
        elif not quantities:
            out += [] if entry.get("word") in WORDS else [f"neither source nor word: {path}"]
        elif not any(side["quantities"].get(q) for q in quantities):
            out.append(f"no cell: {path}")
        elif not agrees(entry["written"], recomputed(side, path, quantities)):
            out.append(f"not what the cells make: {path}")
    return out


@pytest.fixture(scope="module")
def main():
    """The script that writes and checks the models, which makes them once for all questions."""
    found = runpy.run_path(str(ROOT / "scripts" / "build_models.py"))["main"]
    found.__globals__["all_files"] = cache(found.__globals__["all_files"])
    return found


def test_the_models_are_fresh(main, capsys):
    assert main(["--check"]) == 0, capsys.readouterr().out


def test_the_check_sees_stale_missing_and_surplus_files(main, tmp_path, capsys):
    assert main(["--check", "--folder", str(tmp_path)]) == 1
    assert "missing: lwr4plus/lwr4plus.urdf" in capsys.readouterr().out
    assert main(["--folder", str(tmp_path)]) == 0
    assert main(["--check", "--folder", str(tmp_path)]) == 0
    model = tmp_path / "lwr4plus" / "lwr4plus.urdf"
    model.write_text(model.read_text().replace("2.7782", "2.7783", 1))
    (tmp_path / "lwr4" / "lwr4.srdf").write_text("")
    capsys.readouterr()
    assert main(["--check", "--folder", str(tmp_path)]) == 1
    assert capsys.readouterr().out.split("\n")[:2] == ["stale: lwr4plus/lwr4plus.urdf", "surplus: lwr4/lwr4.srdf"]


def test_the_default_reading_has_the_plain_name():
    assert model_stem(lwr_dyn.load("lwr4plus")) == "lwr4plus"
    assert set(model_files(lwr_dyn.load("lwr4plus", "printed"))) == {
        f"lwr4plus_printed.{ending}" for ending in ("urdf", "srdf", "xml", "provenance.json")
    }


def test_every_number_is_what_its_cells_make(arm):
    side = json.loads(provenance_text(arm))
    assert faults(lwr_dyn.urdf_text(arm), side) == []
    assert UNSOURCED not in {entry.get("word") for entry in side["attributes"].values()}


def test_every_cell_is_in_the_data_file(arm):
    raw = tomllib.loads(resources.files("lwr_dyn.arms.papers").joinpath(f"{arm.name}.toml").read_text(encoding="utf-8"))
    for sources in json.loads(provenance_text(arm))["quantities"].values():
        for source in sources:
            table, column, rest = source["cell"].split(".")
            values = raw[table][column]["values"]
            row = values[int(rest[len("values[") : -1])] if "[" in rest else values
            assert source["where"] == raw[table][column]["where"]
            assert set(source.get("errata", ())) <= set(arm.errata)
            assert source.get("errata") or source["value"] == row


MUTATIONS = {
    "a number changed": lambda s: s["attributes"]["/robot/link[@name='link_2']/inertial/mass/@value"].update(
        written=[9.0]
    ),
    "an entry lost": lambda s: s["attributes"].pop("/robot/joint[@name='joint_3']/limit/@lower"),
    "an entry too many": lambda s: s["attributes"].update({"/robot/x/@y": {"written": [1.0], "word": DRAWN}}),
    "a word instead of a source": lambda s: s["attributes"].update(
        {"/robot/joint[@name='joint_1']/limit/@effort": {"written": [176.0], "word": "trust me"}}
    ),
    "a cell lost": lambda s: s["quantities"].update({"link_4.mass": []}),
    "a cell of another link": lambda s: s["quantities"].update({"link_5.mass": s["quantities"]["link_1.mass"]}),
    "a unit changed": lambda s: s["quantities"]["joint_2.upper"][0].update(unit="rad"),
    "the limit's zero lost": lambda s: s["quantities"]["joint_2.lower"].pop(),
    "a twist reversed": lambda s: s["quantities"]["joint_3.after"][0].update(value=90.0),
    "the joint's own row": lambda s: s["attributes"]["/robot/joint[@name='joint_4']/origin/@xyz"].update(
        quantities=["joint_4.after"]
    ),
    "a product's sign": lambda s: s["quantities"]["link_3.inertia"][0].update(conversion="as is"),
    "a centre of mass": lambda s: s["quantities"]["link_6.com"][0].update(value=[0, 0, 0]),
    "a rotor": lambda s: s["quantities"]["joint_7.rotor_inertia"][0].update(value=1.0),
}


@pytest.mark.parametrize("name", MUTATIONS)
def test_a_changed_sidecar_is_caught(name):
    arm = lwr_dyn.load("lwr4plus", "physical")
    side = json.loads(provenance_text(arm))
    MUTATIONS[name](side)
    assert faults(lwr_dyn.urdf_text(arm), side)


def test_modified_rows_are_split_about_the_joint(tmp_path):
    text = resources.files("lwr_dyn.arms.papers").joinpath("lwr4plus.toml").read_text(encoding="utf-8")
    table = text.replace('convention = "standard"', 'convention = "modified"')
    table = table.replace("a = { values = [0, 0,", "a = { values = [0, 0.2,", 1)
    path = tmp_path / "modified.toml"
    path.write_text(table, encoding="utf-8")
    arm = lwr_dyn.load(path)
    side = json.loads(provenance_text(arm))
    assert {c["cell"] for c in side["quantities"]["joint_2.before"]} == {"dh.alpha.values[1]", "dh.a.values[1]"}
    assert {c["cell"] for c in side["quantities"]["joint_2.after"]} == {"dh.d.values[1]"}
    assert faults(lwr_dyn.urdf_text(arm), side) == []


def test_a_foreign_urdf_names_its_own_elements(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(lwr_dyn.urdf_text(lwr_dyn.load("lwr4plus")), encoding="utf-8")
    arm = lwr_dyn.load(path)
    side = json.loads(provenance_text(arm))
    assert UNSOURCED not in {entry.get("word") for entry in side["attributes"].values()}
    assert side["quantities"]["link_3.mass"][0]["cell"] == "/robot/link[@name='link_3']/inertial"
    assert all(source.where == "arm.urdf" for source in quantity_sources(arm, "joint_2.gear_ratio"))


def test_an_arm_built_in_code_is_marked_as_without_source():
    arm = replace(lwr_dyn.load("lwr4plus"), sources={})
    side = json.loads(provenance_text(arm))
    assert side["attributes"]["/robot/link[@name='link_1']/inertial/mass/@value"]["word"] == UNSOURCED
