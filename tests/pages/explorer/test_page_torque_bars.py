"""The card of torques on an arm with a tool: payload by its fields, bars against the motors' limits, B, C and g."""

import re

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.model.arm import arm_with_payload
from tests.pages.explorer.explored import explored_arm, opened

pytestmark = pytest.mark.slow

Q = np.array([0.3, 0.7, 0.2, -1.2, 0.3, 0.9, 0.1])
DQ, DDQ = np.linspace(-1.0, 1.0, 7), np.linspace(2.0, -1.0, 7)
AGREES = 1e-9
"""[N m] at positions that the page keeps to 1e-9 deg; ten times that with 60 kg."""
LOAD = """const fields = [...document.querySelectorAll(".payload input")];
arguments[0].forEach((text, k) => { fields[k].value = text; });
fields[0].dispatchEvent(new Event("change"));
lwrExplorer.state.compute();
return document.querySelector(".payload .note").textContent;"""
SHOWN = """const { tau, parts, B } = lwrExplorer.torques;
const rows = [...document.querySelectorAll("[aria-label='Torques'] tbody tr")];
const bars = (row) => ["g", "c", "b"].map((part) => row.querySelector(`path.${part}`).getAttribute("d"));
const text = (row) => Number(row.querySelector(".tau").textContent);
return [[...tau], [...parts], [...B], rows.map(bars), rows.map((row) => row.className === "over"), rows.map(text)];"""


@pytest.fixture(scope="module")
def window(browser, page_of):
    window = opened(browser, page_of("hung").as_uri())
    window.execute_script("lwrExplorer.setPose(arguments[0])", Q.tolist())
    window.execute_script("lwrExplorer.state.set({dq: arguments[0], ddq: arguments[1]})", DQ.tolist(), DDQ.tolist())
    return window


@pytest.mark.parametrize("load", [(0.0, 0.0, 0.0, 0.0), (2.5, 0.05, -0.02, 0.1), (60.0, 0.0, 0.3, 0.0)])
def test_bars_carry_the_payload_beside_the_tool(window, load):
    arm, within = explored_arm("hung"), AGREES * (10 if load[0] == 60.0 else 1)
    assert window.execute_script(LOAD, list(map(str, load))) == ""
    dynamics = lwr_dyn.dynamics_of(arm_with_payload(arm, load[0], load[1:]))
    tau, parts, B, bars, over, texts = window.execute_script(SHOWN)
    expected = dynamics.inverse_dynamics(Q, DQ, DDQ)
    np.testing.assert_allclose(tau, expected, rtol=0, atol=within)
    np.testing.assert_allclose(np.reshape(B, (7, 7)), dynamics.mass_matrix(Q), rtol=0, atol=within)
    C, g = dynamics.coriolis_matrix(Q, DQ), dynamics.gravity_vector(Q)
    meant = np.column_stack([g, C @ DQ, dynamics.mass_matrix(Q) @ DDQ])
    np.testing.assert_allclose(np.reshape(parts, (7, 3)), meant, rtol=0, atol=within)
    np.testing.assert_allclose(texts, expected, rtol=0, atol=0.00501)
    limits = np.array([joint.limits.effort for joint in arm.joints()])
    assert over == (np.abs(expected) > limits).tolist()
    assert any(over) == (load[0] == 60.0)
    for i, row in enumerate(bars):
        for way in (-1, 1):  # the bars of one sign follow each other from the middle, to the limit at most
            ends = [float(number) for d in row for number in re.findall(r"[MH](-?\d+)", d) if way * float(number) > 0]
            reach = 1000 * np.maximum(way * meant[i] / limits[i], 0).sum()
            assert max([0, *np.abs(ends)]) == pytest.approx(min(reach, 1000), abs=2)
    for name, values in (("B", dynamics.mass_matrix(Q)), ("C", C), ("g", g)):
        written = window.execute_script(
            """const { matrices, state } = lwrExplorer; matrices.choose(arguments[0]); matrices.write(state);
            return [...matrices.table.querySelectorAll("td")].map((cell) => Number(cell.textContent))""",
            name,
        )
        np.testing.assert_allclose(written, np.ravel(values), rtol=0, atol=0.000501)


def test_what_is_no_number_is_said_and_leaves_a_speed_as_it_was(window):
    script = """const [text] = arguments, field = document.querySelector("[data-of=dq]"), { state } = lwrExplorer;
        field.value = text; field.dispatchEvent(new Event("change"));
        return [state.dq[0], field.value, document.querySelector("[aria-label='Torques'] > .note").textContent]"""
    assert window.execute_script(script, " 0,25") == [0.25, "0.25", ""]
    for text in ("fast", "", "1/0", "1e999"):
        assert window.execute_script(script, text) == [0.25, "0.25", f"“{text}” is no number: 0.25 stays."]
    assert window.execute_script(script, "0") == [0, "0", ""]
