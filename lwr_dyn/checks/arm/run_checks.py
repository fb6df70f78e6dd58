"""All checks of one arm and their report: frames, feasibility, identities, the two roads, energy, data sheet.

Road A is the URDF in Pinocchio, road B the recursion on the paper's own DH frames.
"""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.arms.papers.assembly import dh_rows
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.checks.arm import model_laws
from lwr_dyn.checks.arm.model_laws import EXACT, States, Verdict, equality, relative, verdict_table
from lwr_dyn.checks.datasheet.datasheet import datasheet_verdicts
from lwr_dyn.dynamics.newton_euler import Recursion, newton_euler_dynamics
from lwr_dyn.dynamics.pinocchio_engine import flange_poses, pinocchio_dynamics, pinocchio_model
from lwr_dyn.dynamics.protocol import Dynamics, Gated, singular_joint
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.document import Document, Note, Section
from lwr_dyn.foundation.errors import SingularMassError
from lwr_dyn.foundation.tables import Table
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Convention
from lwr_dyn.model.run import repr_html, short_repr

STATES = 1000
SEED = 20240607
METRES = 1e-12
"""Poses [m and entries of R] of an arm of about a metre, each of whose products rounds at 1e-16; times the largest
position of the flange where that is more."""


@dataclass(frozen=True, slots=True)
class CheckReport:
    """All verdicts on an arm, and notes on what could not be checked and why."""

    robot: str
    reading: str
    verdicts: tuple[Verdict, ...]
    notes: tuple[str, ...] = ()
    not_judged: tuple[str, ...] = ()
    """What no verdict is about, and why."""
    __repr__ = short_repr
    _repr_html_ = repr_html

    @property
    def holds(self) -> bool:
        """Every verdict holds."""
        return all(v.holds for v in self.verdicts)

    def summary(self) -> str:
        """How many checks hold or fail, and how many things were not judged."""
        failed, every = sum(not v.holds for v in self.verdicts), len(self.verdicts)
        found = f"{failed} of {every} checks fail{'s' * (failed == 1)}" if failed else f"all {every} checks hold"
        found = "1 check holds" if (failed, every) == (0, 1) else found
        return found + (f", {len(self.not_judged)} not judged" if self.not_judged else "")

    def table(self) -> Table:
        """The verdicts under the robot's name."""
        return verdict_table(f"{self.robot}, reading {self.reading}", self.verdicts)

    @property
    def document(self) -> Document:
        """How many checks hold, and those that fail first."""
        title = f"{self.robot}, reading {self.reading}: {self.summary()}"
        verdicts = sorted(self.verdicts, key=lambda verdict: verdict.holds)
        left = Note([f"not judged: {one}" for one in self.not_judged])
        return Document(title, "", [Section("", [verdict_table("", verdicts), left], brief=True)], kind="checks")


def check_arm(arm: Arm, paper: Paper | None = None, states: int = STATES, seed: int = SEED) -> CheckReport:
    """All checks that the arm's data allow, over random states inside its limits.

    A paper adds the checks against its tabulated frames and its data sheet.
    """
    x = model_laws.random_states(arm, states, seed)
    road_a = None if arm.chain.bodies is None else pinocchio_dynamics(arm)
    model = pinocchio_model(arm) if road_a is None else road_a.ungated.model
    verdicts = [frames_agree(arm, flange_poses(model, x.q), x)]
    notes = [model_laws.box_note(arm)]
    if paper is not None:
        verdicts += tabulated_frames(paper)
        verdicts += datasheet_verdicts(arm, paper)
    verdicts += model_laws.feasibility_verdicts(arm)
    verdicts += model_laws.fit_verdicts(arm)
    left = model_laws.not_judged(arm)
    if arm.file and arm.layout is not None:
        from lwr_dyn.checks.engines.pinocchio_loader import file_verdicts  # not for a robot from a table

        found, unjudged = file_verdicts(arm)
        verdicts, left = verdicts + found, left + unjudged
    if road_a is None:
        missing = model_laws.missing_mass(arm)
        verdicts, left = verdicts + missing, left + ["B, C, g, forward dynamics and free swing"] * bool(missing)
    else:
        road_b = newton_euler_dynamics(arm.chain)
        verdicts += model_laws.mass_matrix_identities(road_a, x)
        verdicts += model_laws.velocity_identities(road_a, road_b.ungated, x)
        verdicts.append(model_laws.gravity_identity(road_a, road_b.ungated, x))
        verdicts += roads_agree(road_a, road_b, x)
        joint = singular_joint(road_a.mass_matrix(x.q))
        if joint is None:
            verdicts.append(forward_agrees(road_a, road_b, x))
            verdicts.append(model_laws.swing_verdict(road_a, x.q[0], 0.5 * x.dq[0]))
        else:
            moved = f"{arm.joint_names[joint]} moves {arm.chain.links[joint].link} and what is beyond it"
            left.append(f"forward dynamics and free swing: B has no inverse; {moved} without inertia")
        notes.append(_rotor_note(arm, road_b, x))
    notes = [note for note in (*arm.notes, *notes, *model_laws.at_rest(arm)) if note]
    return CheckReport(arm.name, arm.reading, tuple(verdicts), tuple(notes), tuple(left))


def roads_agree(road_a: Dynamics, road_b: Gated[Recursion], states: States) -> list[Verdict]:
    """B, C, g and inverse dynamics of both roads over the same states."""
    q, dq, ddq, recursion = states.q, states.dq, states.ddq, road_b.ungated
    of_C, of_torque = model_laws.coriolis_floor(recursion, states), model_laws.torque_floor(recursion, states)
    roads = "Pinocchio against our own recursion"
    accelerated = road_a.inverse_dynamics(q, dq, ddq), road_b.inverse_dynamics(q, dq, ddq)
    return [
        equality(f"mass matrix: {roads}", road_a.mass_matrix(q), road_b.mass_matrix(q)),
        equality(f"Coriolis matrix: {roads}", road_a.coriolis_matrix(q, dq), road_b.coriolis_matrix(q, dq), of_C),
        equality(f"gravity torque: {roads}", road_a.gravity_vector(q), road_b.gravity_vector(q), of_torque),
        equality(f"inverse dynamics: {roads}", *accelerated),
    ]


def forward_agrees(road_a: Dynamics, road_b: Gated[Recursion], states: States) -> Verdict:
    """Road B's torque of road A's accelerations is the torque that these were computed from."""
    q, dq = states.q, states.dq
    tau = road_b.inverse_dynamics(q, dq, states.ddq)
    try:
        residual = relative(road_b.inverse_dynamics(q, dq, road_a.forward_dynamics(q, dq, tau)), tau)
    except SingularMassError:
        residual = float("nan")
    return Verdict("forward dynamics: our own recursion of Pinocchio's ddq", residual, EXACT, "relative")


def frames_agree(arm: Arm, urdf_flange: Array, states: States) -> Verdict:
    """Flange pose through the URDF frames against the product of the native matrices."""
    native = flange_pose(arm.chain, states.q)
    size = max(1.0, float(np.abs(native).max()))
    return Verdict("flange: URDF against DH table", float(np.abs(urdf_flange - native).max()), METRES * size, "m")


def tabulated_frames(paper: Paper) -> list[Verdict]:
    """r_{i-1,i} as a paper tabulates it against its DH rows: (a, d sin alpha, d cos alpha) in frame i."""
    if "frames.origin" not in paper.columns or paper.convention is not Convention.STANDARD:
        return []
    rows = dh_rows(paper)
    origins = np.array(
        [after.rotation.T @ after.position for _, after in (r.fixed_poses(paper.convention) for r in rows)]
    )
    deviation = float(np.abs(origins - paper.columns["frames.origin"].si()).max())
    return [Verdict("vectors between frames: as tabulated against DH table", deviation, METRES, "m")]


def _rotor_note(arm: Arm, road_b: Gated[Recursion], x: States) -> str:
    if all(link.rotor is None for link in arm.chain.links):
        return "no rotor inertia is given"
    if all(link.rotor is None or link.rotor.reflected for link in arm.chain.links):
        return "rotor inertia is given at the joints, without gear ratios: no spin couplings to compute"
    full = newton_euler_dynamics(arm.chain, rotors="full")
    more = abs(full.inverse_dynamics(x.q, x.dq, x.ddq) - road_b.inverse_dynamics(x.q, x.dq, x.ddq)).max()
    return f"rotors' spin couplings, which engines drop: at most {more:.2g} N m over these states"
