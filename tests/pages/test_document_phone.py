"""A document on a phone: no table is cut, each number has its heading beside it."""

import pytest

from lwr_dyn.foundation.document import Document, Section
from lwr_dyn.foundation.tables import Heading, Marked, Table
from lwr_dyn.pages.document import page_html
from tests.axe import faint_texts, seen, sideways, violations

pytestmark = pytest.mark.slow

CUT = """return [...document.querySelectorAll("body *")].filter((node) => node.checkVisibility() && node.clientWidth > 1
  && node.scrollWidth > node.clientWidth + 1 && getComputedStyle(node).overflowX !== "visible").map((node) =>
  `${node.tagName}.${node.className}: ${node.scrollWidth} in ${node.clientWidth}`);"""
SHOWN = """const rows = [...document.querySelectorAll(".stacks tbody tr")];
return rows.filter((row) => row.checkVisibility()).map((row) => {
  const said = (cell) => getComputedStyle(cell, "::before").content.replace(/^"|"$|^none$/g, "");
  return [...row.children].filter((cell) => cell.checkVisibility()).map((cell) => [said(cell), cell.innerText.trim()]);
});"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    heads = ("controller", Heading("plant", pick=True), "tip RMS [mm]", Heading("largest", "mm"), "peak torque [N m]",
             "of limit", Heading("pull", bar=2.0, format=".1f"), "audit [J]")  # fmt: skip
    rows = [
        ("PD + gravity, damping on dq", "as modelled", 4.05, 4.331, 31.39, "17.8 %", 1.5, 1e-12),
        (
            "inverse dynamics with feed-forward",
            "3 kg at the flange",
            0.0041,
            Marked(0.0064, "best"),
            29.56,
            "",
            -1.0,
            2e-9,
        ),
    ]
    wide = Table("Runs", heads, rows)
    small = Table("Two", ("joint", "range [deg]", "speed [deg/s]"), [("joint_1", "-170 to 170", 110.0)])
    path = tmp_path_factory.mktemp("document") / "page.html"
    path.write_text(
        page_html(Document("Runs", "holds", [Section("All", [wide, small])], "lwr-dyn x")), encoding="utf-8"
    )
    return path


def test_nothing_is_cut_and_each_number_has_its_heading(browser, page):
    with seen(browser, 420):
        browser.get(page.as_uri())
        assert browser.execute_script(CUT) == []
        assert sideways(browser) == 0
        first, second = browser.execute_script(SHOWN)
    assert first[0] == ["", "PD + gravity, damping on dq"]
    assert ["tip RMS [mm]", "4.05"] in first
    assert ["largest, mm", "4.331"] in first or ["largest [mm]", "4.331"] in first
    assert "of limit" in dict(first)
    assert "of limit" not in dict(second)  # an empty cell is no line


def test_a_row_that_is_not_chosen_stays_hidden(browser, page):
    with seen(browser, 420):
        browser.get(page.as_uri())
        browser.execute_script(
            "const list = document.querySelector('.states'); list.value = 'as modelled';"
            "list.dispatchEvent(new Event('change'))"
        )
        assert [row[0][1] for row in browser.execute_script(SHOWN)] == ["PD + gravity, damping on dq"]


def test_a_desk_has_the_table_and_both_are_accessible(browser, page):
    for width in (1600, 420):
        with seen(browser, width):
            browser.get(page.as_uri())
            assert violations(browser) == []
            assert faint_texts(browser) == []
            assert browser.execute_script(CUT) == []
            shown = browser.execute_script("return getComputedStyle(document.querySelector('.stacks tr')).display")
            assert shown == ("table-row" if width == 1600 else "block")
