"""Every verdict can fail on its own: one fault each, and the name of the verdict that must see it."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.checks.arm import model_laws, run_checks
from lwr_dyn.checks.arm.run_checks import tabulated_frames
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics

SMALL = 1e-6
"""A relative fault far above 1e-12 and far below what a person would see in a plot."""
ROADS = "Pinocchio against our own recursion"
NAMES = [
    "flange: URDF against DH table", "vectors between frames: as tabulated against DH table", "mass matrix: symmetric",
    "mass matrix: smallest eigenvalue", "mass matrix: columns against unit accelerations",
    "power balance: dB/dt = C + C^T", "bias torque: C dq + g", "gravity torque: g = dU/dq", f"mass matrix: {ROADS}",
    f"Coriolis matrix: {ROADS}", f"gravity torque: {ROADS}", f"inverse dynamics: {ROADS}",
    "forward dynamics: our own recursion of Pinocchio's ddq", "energy drift of a free swing, 2 s",
]  # fmt: skip


class Faulty:
    """Road B with one of its answers changed."""

    def __init__(self, chain, **changes):
        self.right, self.changes = newton_euler_dynamics(chain), changes
        self.n = chain.n

    def __getattr__(self, name):
        method = getattr(self.right, name)
        return (lambda *x: self.changes[name](method(*x))) if name in self.changes else method


@pytest.fixture(scope="module")
def arm():
    return lwr_dyn.load("lwr4plus", "computed")


@pytest.fixture(scope="module")
def states(arm):
    return model_laws.random_states(arm, 20, seed=4)


def failing(verdicts):
    return [v.name for v in verdicts if not v.holds]


def test_the_report_has_every_law(arm):
    result = [v.name for v in run_checks.check_arm(arm, open_paper("lwr4plus"), states=5).verdicts]
    assert [name for name in result if not name.startswith("link_")] == NAMES
    assert len(result) == len(NAMES) + 3 * 7


CHANGED = {
    "mass_matrix": (lambda B: B + SMALL * np.eye(7, k=1), {"mass matrix: symmetric",
                                                            "mass matrix: columns against unit accelerations"}),
    "coriolis_matrix": (lambda C: C * (1 + SMALL), {"bias torque: C dq + g", "power balance: dB/dt = C + C^T"}),
    "bias_torque": (lambda h: h * (1 + SMALL), {"bias torque: C dq + g"}),
    "gravity_vector": (lambda g: g + SMALL, {"bias torque: C dq + g", "gravity torque: g = dU/dq"}),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGED)
def test_each_law_sees_a_relative_fault_of_a_millionth(arm, states, name):
    change, laws = CHANGED[name]
    wrong, ungated = Faulty(arm.chain, **{name: change}), newton_euler_dynamics(arm.chain).ungated
    verdicts = [
        *model_laws.velocity_identities(wrong, ungated, states),
        model_laws.gravity_identity(wrong, ungated, states),
    ]
    verdicts += model_laws.mass_matrix_identities(wrong, states) if name in ("mass_matrix",) else []
    assert set(failing(verdicts)) == laws
    negative = Faulty(arm.chain, mass_matrix=lambda B: B - 0.01 * np.eye(7))
    assert "mass matrix: smallest eigenvalue" in failing(model_laws.mass_matrix_identities(negative, states))


@pytest.mark.slow
def test_energy_drift_sees_a_brake(arm):
    brake = Faulty(arm.chain, forward_dynamics=lambda ddq: ddq * (1 - 1e-3))
    q, dq = np.full(7, 0.3), np.full(7, 0.2)
    braked, free = (model_laws.swing_verdict(x, q, dq, seconds=0.2) for x in (brake, newton_euler_dynamics(arm.chain)))
    assert braked.value > 1e-6 > free.value


def test_tabulated_frames_see_the_rows_as_printed():
    paper = open_paper("lwr4plus")
    origin = paper.columns["frames.origin"]
    rows = list(origin.values)
    rows[1], rows[2] = rows[2], rows[1]
    shifted = replace(paper, columns=paper.columns | {"frames.origin": replace(origin, values=tuple(rows))})
    assert failing(tabulated_frames(shifted)) == ["vectors between frames: as tabulated against DH table"]
    assert failing(tabulated_frames(paper)) == []
