"""What the page writes of an arm: facts, notes, sliders and switches, tables whose numbers open their sources."""

import re
from dataclasses import replace
from html import unescape
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import template as new_arm
from lwr_dyn.model.arm import JointLimits, Source
from lwr_dyn.pages.explorer.arm_html import (
    NumberCell,
    NumberColumn,
    _facts,
    _notes,
    arm_pieces,
    changed_pieces,
    joint_columns,
    link_columns,
    table,
    table_cells,
    tables,
    template,
)
from tests.pages.explorer.explored import NAMES, explored_arm


def column(columns, title):
    return next(each for each in columns if each.title == title)


def links_table(arm):
    return table("Links", "", "links", [(link.link, "") for link in arm.chain.links], link_columns(arm))


def numbers(cell):
    return [float(x) for x in cell.text.split(",")]


def test_numbers_are_those_of_the_arm_in_the_units_of_the_head():
    arm = lwr_dyn.load("lwr4plus")
    joints, links, bodies = joint_columns(arm), link_columns(arm), arm.bodies()
    assert [(x.title, x.unit) for x in (*joints, *links)] == [
        ("lower limit", "deg"), ("upper limit", "deg"), ("speed", "deg/s"), ("effort", "N m"),
        ("rotor inertia at the joint", "kg m²"), ("mass", "kg"), ("centre of mass x, y, z", "mm"),
        ("principal moments", "kg m²"), ("semi-axes of the ellipsoid", "mm"),
    ]  # fmt: skip
    speeds = np.array([x.velocity for x in arm.limits])
    expected = [np.degrees(arm.lower), np.degrees(arm.upper), np.degrees(speeds), arm.effort, arm.armature]
    for each, values in zip(joints, expected, strict=True):
        np.testing.assert_allclose([float(cell.text) for cell in each.cells], values, rtol=1e-5)
    assert [cell.exact for cell in joints[0].cells] == [f"{x!r} rad" for x in arm.lower.tolist()]
    assert [cell.exact for cell in joints[2].cells] == [f"{x!r} rad/s" for x in speeds.tolist()]
    assert [cell.exact for cell in joints[3].cells] == [f"{x!r} N m" for x in arm.effort.tolist()]
    assert [cell.heading for cell in joints[3].cells] == [f"{name}, effort" for name in arm.joint_names]
    parts = ("mass", "centre of mass", "principal moments", "ellipsoid")
    assert [each.cells[2].heading for each in links] == [f"link_3, {part}" for part in parts]
    for mass, centre, moments, axes, body in zip(*(each.cells for each in links), bodies, strict=True):
        principal = np.linalg.eigvalsh(body.inertia_com)
        solid = np.sqrt(2.5 * (principal.sum() - 2 * principal) / body.mass)  # I1 = m (b^2 + c^2) / 5 and so on
        np.testing.assert_allclose(numbers(mass), [body.mass])
        np.testing.assert_allclose(numbers(centre), 1000.0 * body.com, rtol=1e-5, atol=1e-9)
        np.testing.assert_allclose(numbers(moments), principal, rtol=1e-5)
        np.testing.assert_allclose(sorted(numbers(axes)), sorted(1000.0 * solid), rtol=1e-5)
        exact = [float(x) for x in axes.exact.removesuffix(" m").split(",")]
        np.testing.assert_allclose(sorted(exact), sorted(solid), rtol=1e-9)
        assert centre.exact == f"{', '.join(map(repr, body.com.tolist()))} m"
        assert (mass.exact, moments.exact.split()[-2:]) == (f"{float(body.mass)!r} kg", ["kg", "m^2"])
        assert (mass.how, moments.how) == ("", "eigenvalues of the inertia about the centre of mass")
        assert {s.cell for s in axes.sources} == {s.cell for s in (*moments.sources, *mass.sources)}


def test_a_cell_opens_its_sources_word_for_word():
    """A number with one source, one without, an unknown one; sources beyond twelve are counted."""
    source = Source("a.mass[0]", "Table <1>", "printed", (1, [2, 3]), "g", "times 1e-3", ("slip-1", "slip-2"))
    file = replace(source, value="as in the file", errata=(), where="the file")
    deep = replace(source, value={"xx": 1, "yy": (2, 3)}, errata=())
    cells = (
        NumberCell("link_1, mass", "2.5", "2.5 kg", (source, file), "by hand"),
        NumberCell("link_2, mass", "3", "3.0 kg"),
        NumberCell("link_3, mass", "", how="no <mass>"), NumberCell("link_4, mass", "4", "4.0 kg", (deep,) * 13),
        NumberCell("link_5, mass", ""),
    )  # fmt: skip
    found = table_cells("links", (NumberColumn("mass & so", "kg", cells),))
    first = (
        "<dl><dt>source<dd>Table &lt;1&gt;<dt>cell<dd>a.mass[0]<dt>kind<dd>printed<dt>there<dd>1; 2; 3 g"
        "<dt>conversion<dd>times 1e-3<dt>erratum<dd>slip-1, slip-2</dl>"
    )
    second = (
        "<dl><dt>source<dd>the file<dt>cell<dd>a.mass[0]<dt>kind<dd>printed<dt>there<dd>as in the file"
        "<dt>conversion<dd>times 1e-3</dl>"
    )
    deep_text = (
        "<dl><dt>source<dd>Table &lt;1&gt;<dt>cell<dd>a.mass[0]<dt>kind<dd>printed<dt>there<dd>xx 1, yy 2; 3 g"
        "<dt>conversion<dd>times 1e-3</dl>"
    )
    more = "<dl><dt>more<dd>1 further cells, in the .provenance.json of lwr-dyn urdf</dl>"
    button = "<button class=n type=button popovertarget=links_{0}>{1}</button><div popover id=links_{0} class=pop>"
    assert found == {
        "links_h1": "mass &amp; so<br><small>kg · printed</small>",
        "links_1_c": f"{button.format(1, 2.5)}<h3>link_1, mass</h3><dl><dt>value<dd>2.5 kg<dt>computed<dd>by hand</dl>"
        f"{first}{second}</div>",
        "links_2_c": f"{button.format(2, 3)}<h3>link_2, mass</h3><dl><dt>value<dd>3.0 kg</dl>"
        "<dl><dt>source<dd>no source given</dl></div>",
        "links_3_c": '<span class="soft">no &lt;mass&gt;</span>',
        "links_4_c": f"{button.format(4, 4)}<h3>link_4, mass</h3><dl><dt>value<dd>4.0 kg</dl>{12 * deep_text}"
        f"{more}</div>",
        "links_5_c": '<span class="soft">unknown</span>',
    }
    twelve = NumberColumn("m", "kg", (replace_cell(cells[3], (deep,) * 12),))
    assert "further" not in table_cells("x", (twelve,))["x_1_c"]


def replace_cell(cell, sources):
    return NumberCell(cell.heading, cell.text, cell.exact, sources, cell.how)


def test_a_table_has_its_rows_in_order():
    columns = tuple(NumberColumn(t, "m", (NumberCell("", ""), NumberCell("", "", how=t))) for t in "ab")
    text = table("A & b", "<i>About</i>", "t", [("j<1>", "turns"), ("j2", "")], columns)
    soft = '<span class="soft">{}</span>'
    rows = (
        f'<tr><th scope="row">j&lt;1&gt; <small>turns</small></th><td class=num id=t_1_c>{soft.format("unknown")}</td>'
        f"<td class=num id=t_2_c>{soft.format('unknown')}</td></tr>"
        f'<tr><th scope="row">j2</th><td class=num id=t_3_c>{soft.format("a")}</td>'
        f"<td class=num id=t_4_c>{soft.format('b')}</td></tr>"
    )
    heads = "".join(
        f'<th scope="col" class="num" id="t_h{k}">{t}<br><small>m</small></th>' for k, t in ((1, "a"), (2, "b"))
    )
    assert text == (
        '<section class="card tab" id="t" aria-labelledby="t-title"><h2 id="t-title">A &amp; b</h2>'
        '<p><i>About</i></p><div class="scroll" tabindex="0" role="region" '
        'aria-label="A &amp; b, scrolls sideways"><table><thead><tr><th scope="col">name</th>'
        f"{heads}</tr></thead><tbody>{rows}</tbody></table></div></section>"
    )


def test_a_number_opens_its_page_its_cell_and_the_errata_that_changed_it(arm):
    text = unescape(links_table(arm))
    assert "Fig. 1, column Mass" in text
    assert "inertial.mass.values[0]" in text
    changed = {name for link in arm.chain.links for source in arm.sources[f"{link.link}.com"] for name in source.errata}
    assert changed
    assert all(name in text for name in changed)


@pytest.mark.parametrize("name", NAMES)
def test_each_number_opens_a_popover_that_exists_and_names_its_source(name):
    arm = explored_arm(name)
    text = tables(arm)
    asked, there = re.findall(r"popovertarget=(\w+)", text), re.findall(r"popover id=(\w+)", text)
    assert asked == there
    assert len(set(asked)) == len(asked)
    assert all("<dt>source<dd>" in pop for pop in text.split("<div popover")[1:])
    assert "no source given" not in text
    cells = [cell for each in (*joint_columns(arm), *link_columns(arm)) for cell in each.cells]
    assert text.count('class="soft"') == sum(not cell.text for cell in cells)


def test_unknown_is_said_and_never_zero():
    text = links_table(lwr_dyn.load("lwr4"))
    assert text.count("unknown") == 7 * 4
    assert "popovertarget" not in text
    effort = column(joint_columns(lwr_dyn.load("kr30ha")), "effort")
    assert [cell.text for cell in effort.cells] == [""] * 6


def test_estimates_are_seen_in_the_head_and_sliding_joints_have_their_units():
    assert column(link_columns(lwr_dyn.load("kr30ha")), "mass").kinds == ("estimated",)
    texts = [(each.cells[0].text, each.cells[0].exact) for each in joint_columns(explored_arm("tiago"))]
    assert texts[:4] == [("0 m", "0.0 m"), ("0.35 m", "0.35 m"), ("0.07 m/s", "0.07 m/s"), ("2000 N", "2000.0 N")]


@pytest.fixture
def own(tmp_path):
    """Of joints that turn and slide, with limits unknown on one side or both."""
    (tmp_path / "own.toml").write_text(new_arm("own.toml", "own", "RPRR"), encoding="utf-8")
    arm = lwr_dyn.load(tmp_path / "own.toml")
    limits = (arm.limits[0], arm.limits[1], JointLimits(upper=0.5), JointLimits())
    return replace(arm, limits=limits)


def test_sliders_go_from_limit_to_limit_in_degrees_or_metres_and_say_what_is_unknown(own):
    lines = arm_pieces(own, "")["sliders"].splitlines()
    ends = [tuple(map(float, re.search(r'min="(.*?)" max="(.*?)"', line).groups())) for line in lines]
    assert ends == [pytest.approx(x) for x in ((-170.0, 170.0), (0.0, 0.5), (-180.0, np.degrees(0.5)), (-180.0, 180.0))]
    said = [re.findall(r"<span>(.*?)</span>", line) for line in lines]
    assert said == [["-170", "170"], ["0", "0.5"], ["limit unknown", "28.6479"], ["limits unknown"]]
    assert [re.search(r'class="unit">(\w+)<', line)[1] for line in lines] == ["deg", "m", "deg", "deg"]
    assert lines[1].startswith(
        '<div class="joint"><label for="slider_2" title="joint_2">joint_2</label><input id="slider_2" type="range" '
        'min="0.0" max="0.5" step="any" value="0"><input id="value_2" type="text" inputmode="decimal" '
        'aria-label="joint_2, m">'
    )
    endless = arm_pieces(explored_arm("tiago"), "")["sliders"]
    assert "turns without end" not in endless


SWITCHES = {"flange": True, "frames": False, "native": False, "centres": True, "ellipsoids": False, "limits": False,
            "gravity": True, "see-through": False}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "missing"),
    [("lwr4plus physical", ()), ("lwr4 printed", ("centres", "ellipsoids", "limits")), ("panda", ("native",))],
)
def test_there_is_a_switch_for_what_is_there(name, missing):
    found = re.findall(
        r'<input id="([\w-]+)" type="checkbox"( checked)?>', arm_pieces(explored_arm(name), "")["arm-switches"]
    )
    assert {ident: bool(on) for ident, on in found} == {x: on for x, on in SWITCHES.items() if x not in missing}


@pytest.mark.parametrize(("tool", "name"), [(None, "flange frame"), ((0.0, 0.0, 0.1), "tool centre point frame")])
def test_the_switch_of_the_last_frame_has_its_name(tool, name):
    arm = lwr_dyn.load("lwr4plus", tool=None if tool is None else {"xyz": tool})
    assert name in arm_pieces(arm, "")["arm-switches"].split("<input")[1]


def test_facts_are_in_one_line():
    arm = lwr_dyn.load("lwr4plus", "physical")
    mass = sum(body.mass for body in arm.bodies())
    assert _facts(arm) == (
        f"reading <b>physical</b> · 7 joints · moving links {mass:.6g} kg · gravity 9.81 m/s² along (0, 0, -1)"
    )
    bare = _facts(replace(arm, chain=replace(arm.chain, gravity=np.zeros(3))))
    assert bare.endswith("gravity 0 m/s² along (0, 0, 0)")
    assert "masses of 0 of 7 links known" in _facts(lwr_dyn.load("lwr4"))
    wall = _facts(replace(arm, chain=replace(arm.chain, gravity=np.array([0.0, -2.0, 0.0]))))
    assert wall.endswith("gravity 2 m/s² along (0, -1, 0)")
    panda = explored_arm("panda")
    assert _facts(panda).split(" · ")[0] == panda.title
    assert arm_pieces(panda, "")["arm-title"] == panda.name
    assert arm_pieces(arm, "")["arm-name"] == "lwr4plus, reading physical"


@pytest.mark.parametrize(
    ("robot", "reading", "words"),
    [
        ("lwr4plus", "computed", "leaves rotor-inertia-power in place, a proven error"),
        ("kr30ha", "kuka", "masses, centres of mass and inertias estimated from drawn solids"),
        ("wam7", None, None),
    ],
)
def test_what_must_be_known_stands_first_in_the_line_of_the_source(robot, reading, words):
    said = arm_pieces(lwr_dyn.load(robot, reading), "")["arm-by"]
    assert said.startswith(f'<b class="caveat">{words}</b> · ') if words else "caveat" not in said


def notes(missing="", **more):
    given = {"notes": (), "layout": None, "drawing": SimpleNamespace(cylinders=(1,))} | more
    return re.findall("<p>(.*?)</p>", _notes(SimpleNamespace(**given), missing))


def test_notes_are_paragraphs_and_long_ones_are_cut():
    assert _notes(SimpleNamespace(notes=(), layout=None, drawing=SimpleNamespace(cylinders=(1,))), "") == ""
    assert notes("no <torques>", notes=("a", "x" * 400, "y" * 401)) == [
        "no &lt;torques&gt;", "a", "x" * 400, f"{'y' * 400} ...",
    ]  # fmt: skip
    along = "shapes are drawn along the joints; "
    assert notes(drawing=SimpleNamespace(cylinders=())) == [f"{along}no dynamics depends on them"]
    assert notes(layout=SimpleNamespace(shapes={"a": ("<box/>", "<mesh x/>")})) == [
        f"{along}the meshes of the file are not drawn"
    ]
    assert notes(layout=SimpleNamespace(shapes={"a": ("<box/>",)})) == []


def test_names_cannot_break_the_page():
    cell = NumberCell("<script>", "<script>", "<script>", how="<script>")
    for each in (cell, NumberCell("<script>", "", how="<script>")):
        column = NumberColumn("<script>", "<script>", (each,))
        assert "<script>" not in table("<script>", "", "t", [("<script>", "<script>")], (column,))


def test_the_same_arm_changes_nothing(arm):
    assert changed_pieces(arm, "", arm, "") == {}
    assert changed_pieces(arm, "no torques", arm, "").keys() == {"arm-notes"}


def test_a_reading_changes_the_numbers_that_its_errata_change():
    arm, printed = (lwr_dyn.load("lwr4plus", reading) for reading in ("computed", "printed"))
    pieces, page = changed_pieces(printed, "", arm, ""), tables(arm)
    cells = [key for key in pieces if key.endswith("_c")]
    assert 0 < len(cells) < 12
    assert all(f"id={key}>" in page for key in cells)
    assert all(pieces[key] in tables(printed) and pieces[key] not in page for key in cells)
    assert "sliders" not in pieces
    assert template(1, {"a": "<b>"}) == '<template id="arm-1"><div data-for="a"><b></div></template>'


@pytest.mark.parametrize("other", ["kr30ha", "wam7"])
def test_another_robot_changes_whole_tables_where_its_rows_are_others(arm, other):
    robot = lwr_dyn.load(other)
    pieces = changed_pieces(robot, "", arm, "")
    assert ("links" in pieces) == (other == "kr30ha")
    assert all(
        f'id="links" aria-labelledby="links-title">{x}</section>' in tables(robot) for x in [pieces.get("links")] if x
    )
    assert pieces["arm-title"] == arm_pieces(robot, "")["arm-title"]
    assert {"sliders", "arm-by"} <= pieces.keys()
