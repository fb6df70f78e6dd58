"""The equation of a chosen entry on the explorer's page: the links' shares beside Python's, and how one chooses."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.model.chain import Body, with_bodies, with_payload
from tests.headless import logs
from tests.pages.explorer.by_hand import mouse, press, touch
from tests.pages.explorer.explored import explored_arm, opened
from tests.random_arms import random_arm

pytestmark = pytest.mark.slow

SHOWN = "lwr4plus computed"
MASS, AT = 2.5, [0.01, -0.02, 0.1]
AGREES = 1e-12
"""Of the largest entry."""
SHARES = """const e = lwrExplorer, { equation } = e, [q, dq, mass, at] = arguments;
    const n = q.length, r = [...Array(n).keys()];
    const state = { q: Float64Array.from(q), dq: Float64Array.from(dq) };
    e.carry(mass, at);
    const share = (kind, i, j) => {
      const { sum, matrix, links, rotor } = Object.assign(equation, { kind, i, j }).compute(state);
      return [sum, matrix[kind === "g" ? i : i * n + j], links.map((x) => x.linear + x.angular), rotor];
    };
    const square = (kind) => r.map((i) => r.map((j) => share(kind, i, j)));
    const out = { B: square("B"), C: square("C"), g: r.map((i) => share("g", i, 0)) };
    e.carry(0, [0, 0, 0]);
    return out"""


@pytest.fixture(scope="module")
def arm():
    return explored_arm(SHOWN)


def entries(found, dynamics, q, dq):
    """Letter, the page's rows for its entries, and those of Python."""
    yield "g", found["g"], dynamics.gravity_vector(q)
    for letter, matrix in (("B", dynamics.mass_matrix(q)), ("C", dynamics.coriolis_matrix(q, dq))):
        yield letter, [cell for row in found[letter] for cell in row], matrix.ravel()


def check_shares(window, arm):
    q, dq = np.random.default_rng(11).uniform(-1, 1, (2, arm.n))
    loaded = replace(arm, chain=with_payload(arm.chain, MASS, AT))
    found = window.execute_script(SHARES, q.tolist(), dq.tolist(), MASS, AT)
    for letter, rows, expected in entries(found, lwr_dyn.dynamics_of(loaded), q, dq):
        limit = AGREES * np.abs(expected).max()
        for k, factor in ((0, 1), (1, 10)):
            assert np.abs(np.array([row[k] for row in rows]) - expected).max() < factor * limit, letter
        assert all(abs(sum(row[2]) + row[3] - row[0]) < limit for row in rows)


def test_shares_add_up_to_every_entry(window, arm):
    check_shares(window, arm)


def test_each_share_is_that_of_the_link_alone(window, arm):
    q, dq = np.random.default_rng(12).uniform(-1, 1, (2, arm.n))
    found = window.execute_script(SHARES, q.tolist(), dq.tolist(), 0, AT)
    for k, body in enumerate(arm.chain.bodies):
        chain = with_bodies(arm.chain, [body if i == k else Body.massless() for i in range(arm.n)])
        bare = replace(chain, links=tuple(replace(link, rotor=None) for link in chain.links))
        for letter, rows, expected in entries(found, lwr_dyn.dynamics_of(replace(arm, chain=bare)), q, dq):
            assert np.abs(np.array([row[2][k] for row in rows]) - expected).max() < 1e-12, (letter, k)


CHOSEN = "const { kind, i, j } = lwrExplorer.equation; return [kind, i, j]"
PLACE = """const cell = lwrExplorer.equation.cells[arguments[0]]; cell.scrollIntoView({ block: "center" });
    const { x, y, width, height } = cell.getBoundingClientRect(); return [x + width / 2, y + height / 2]"""


def test_a_cell_is_chosen_by_mouse_by_touch_and_by_keys(window):
    window.execute_script("lwrExplorer.equation.choose('B', 0, 0)")
    mouse(window, window.execute_script(PLACE, 9))
    assert window.execute_script(CHOSEN) == ["B", 1, 2]
    touch(window, window.execute_script(PLACE, 32))
    assert window.execute_script(CHOSEN) == ["B", 4, 4]
    for key in ("ArrowDown", "ArrowRight", "ArrowUp", "ArrowUp"):
        press(window, key)
    assert window.execute_script(CHOSEN) == ["B", 4, 4]
    press(window, "Enter")
    assert window.execute_script(CHOSEN) == ["B", 3, 5]
    assert window.execute_script("return document.activeElement.getAttribute('aria-selected')") == "true"
    window.execute_script("document.querySelector('[aria-label=Matrices] table').rows[2].cells[3].click()")
    assert window.execute_script(CHOSEN) == ["B", 2, 3]
    window.execute_script("document.querySelector('.equation [data-kind=g]').click()")
    assert window.execute_script(CHOSEN) == ["g", 2, 0]
    assert window.execute_script("return lwrExplorer.equation.cells.length") == 7


def test_form_source_and_closed_form_are_written(window):
    said = "lwrExplorer.equation.choose(...arguments); return document.querySelector('.equation').innerText"
    text = window.execute_script(said, "B", 6, 6)
    assert "eq. 7.32" in text
    assert "B_77 = I7zz + Ia7" in text
    assert "I7zz = " in text
    text = window.execute_script(said, "C", 1, 2)
    assert "eqs. 7.44, 7.45" in text
    assert "print(e('lwr4plus', 'C_23', 'computed'))" in text
    text = window.execute_script(said, "g", 1)
    assert "eqs. 7.36, 7.39" in text
    assert "N m" in text


def test_another_reading_has_its_own_shares(window):
    window.execute_script("lwrExplorer.setPose(arguments[0])", [0.3, 0.7, 0.2, -1.4, 0.3, 0.9, 0.1])
    sum_of = "lwrExplorer.equation.choose('B', 1, 1); return lwrExplorer.equation.sum"
    first = window.execute_script(sum_of)
    window.execute_script("lwrExplorer.choose(1)")
    assert abs(window.execute_script(sum_of) - first) > 1e-6
    window.execute_script("lwrExplorer.choose(0)")
    assert window.execute_script(sum_of) == first
    assert logs(window)[1] == []


@pytest.mark.parametrize("other", [explored_arm("hung"), random_arm(5, "RPRP")], ids=["hung", "sliding"])
def test_shares_add_up_for_other_arms(browser, page_of, other):
    check_shares(opened(browser, page_of(other).as_uri()), other)


def test_an_arm_without_masses_has_neither_panel(browser, page_of):
    window = opened(browser, page_of(lwr_dyn.load("lwr4")).as_uri())
    assert window.execute_script("return [lwrExplorer.equation, lwrExplorer.gains]") == [None, None]
