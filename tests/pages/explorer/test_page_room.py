"""The room of the explorer's page: on a phone nothing is cut, on a desk no card is emptier than half."""

import numpy as np
import pytest

from tests.axe import seen
from tests.pages.explorer.explored import explored_arm, opened

pytestmark = pytest.mark.slow

PHONE, DESKS = 420, (1600, 1280, 1024)
FILLED, PANELS_FILLED = 0.5, 0.7
"""Of a card's width; of the area that the panels below the arm take: 0.56 while the last stood alone in its row."""
CUT = """const cut = (node) => node.checkVisibility() && node.clientWidth > 1 && node.scrollWidth > node.clientWidth + 1
  && getComputedStyle(node).overflowX !== "visible";
return [...document.querySelectorAll("body *")].filter((node) => !node.matches("input") && cut(node)).map((node) =>
  `${node.tagName}.${node.className} ${node.ariaLabel ?? node.id}: ${node.scrollWidth} in ${node.clientWidth}`);"""
OUTSIDE = """const out = [];
document.querySelectorAll(".card, #switches, .lead").forEach((card) => {
  const edge = card.getBoundingClientRect(), range = document.createRange();
  if (edge.width === 0) return; // the card of the view, which hands its parts to the page
  const texts = document.createTreeWalker(card, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const node = texts.currentNode, parent = node.parentElement;
    if (!node.data.trim() || !parent.checkVisibility() || parent.closest(".unseen, select, [popover]")) continue;
    range.selectNodeContents(node);
    const { left, right } = range.getBoundingClientRect();
    if (left < edge.left - 0.5 || right > edge.right + 0.5) out.push(node.data.trim());
  }
});
return out;"""
SHARES = """return [...document.querySelectorAll(".card")].filter((card) => card.offsetWidth > 0).map((card) => {
  const box = card.getBoundingClientRect(), range = document.createRange(), span = [Infinity, -Infinity];
  const hold = ({ left, right, width }) => {
    if (width > 0) [span[0], span[1]] = [Math.min(span[0], left), Math.max(span[1], right)];
  };
  card.querySelectorAll("input, svg, canvas, button, select").forEach((node) => hold(node.getBoundingClientRect()));
  const texts = document.createTreeWalker(card, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    if (!texts.currentNode.data.trim() || texts.currentNode.parentElement.closest("[popover]")) continue;
    range.selectNodeContents(texts.currentNode);
    hold(range.getBoundingClientRect());
  }
  return [card.getAttribute("aria-label") ?? card.id, (span[1] - span[0]) / box.width];
});"""
PANELS = """const whole = document.getElementById("panels").getBoundingClientRect();
const area = ({ width, height }) => width * height, cards = [...document.querySelectorAll("#panels > *")];
return cards.reduce((sum, card) => sum + area(card.getBoundingClientRect()), 0) / area(whole);"""


def at_large_numbers(window, name):
    """A pose and speeds whose numbers have signs and many digits."""
    arm = explored_arm(name)
    low, up = np.maximum(arm.lower, -3.1), np.minimum(arm.upper, 3.1)
    q = low + 0.07 * (up - low)
    window.execute_script(
        """const [q] = arguments; lwrExplorer.setPose(q);
        lwrExplorer.state.set({ dq: q.map((_, i) => (i % 2 ? -2.5 : 1.7)), ddq: q.map(() => -12.5) });
        lwrExplorer.state.compute();""",
        q.tolist(),
    )


@pytest.mark.parametrize("name", ["lwr4plus physical", "kr30ha kuka", "wam7 manual", "hung"])
def test_on_a_phone_nothing_is_cut(browser, page_of, name):
    with seen(browser, PHONE):
        window = opened(browser, page_of(name).as_uri())
        assert window.execute_script(CUT) == []
        at_large_numbers(window, name)
        assert window.execute_script(CUT) == []
        assert window.execute_script(OUTSIDE) == []


@pytest.mark.parametrize("width", DESKS)
def test_no_card_is_emptier_than_half(browser, page_of, width):
    for name in ("lwr4plus physical", "wam7 manual"):
        with seen(browser, width):
            window = opened(browser, page_of(name).as_uri())
            shares = window.execute_script(SHARES)
            assert len(shares) > 8
            assert {card: share for card, share in shares if share < FILLED} == {}
            assert window.execute_script(PANELS) > PANELS_FILLED


@pytest.mark.parametrize("cards", [1, 2, 3, 4, 5])
def test_panels_leave_no_gap_however_many_they_are(browser, page_of, cards):
    """Of equal panels: the last row is empty by less than half, and a column never."""
    with seen(browser, 1600):
        window = opened(browser, page_of("lwr4plus physical").as_uri())
        window.execute_script(
            """const place = document.getElementById("panels");
            place.replaceChildren(...Array.from({ length: arguments[0] }, () => {
              const card = document.createElement("section");
              card.className = "card";
              card.style.height = "300px";
              return card;
            }));""",
            cards,
        )
        assert window.execute_script(PANELS) > 0.6
