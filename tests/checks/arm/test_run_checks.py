"""Planted faults, which `check_arm` must catch every one, and what a report says of its verdicts."""

import inspect
import types

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.urdf.writer import urdf_text
from lwr_dyn.checks.arm import run_checks
from lwr_dyn.checks.arm.model_laws import Verdict
from lwr_dyn.checks.arm.run_checks import CheckReport
from lwr_dyn.dynamics import newton_euler, pinocchio_engine, recursion
from lwr_dyn.model.arm import Arm

STATES = 20

RECURSION_FAULTS = {
    "gravity upside down": ("omega, domega, ddp = ZERO, ZERO, -gravity", "omega, domega, ddp = ZERO, ZERO, gravity"),
    "rotation not transposed": ("omega = R.T @ (carrier + Z.times(dq[i]))", "omega = R @ (carrier + Z.times(dq[i]))"),
    "no joint acceleration": ("Z.times(ddq[i]) + carrier", "carrier"),
    "gyroscopic joint term lost": (" + carrier.times(dq[i]).cross(Z))", ")"),
    "gyroscopic joint term reversed": ("carrier.times(dq[i]).cross(Z)", "Z.cross(carrier.times(dq[i]))"),
    "centrifugal term lost": ("domega.cross(r) + omega.cross(omega.cross(r))", "domega.cross(r)"),
    "centrifugal term reversed": ("+ omega.cross(omega.cross(r))", "- omega.cross(omega.cross(r))"),
    "centre of mass forgotten in acceleration": ("ddp + lever_acceleration(omega, domega, link.com)", "ddp"),
    "lever arm without r": ("- f.cross(m.r + link.com)", "- f.cross(link.com)"),
    "lever arm reversed": ("- f.cross(m.r + link.com)", "+ f.cross(m.r + link.com)"),
    "child force without lever": ("            + f_next.cross(link.com)\n", ""),
    "I omega printed for I domega": ("+ link.inertia @ m.domega\n", "+ link.inertia @ m.omega\n"),
    "gyroscopic moment lost": ("            + m.omega.cross(link.inertia @ m.omega)\n", ""),
    "gyroscopic moment reversed": (
        "+ m.omega.cross(link.inertia @ m.omega)",
        "- m.omega.cross(link.inertia @ m.omega)",
    ),
    "moment not carried to the parent": ("f, mu = m.R @ f, m.R @ mu", "f, mu = m.R @ f, mu"),
    "armature lost": ('if rotors == "armature" or', 'if rotors == "" or'),
    "armature with k_r instead of its square": ("multiply(kr * kr, Im)", "multiply(kr, Im)"),
    "rotor of the wrong joint": ("links[i], states[i]", "links[max(i - 1, 0)], states[i]"),
    "potential energy reversed": ("multiply(-link.mass, gravity.dot", "multiply(link.mass, gravity.dot"),
    "origin vector in the parent's axes": ("r = link.turn.T @ link.shift", "r = link.shift"),
}


def mutated(module: types.ModuleType, old: str, new: str) -> types.ModuleType:
    """The module with one piece of its text exchanged."""
    source = inspect.getsource(module)
    assert source.count(old) >= 1, f"the fault {old!r} is not in the source any more"
    twin = types.ModuleType(module.__name__)
    exec(compile(source.replace(old, new), module.__file__, "exec"), twin.__dict__)
    return twin


@pytest.mark.parametrize("name", RECURSION_FAULTS)
def test_a_fault_in_the_recursion_is_caught(monkeypatch, name):
    twin = mutated(recursion, *RECURSION_FAULTS[name])
    monkeypatch.setattr(newton_euler, "inverse_dynamics", twin.inverse_dynamics)
    monkeypatch.setattr(newton_euler, "potential_energy", twin.potential_energy)
    assert not run_checks.check_arm(lwr_dyn.load("lwr4plus", "physical"), states=STATES).holds


LINK_2 = '<link name="link_2">'
"""Faults are planted from link 2 on: link 1 turns about the vertical, its products and the place of its mass along the
axis never enter a torque, so no check of the dynamics can see them (the sidecar's test does)."""


def swap_first(text: str, old: str, new: str) -> str:
    head, tail = text.split(LINK_2)
    assert old in tail, old
    return head + LINK_2 + tail.replace(old, new, 1)


def swap_attributes(text: str, tag: str, first: str, second: str) -> str:
    """Exchange two attributes' values in the first element of that name."""
    start = text.index(f"<{tag} ", text.index(LINK_2))
    end = text.index("/>", start)
    element = text[start:end]
    marked = element.replace(f"{first}=", "@=").replace(f"{second}=", f"{first}=").replace("@=", f"{second}=")
    return text[:start] + marked + text[end:]


URDF_FAULTS = {
    "product flipped": lambda t: swap_first(t, 'iyz="', 'iyz="-'),
    "moments swapped": lambda t: swap_attributes(t, "inertia", "iyy", "izz"),
    "products swapped": lambda t: swap_attributes(t, "inertia", "ixy", "iyz"),
    "centre of mass moved by a millimetre": lambda t: swap_first(t, ' 0.02714915" rpy', ' 0.02814915" rpy'),
    "centre of mass mirrored": lambda t: swap_first(t, ' 0.02714915" rpy', ' -0.02714915" rpy'),
    "mass of link 7 rounded": lambda t: swap_first(t, '<mass value="0.2373"/>', '<mass value="0.237"/>'),
    "joint axis reversed": lambda t: swap_first(t, '<axis xyz="0.0 0.0 1.0"/>', '<axis xyz="0.0 0.0 -1.0"/>'),
    "joint axis swapped": lambda t: swap_first(t, '<axis xyz="0.0 0.0 1.0"/>', '<axis xyz="0.0 1.0 0.0"/>'),
    "twist reversed": lambda t: swap_first(t, 'rpy="1.5707963267948966 0.0 0.0"', 'rpy="-1.5707963267948966 0.0 0.0"'),
    "twist rounded to 1.5708": lambda t: swap_first(t, 'rpy="1.5707963267948966 0.0 0.0"', 'rpy="1.5708 0.0 0.0"'),
    "upper arm in the wrong direction": lambda t: swap_first(t, 'xyz="0.0 0.0 0.4"', 'xyz="0.0 0.0 -0.4"'),
    "flange forgotten": lambda t: swap_first(t, "0.0 0.0 0.078", "0.0 0.0 0.0"),
}


@pytest.mark.parametrize("name", URDF_FAULTS)
def test_a_fault_in_the_urdf_is_caught(monkeypatch, name):
    arm = lwr_dyn.load("lwr4plus", "physical")
    text = URDF_FAULTS[name](urdf_text(arm))
    assert text != urdf_text(arm)
    monkeypatch.setattr(pinocchio_engine, "urdf_text", lambda _: text)
    assert not run_checks.check_arm(arm, states=STATES).holds


@pytest.mark.slow
@pytest.mark.parametrize("joint", range(7))
def test_a_lost_rotor_is_caught(monkeypatch, joint):
    arm = lwr_dyn.load("lwr4plus")
    lost = arm.armature
    lost[joint] = 0.0
    monkeypatch.setattr(Arm, "armature", property(lambda self: lost))
    assert not run_checks.check_arm(arm, states=STATES).holds


def test_a_rotor_that_turns_the_other_way_round_in_the_full_model_is_seen():
    twin = mutated(recursion, "omega_carrier.times(spin).cross(Z)", "omega_carrier.times(spin).cross(-Z)")
    arm = lwr_dyn.load("lwr4plus", "physical")
    x = np.random.default_rng(0).uniform(-1, 1, (3, 7))
    links, gravity = recursion.link_constants(arm.chain), newton_euler.Vector.of(arm.chain.gravity)
    right = recursion.inverse_dynamics(links, gravity, *x, "full")
    # Z . (omega x Z) = 0: this term never reaches tau, which the paper's own projection shows
    assert np.allclose(twin.inverse_dynamics(links, gravity, *x, "full"), right, rtol=0, atol=1e-15)


LOW, EQUAL, HIGH = (Verdict(f"v{x:g}", x, 1.0, "N m") for x in (0.5, 1.0, 2.0))
ABOVE, HIGHER = (Verdict("smallest moment", x, 1.0, "", "above") for x in (1.0, 1.5))


@pytest.mark.parametrize(
    ("verdicts", "not_judged", "holds", "summary"),
    [
        ((LOW, EQUAL), (), True, "all 2 checks hold"),
        ((LOW, HIGH), ("limits: none",), False, "1 of 2 checks fails, 1 not judged"),
        ((LOW, HIGH, ABOVE), (), False, "2 of 3 checks fail"),
    ],
)
def test_a_report_counts(verdicts, not_judged, holds, summary):
    """At most includes the tolerance, and above does not."""
    assert [v.holds for v in (LOW, EQUAL, HIGH, ABOVE, HIGHER)] == [True, True, False, False, True]
    report = CheckReport("arm", "printed", verdicts, not_judged=not_judged)
    assert (report.holds, report.summary()) == (holds, summary)
    assert report.document.title == f"arm, reading printed: {summary}"


def test_the_table_of_a_page_has_what_fails_first():
    report = CheckReport("arm", "printed", (LOW, HIGH, EQUAL), not_judged=("limits",))
    table, left = report.document.sections[0].parts
    assert [row[0] for row in table.cells] == ["v2", "v0.5", "v1"]
    assert left.lines == ("not judged: limits",)
    assert report.table().text().splitlines()[0] == "arm, reading printed"
    assert report.table().cells[1] == ("v2", "2", "at most", "1", "N m", "FAILS")
