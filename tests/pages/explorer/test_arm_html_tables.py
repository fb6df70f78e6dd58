"""The tables: each number as it is, with the cell and page that it comes from; unknown is said."""

import re
from html import unescape

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.pages.explorer.arm_html import NumberCell, NumberColumn, joint_columns, link_columns, table
from tests.pages.explorer.explored import NAMES, explored_arm


def column(columns, title):
    return next(each for each in columns if each.title == title)


def links_table(arm):
    return table("Links", "", "links", [(link.link, "") for link in arm.chain.links], link_columns(arm))


def test_numbers_are_those_of_the_arm_in_the_units_of_the_head(arm):
    joints, links = joint_columns(arm), link_columns(arm)
    assert [float(cell.text) for cell in column(joints, "upper limit").cells] == pytest.approx(np.degrees(arm.upper))
    assert [float(cell.text) for cell in column(joints, "effort").cells] == arm.effort.tolist()
    bodies = arm.bodies()
    assert [float(cell.text) for cell in column(links, "mass").cells] == [body.mass for body in bodies]
    for cell, body in zip(column(links, "centre of mass x, y, z").cells, bodies, strict=True):
        np.testing.assert_allclose([float(x) for x in cell.text.split(",")], 1000.0 * body.com, rtol=1e-5, atol=1e-9)
        assert cell.exact == f"{', '.join(map(repr, body.com.tolist()))} m"
    for cell, body in zip(column(links, "principal moments").cells, bodies, strict=True):
        found = [float(x) for x in cell.text.split(",")]
        np.testing.assert_allclose(found, np.linalg.eigvalsh(body.inertia_com), rtol=1e-5)


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
    for ident, rows, columns in (
        ("joints", [(joint.name, joint.kind.value) for joint in arm.joints()], joint_columns(arm)),
        ("links", [(link.link, "") for link in arm.chain.links], link_columns(arm)),
    ):
        text = table(ident, "", ident, rows, columns)
        asked, there = re.findall(r"popovertarget=(\w+)", text), re.findall(r"popover id=(\w+)", text)
        assert asked == there
        assert len(set(asked)) == len(asked)
        assert all("<dt>source<dd>" in pop for pop in text.split("<div popover")[1:])
        assert "no source given" not in text
        assert text.count('class="soft"') == sum(not cell.text for each in columns for cell in each.cells)


def test_unknown_is_said_and_never_zero():
    text = links_table(lwr_dyn.load("lwr4"))
    assert text.count("unknown") == 7 * 4
    assert "popovertarget" not in text
    effort = column(joint_columns(lwr_dyn.load("kr30ha")), "effort")
    assert [cell.text for cell in effort.cells] == [""] * 6


def test_estimates_are_seen_in_the_head_and_sliding_joints_have_their_units():
    assert "estimated" in column(link_columns(lwr_dyn.load("kr30ha")), "mass").kinds
    first = column(joint_columns(explored_arm("tiago")), "effort").cells[0]
    assert (first.text, first.exact) == ("2000 N", "2000.0 N")


def test_names_cannot_break_the_page():
    cell = NumberCell("<script>", "<script>", "<script>", how="<script>")
    for each in (cell, NumberCell("<script>", "", how="<script>")):
        column = NumberColumn("<script>", "<script>", (each,))
        assert "<script>" not in table("<script>", "", "t", [("<script>", "<script>")], (column,))
