"""The explorer by hand: emulated touches on sliders, strip and fields, and every control by the keyboard alone."""

import numpy as np
import pytest

from tests.axe import seen
from tests.pages.explorer.by_hand import press, touch
from tests.pages.explorer.explored import opened

pytestmark = pytest.mark.slow

PHONE = (390, 844)
Q = [0.3, 0.7, 0.2, -1.2, 0.3, 0.9, 0.1]
MOVE = "lwrExplorer.setPose(arguments[0]); lwrExplorer.state.compute();"
BOX = """const part = document.querySelector(arguments[0]);
part.scrollIntoView({ block: arguments[1] ?? "center", behavior: "instant" });
const { left, top, width, height } = part.getBoundingClientRect();
return [left, top, width, height];"""
FOCUSED = """const at = document.activeElement, box = at.getBoundingClientRect();
const inside = (middle, end) => Math.min(Math.max(middle, 20), end - 20); // of a wide one an end is seen
const x = inside(box.left + box.width / 2, innerWidth), y = inside(box.top + box.height / 2, innerHeight);
const over = document.elementFromPoint(x, y), pop = at.closest("[popover]");
if (!at.dataset.counted) at.dataset.counted = document.querySelectorAll("[data-counted]").length + 1;
const mark = at === document.body ? "" : at.dataset.counted;
return [mark, Boolean(over && (at.contains(over) || over.contains(at))), at.outerHTML.slice(0, 90)];"""
REACHABLE = """const shown = (node) => node.checkVisibility({ checkVisibilityCSS: true }) && !node.closest("[popover]");
const all = [...document.querySelectorAll("a[href], button, input, select, summary, [tabindex]")];
return all.filter((node) => node.tabIndex >= 0 && !node.disabled && shown(node)).length;"""


@pytest.fixture(scope="module")
def phone(browser, page_of):
    with seen(browser, PHONE[0], height=PHONE[1]):
        browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
        yield opened(browser, page_of("lwr4plus computed").as_uri())
        browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": False})


def positions(window):
    return np.array(window.execute_script("return lwrExplorer.positions()"))


def test_a_finger_moves_a_slider(phone):
    phone.execute_script(MOVE, Q)
    left, top, width, height = phone.execute_script(BOX, "#slider_2")
    y = top + height / 2
    touch(phone, *((left + part * width, y) for part in (0.66, 0.7, 0.75, 0.8)))
    moved = positions(phone) - Q
    assert moved[1] > 0.1
    np.testing.assert_allclose(np.delete(moved, 1), 0, atol=1e-9)


def test_a_finger_on_the_strip_turns_the_elbow_and_the_flange_stays(phone):
    phone.execute_script(MOVE, Q)
    row, before = phone.execute_script("return [lwrExplorer.strip.branch, lwrExplorer.flangePose()]")
    left, top, width, height = phone.execute_script(BOX, f".branch:nth-of-type({row + 2}) svg")
    y = top + height / 2
    touch(phone, *((left + part * width, y) for part in (0.5, 0.55, 0.6)))
    phone.execute_script("lwrExplorer.state.compute()")
    psi, after = phone.execute_script("return [lwrExplorer.strip.psi, lwrExplorer.flangePose()]")
    assert psi == pytest.approx(0.2 * np.pi, abs=0.03)
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-9)


def test_a_tap_chooses_a_branch_a_field_and_a_matrix(phone):
    phone.execute_script(MOVE, Q)
    branch = phone.execute_script(
        """const { branch, psi, ends, counts } = lwrExplorer.strip, free = (b) => Array.from(counts).some((_, k) =>
          k < counts[b] && ends[32 * b + 2 * k] < psi && psi < ends[32 * b + 2 * k + 1]);
        return [0, 1, 2, 3, 4, 5, 6, 7].find((b) => b !== branch && free(b))"""
    )
    for name in (f".branch:nth-of-type({branch + 2}) button", "[aria-label='Matrices'] button:nth-child(2)"):
        left, top, width, height = phone.execute_script(BOX, name)
        touch(phone, (left + width / 2, top + height / 2))
    phone.execute_async_script("setTimeout(arguments[0], 100)")
    phone.execute_script("lwrExplorer.state.compute()")
    assert phone.execute_script("return lwrExplorer.strip.branch") == branch
    assert (
        phone.execute_script("return document.querySelector('[aria-label=\"Matrices\"] table').dataset.matrix") == "C"
    )
    left, top, width, height = phone.execute_script(BOX, ".payload input")
    touch(phone, (left + width / 2, top + height / 2))
    phone.execute_async_script("setTimeout(arguments[0], 100)")
    assert phone.execute_script("return document.activeElement.getAttribute('aria-label')") == "payload, kg"


def test_a_finger_scrolls_the_page_from_a_strip_and_from_a_panel(phone):
    phone.execute_script(MOVE, Q)
    for name in (".branch:nth-of-type(4) svg", "[aria-label='Torques'] h2"):
        left, top, width, height = phone.execute_script(BOX, name, "end")
        before = phone.execute_script("return scrollY")
        x, y = left + 0.3 * width, top + height / 2
        touch(phone, *((x, y - 12 * k) for k in range(9)))
        phone.execute_async_script("setTimeout(arguments[0], 100)")
        assert phone.execute_script("return scrollY") > before + 40


def test_arrow_keys_walk_the_strip_over_its_gaps_and_change_the_branch(phone):
    phone.execute_script(f"{MOVE} document.getElementById('arm-angle').focus()", Q)
    psi, branch = phone.execute_script("return [lwrExplorer.strip.psi, lwrExplorer.strip.branch]")
    for key, shift, step in (("ArrowRight", False, 1.0), ("ArrowLeft", True, -0.1)):
        press(phone, key, shift)
        phone.execute_script("lwrExplorer.state.compute()")
        now = phone.execute_script("return lwrExplorer.strip.psi")
        assert np.degrees(now - psi) == pytest.approx(step, abs=1e-6)
        psi = now
    flange = phone.execute_script("return lwrExplorer.flangePose()")
    angles, free = phone.execute_script(
        """const { strip, state } = lwrExplorer, angles = [];
        for (let k = 0; k < 400; k += 1) { strip.step(1, Math.PI / 180); state.compute(); angles.push(strip.psi); }
        const b = strip.branch; return [angles, [...strip.ends.slice(32 * b, 32 * b + 2 * strip.counts[b])]]"""
    )
    steps = np.degrees(np.diff(np.unwrap(angles)))
    assert (steps > 0).all()  # all the way round
    assert sum(np.degrees(np.diff(np.unwrap(angles)))) > 360
    gaps = np.degrees(np.subtract(free[2::2], free[1:-1:2]))
    assert any(gap > 1 for gap in gaps)
    assert steps.max() == pytest.approx(max([*gaps, 360 - np.degrees(free[-1] - free[0])]), abs=1e-3)
    np.testing.assert_allclose(phone.execute_script("return lwrExplorer.flangePose()"), flange, rtol=0, atol=1e-8)
    press(phone, "ArrowDown")
    phone.execute_script("lwrExplorer.state.compute()")
    assert phone.execute_script("return lwrExplorer.strip.branch") != branch


def test_tab_reaches_every_control_and_none_is_hidden_behind_the_picture(phone):
    phone.execute_script("document.activeElement.blur(); window.scrollTo(0, 0)")
    expected = phone.execute_script(REACHABLE)
    found, hidden = set(), []
    for _ in range(expected + 20):
        press(phone, "Tab", shift=True)
        mark, is_seen, text = phone.execute_script(FOCUSED)
        if mark and mark in found:
            break
        found.add(mark)
        if mark and not is_seen:
            hidden.append(text)
    assert hidden == []
    assert len(found - {""}) >= expected
