"""All checks on one arm, in order: kinematics, feasibility, laws, agreement, energy."""

from __future__ import annotations

from lwr_dyn.checks.agreement import frames_agree, roads_agree, tabulated_frames
from lwr_dyn.checks.envelope import datasheet_verdicts
from lwr_dyn.checks.feasibility import feasibility_verdicts
from lwr_dyn.checks.laws import gravity_law, mass_matrix_laws, velocity_laws
from lwr_dyn.checks.states import States, random_states
from lwr_dyn.checks.swing import swing_verdict
from lwr_dyn.checks.verdict import Report
from lwr_dyn.dynamics.gate import Gated
from lwr_dyn.dynamics.newton_euler import Recursion, newton_euler_dynamics
from lwr_dyn.dynamics.pinocchio_engine import flange_poses, pinocchio_dynamics
from lwr_dyn.model.arm import Arm
from lwr_dyn.papers.schema import Paper

STATES = 1000
SEED = 20240607


def check_arm(arm: Arm, paper: Paper | None = None, states: int = STATES, seed: int = SEED) -> Report:
    """Every law and agreement that the arm's data allow.

    Parameters
    ----------
    arm : Arm
    paper : Paper, optional
        Adds the comparison with the paper's own second statement of its frames.
    states : int
        Random states inside the limits.
    seed : int
    """
    x = random_states(arm, states, seed)
    verdicts = [frames_agree(arm, flange_poses(arm, x.q), x)]
    verdicts += [] if paper is None else [*tabulated_frames(paper), *datasheet_verdicts(arm, paper)]
    if arm.chain.bodies is None:
        notes = ("masses and inertias are not given: no dynamics to check",)
        return Report(arm.name, arm.reading, tuple(verdicts), notes)
    road_a, road_b = pinocchio_dynamics(arm), newton_euler_dynamics(arm.chain)
    verdicts += feasibility_verdicts(arm)
    verdicts += mass_matrix_laws(road_a, x)
    verdicts += velocity_laws(road_a, road_b.ungated, x)
    verdicts.append(gravity_law(road_a, road_b.ungated, x))
    verdicts += roads_agree(road_a, road_b, x)
    verdicts.append(swing_verdict(road_a, x.q[0], 0.5 * x.dq[0]))
    return Report(arm.name, arm.reading, tuple(verdicts), _notes(arm, road_b, x))


def _notes(arm: Arm, road_b: Gated[Recursion], x: States) -> tuple[str, ...]:
    if all(link.rotor is None for link in arm.chain.links):
        return ("no rotor inertia is given",)
    if all(link.rotor is None or link.rotor.reflected for link in arm.chain.links):
        return ("rotor inertia is given at the joints, without gear ratios: no spin couplings to compute",)
    full = newton_euler_dynamics(arm.chain, rotors="full")
    more = abs(full.inverse_dynamics(x.q, x.dq, x.ddq) - road_b.inverse_dynamics(x.q, x.dq, x.ddq)).max()
    return (f"rotors' spin couplings, which engines drop: at most {more:.2g} N m over these states",)
