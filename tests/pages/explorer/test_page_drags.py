"""Random drags of the flange on the page: followed where the arm gets there, stopped at the wall where it does not."""

import numpy as np
import pytest

import lwr_dyn
from tests.pages.explorer.explored import explored_arm, opened

pytestmark = pytest.mark.slow

FOLLOWED = 1e-6
"""[m and rad] that the flange may be from where it is dragged."""
DRAGS = 200
HALF_TURN = np.pi
SCRIPT = """const [starts, moves] = arguments, e = lwrExplorer, drag = e.flangeDrag, { handle } = drag, out = [];
const past = (pose, from) => pose.map((x, k) => x + (k % 4 === 3 ? 1e-4 * (x - from[k]) : 0));
starts.forEach((q, i) => {
  e.setPose(q); e.state.compute(); drag.controls.setMode(i % 3 === 2 ? "rotate" : "translate"); drag.begin();
  const from = [...drag.from];
  moves[i].forEach(([x, y, z, a, b, c]) => {
    handle.position.set(from[3] + x, from[7] + y, from[11] + z);
    if (i % 3 === 2) handle.quaternion.multiply(new THREE.Quaternion().setFromEuler(new THREE.Euler(a, b, c)));
    const found = drag.moved();
    out.push([i, found, drag.word.textContent === "went to another branch", ...drag.pose, ...e.positions()]);
  });
  drag.end();
});
drag.controls.setMode("translate");
return out"""


@pytest.fixture(scope="module", params=["lwr4plus computed", "wam7 manual", "kr30ha kuka", "panda"])
def dragged(request, browser, page_of):
    """Of drags with four moves each: the arm, each move's start, verdict, asked pose, positions, drag, said to jump."""
    arm, window = explored_arm(request.param), opened(browser, page_of(request.param).as_uri())
    rng, drags = np.random.default_rng(30), DRAGS if request.param != "panda" else 40
    low, up = np.maximum(arm.lower, -HALF_TURN), np.minimum(arm.upper, HALF_TURN)
    starts = rng.uniform(low, up, (drags, arm.n))
    some = starts[::10]  # with some joints at their limits
    starts[::10] = np.where(rng.random((len(some), arm.n)) < 0.3, up, some)
    reach = np.linalg.norm(lwr_dyn.forward_kinematics(arm, starts)[:, :3, 3], axis=1).max()
    size = reach * rng.choice([0.01, 0.1, 0.4, 3.0], (drags, 1, 1))
    moves = np.concatenate([size * rng.normal(size=(drags, 4, 3)), 0.3 * rng.normal(size=(drags, 4, 3))], axis=2)
    rows = np.array(window.execute_script(SCRIPT, starts.tolist(), moves.tolist()), dtype=float)
    drag, found, said = rows[:, :3].astype(int).T
    return arm, starts[drag], found, rows[:, 3:19].reshape(-1, 4, 4), rows[:, 19:], drag, said


def away(arm, q, asked):
    """How far the flange at q is from the asked poses: metres, and the largest difference of the rotations."""
    reached = lwr_dyn.forward_kinematics(arm, q)
    return np.linalg.norm((reached - asked)[:, :3, 3], axis=1), np.abs((reached - asked)[:, :3, :3]).max(axis=(1, 2))


def test_the_flange_is_where_it_is_dragged_and_no_joint_beyond_its_limit(dragged):
    arm, _, found, asked, q, *_ = dragged
    followed = found < 2
    assert 0.2 < followed.mean() < 0.95
    metres, turned = away(arm, q[followed], asked[followed])
    assert metres.max() < FOLLOWED
    assert turned.max() < FOLLOWED
    assert ((arm.lower - 1e-9 <= q) & (q <= arm.upper + 1e-9)).all()


def test_beyond_a_wall_the_flange_is_on_the_way_there(dragged):
    arm, starts, found, asked, q, *_ = dragged
    walls = found >= 2
    begun = lwr_dyn.forward_kinematics(arm, starts[walls])[:, :3, 3]
    reached = lwr_dyn.forward_kinematics(arm, q[walls])[:, :3, 3]
    way = asked[walls][:, :3, 3] - begun
    share = np.einsum("ij,ij->i", reached - begun, way) / np.maximum(np.einsum("ij,ij->i", way, way), 1e-12)
    beside = reached - begun - share[:, None] * way
    assert np.linalg.norm(beside, axis=1).max() < FOLLOWED
    assert share.min() > -FOLLOWED
    assert share.max() <= 1 + FOLLOWED
    assert (share > 0.01).mean() > 0.5  # most went some of the way


def test_another_branch_is_said(dragged):
    _, starts, found, _, q, drag, said = dragged
    before = np.where((drag == np.roll(drag, 1))[:, None], np.roll(q, 1, axis=0), starts)
    before[0] = starts[0]
    jumped = (np.abs(q - before).max(axis=1) > 1) & (found == 0)
    assert (said == 1).tolist() == jumped.tolist()
