"""What holds for every arm, as verdicts: feasible links, and identities of the equations of motion over random states.

A link is feasible when its inertia is positive definite and obeys the triangle inequality (both exact: a density >= 0
exists), and when its radius of gyration stays within the link's reach (plausibility: a tensor ten times too large
passes the first two). The links of a URDF are judged as the file writes them: in the sum of welded links a fault can
vanish. Derivatives in the identities are complex steps of the hand-written recursion, so they are exact: no tolerance
hides the error of a difference quotient.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.protocol import Dynamics, mechanical_energy, singular_joint
from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import ShapeError, SingularMassError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import ROUNDING, Body, JointKind, is_physical
from lwr_dyn.model.file_layout import WrittenLink, fitting, welded
from lwr_dyn.model.spatial import Vector, principal_moments

Bound = Literal["at most", "above"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """One identity or agreement: `value` against `tolerance`, in `unit`."""

    name: str
    value: float
    tolerance: float
    unit: str
    bound: Bound = "at most"

    @property
    def holds(self) -> bool:
        """A value that is not a number never holds.

        >>> Verdict("x", float("nan"), 1.0, "").holds
        False
        """
        return self.value <= self.tolerance if self.bound == "at most" else self.value > self.tolerance


def verdict_table(title: str, verdicts: Iterable[Verdict]) -> Table:
    """Verdicts as a table.

    >>> print(verdict_table("arm", [Verdict("B symmetric", 2e-16, 1e-12, "relative")]).text())
    arm
    check        value  bound    tolerance  unit      verdict
    -----------  -----  -------  ---------  --------  -------
    B symmetric  2e-16  at most  1e-12      relative  holds
    """
    headings = (
        Heading("check", key="name"),
        Heading("value", "", ".3g", "value", "In `unit` where there is one."),
        Heading("bound", key="bound", says="What the tolerance is of the value.", kind=Bound),
        Heading("tolerance", "", ".3g", "tolerance", "What the value is held against."),
        Heading("unit", key="unit"),
        Heading("verdict", "", lambda holds: "holds" if holds else "FAILS", "holds", "Whether it holds."),
    )
    rows = [(v.name, v.value, v.bound, v.tolerance, v.unit, v.holds) for v in verdicts]
    return Table(title, headings, rows, "", "verdicts", "The checks.")


THICKNESS = 0.12
"""Share of the arm's reach that a link may extend past its joints and centre of mass: half the thickness of a heavy
link. LWR links are at 0.4 to 0.65 of the resulting bound, tensors ten times too large exceed it."""


def feasibility_verdicts(arm: Arm) -> list[Verdict]:
    """The verdicts on every link with an inertial, one by one."""
    joints, flange = arm.uninstalled().joints(), arm.flange()
    ends = [*(j.origin.position for j in joints[1:]), flange.position]
    total = sum(float(np.linalg.norm(p)) for p in (*(j.origin.position for j in joints), flange.position))
    verdicts: list[Verdict] = []
    for index, (body, end) in enumerate(zip(arm.bodies(), ends, strict=True)):
        bodies = [(x.link, x.body) for x in _written(arm, index, body) if x.body is not None and not x.body.unknown]
        heavy = [(name, part) for name, part in bodies if not part.is_weightless]
        points = [np.zeros(3), end, *(part.com for _, part in heavy)]
        for name, part in heavy:
            verdicts += _of_body(name, part, points, THICKNESS * total)
    return verdicts


def fit_verdicts(arm: Arm) -> list[Verdict]:
    """Of a fitted arm whose provenance says that its log contradicts its bodies: that it does. Else nothing.

    >>> import lwr_dyn
    >>> fit_verdicts(lwr_dyn.load("lwr4plus"))
    []
    """
    found = arm.caveats.contradicted
    return [Verdict(f"logs that contradict the fitted bodies: {found}", 1.0, 0.0, "logs")] if found else []


def _written(arm: Arm, index: int, body: Body | None) -> Sequence[WrittenLink]:
    """The links of the file that move with a link of the chain, in its URDF frame; the link itself where there are
    none, or where the arm's body is no longer theirs (a payload, another mass)."""
    own, layout = arm.chain.links[index], fitting(arm.layout, arm.uninstalled().chain)
    parts = layout.written.get(own.link, ()) if layout is not None else ()
    whole = welded(parts) if parts else None
    if (
        whole is None
        or own.body is None
        or not all(np.array_equal(getattr(whole, x), getattr(own.body, x)) for x in ("mass", "com", "inertia_com"))
    ):
        return (WrittenLink(own.link, body),)
    return [WrittenLink(x.link, None if x.body is None else x.body.seen_from(own.after)) for x in parts]


def _of_body(name: str, body: Body, points: Sequence[Array], thickness: float) -> Iterable[Verdict]:
    """The verdicts on one body: `points` are its joints and the centres of the links that are welded to it."""
    first, second, third = principal_moments(body.inertia_com).tolist()
    if body.mass <= 0.0:
        return [Verdict(f"{name}: mass of a link with a tensor", body.mass, 0.0, "kg", "above")]
    if not body.inertia_com.any():
        return [Verdict(f"{name}: largest principal moment of a link with mass", third, 0.0, "kg m^2", "above")]
    triangle = -(first + second - third) / max(abs(third), 1e-300)
    verdicts = [
        Verdict(f"{name}: smallest principal moment", first, 0.0, "kg m^2", "above"),
        Verdict(f"{name}: triangle inequality, I3 over I1 + I2, less 1", triangle, ROUNDING, "relative"),
    ]
    reach = max(float(np.linalg.norm(body.com - p)) for p in points) + thickness
    if reach > 0.0:
        gyration = float(np.sqrt(max(third, 0.0) / body.mass))
        verdicts.append(Verdict(f"{name}: radius of gyration over the link's reach", gyration / reach, 1.0, "ratio"))
    return verdicts


def missing_mass(arm: Arm) -> list[Verdict]:
    """A failing verdict for each link that moves without any mass at it or further out, where other links have some."""
    bare = [link.link for link in arm.chain.links if link.body is None]
    if len(bare) == arm.n:
        return []
    return [Verdict(f"{name}: mass that moves with the link and beyond it", 0.0, 0.0, "kg", "above") for name in bare]


def not_judged(arm: Arm) -> list[str]:
    """The links whose inertia no verdict is about, and why."""
    if all(link.body is None for link in arm.chain.links):
        return ["masses and inertias are not given: no dynamics"]
    out = []
    for link in arm.chain.links:
        body = link.body
        if body is None:
            out.append(f"{link.link}: no <inertial>")
        elif body.unknown:
            names = ", ".join(INERTIAL[k] for k in body.unknown)
            out.append(f"{link.link}: inertia known in part; no torque depends on {names} about its frame's origin")
        elif body.is_weightless:
            out.append(f"{link.link}: massless, by zeros or by no <inertial>")
    poses = (*(joint.origin for joint in arm.uninstalled().joints()), arm.flange())
    if not any(np.linalg.norm(pose.position) for pose in poses):
        out.append("radius of gyration of links whose centre of mass is on their joint: the chain has no length")
    return out


def at_rest(arm: Arm) -> list[str]:
    """Notes on links that do not move, whose inertials no body can have: they enter no verdict."""
    layout = fitting(arm.layout, arm.uninstalled().chain)
    links = layout.written.get("", ()) if layout is not None else ()
    return [
        f"{x.link} does not move with this arm; no body can have its inertial"
        for x in links
        if x.body is not None and not is_physical(x.body)
    ]


SPEED, ACCELERATION = 2.0, 10.0
"""Half-widths of the random joint speeds and accelerations [rad/s, rad/s^2]."""
EXACT = 1e-12
"""Relative: a few hundred roundings of 1e-16 in a recursion over a handful of links."""

FLOOR = 1e-3
"""Smallest scale of a comparison of g or C, as a share of the arm's largest torque (or B times speed): some arms have
no gravity torque or no Coriolis terms, only roundings of zero."""

LEVER = 1e-2
"""The same as a share of the whole mass on the whole length: the recursion carries each force along the links, and
where its moment cancels (a wheel that turns about its own centre), the rounding of the force stays."""

STEP = 1e-30
"""Complex step: there is no subtraction, so it may be as small as floats allow."""
SECONDS, RTOL = 2.0, 1e-12
DRIFT = 1e-8
"""[J] A swing exchanges tens of joules, of which its integrator at rtol 1e-12 loses about 1e-10."""
SPLITS = (2, 4, 6, 8, 10, 12)
"""Steps of the midpoint rule that are extrapolated to infinitely many: order 12. SciPy's integrators take a third of a
second to import."""
EVALUATIONS = 50_000
"""Of forward dynamics in one swing, some seconds of computing: light links on stiff ratios would take minutes."""
SHORTEST = 1e-12
"""[s] A step that must be shorter cannot be taken."""

SLIDE = 2.0
"""[m] Half width of the range from which positions of a sliding joint are drawn: a mobile base may go a kilometre, and
differences of positions then round at 1e-13 m."""


@dataclass(frozen=True, slots=True, eq=False)
class States:
    """q, dq, ddq, (count, n) each."""

    q: Array
    dq: Array
    ddq: Array


def random_states(arm: Arm, count: int, seed: int) -> States:
    """Joint positions uniform inside `sampled_box`, speeds and accelerations uniform."""
    rng = np.random.default_rng(seed)
    lower, upper = sampled_box(arm)
    q = rng.uniform(lower, upper, (count, arm.n))
    dq = rng.uniform(-SPEED, SPEED, (count, arm.n))
    return States(q, dq, rng.uniform(-ACCELERATION, ACCELERATION, (count, arm.n)))


def sampled_box(arm: Arm) -> tuple[Array, Array]:
    """Lower and upper ends (n,) [rad, m] between which positions are drawn.

    The limits; +-pi [rad or m] where they are unknown. A range wider than four turns or 2 `SLIDE` is cut to that width
    about 0, or about its own point nearest to 0.
    """
    lower = np.where(np.isfinite(arm.lower), arm.lower, np.minimum(-np.pi, arm.upper - np.pi))
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.maximum(np.pi, lower + np.pi))
    slides = np.array([link.kind is JointKind.PRISMATIC for link in arm.chain.links])
    half = np.where(slides, SLIDE, 4.0 * np.pi)
    wide = upper - lower > 2.0 * half
    middle = np.clip(0.0, np.where(wide, lower + half, lower), np.where(wide, upper - half, upper))
    return np.where(wide, middle - half, lower), np.where(wide, middle + half, upper)


def box_note(arm: Arm) -> str:
    """What `sampled_box` cut; empty where it is the box of the limits."""
    lower, upper = sampled_box(arm)
    cut = np.isfinite(arm.lower) & np.isfinite(arm.upper) & ((lower > arm.lower) | (upper < arm.upper))
    ranges = zip(arm.joint_names, lower, upper, strict=True)
    parts = [f"{name} {low:g} to {up:g}" for (name, low, up), x in zip(ranges, cut, strict=True) if x]
    return f"states are drawn from a part of the limits: {', '.join(parts)} (rad, m)" if parts else ""


def mass_matrix_identities(dynamics: Dynamics, states: States) -> list[Verdict]:
    """B is symmetric and positive definite; its columns are inverse dynamics of unit accelerations."""
    B = dynamics.mass_matrix(states.q)
    joint = singular_joint(B)
    smallest = float(np.linalg.eigvalsh(B).min()) if joint is None else 0.0
    g = dynamics.gravity_vector(states.q)
    unit = np.eye(dynamics.n)
    columns = dynamics.inverse_dynamics(states.q[:, None, :], np.zeros(dynamics.n), unit) - g[:, None, :]
    return [
        equality("mass matrix: symmetric", B, np.swapaxes(B, -1, -2)),
        Verdict("mass matrix: smallest eigenvalue", smallest, 0.0, "kg m^2", "above"),
        equality("mass matrix: columns against unit accelerations", B, np.swapaxes(columns, -1, -2)),
    ]


def velocity_identities(dynamics: Dynamics, recursion: Recursion, states: States) -> list[Verdict]:
    """dB/dt = C + C^T, and C dq + g is the bias torque."""
    C = dynamics.coriolis_matrix(states.q, states.dq)
    dB = mass_matrix_rate(recursion, states.q, states.dq)
    floor, torque = coriolis_floor(recursion, states), torque_floor(recursion, states)
    h = dynamics.bias_torque(states.q, states.dq)
    bias = np.einsum("kij,kj->ki", C, states.dq) + dynamics.gravity_vector(states.q)
    return [
        equality("power balance: dB/dt = C + C^T", dB, C + np.swapaxes(C, -1, -2), floor),
        equality("bias torque: C dq + g", h, bias, torque),
    ]


def gravity_identity(dynamics: Dynamics, recursion: Recursion, states: States) -> Verdict:
    """g = dU/dq, with U from the positions of the centres of mass."""
    g, gradient = dynamics.gravity_vector(states.q), potential_gradient(recursion, states.q)
    return equality("gravity torque: g = dU/dq", g, gradient, torque_floor(recursion, states))


def torque_floor(recursion: Recursion, states: States) -> float:
    """`FLOOR` of the largest torque of these states, or `LEVER` of the weight at the arm's whole length [N m]."""
    largest = float(np.abs(recursion.inverse_dynamics(states.q, states.dq, states.ddq)).max())
    mass, length = _size(recursion)
    weight = mass * _norm(recursion.gravity)
    return max(FLOOR * largest, LEVER * weight * length)


def coriolis_floor(recursion: Recursion, states: States) -> float:
    """`FLOOR` of the largest B, or `LEVER` of the mass at the arm's whole length, times the speed [N m s/rad]."""
    mass, length = _size(recursion)
    largest = float(np.abs(recursion.mass_matrix(states.q)).max())
    return max(FLOOR * largest, LEVER * mass * length**2) * float(np.abs(states.dq).max())


def _size(recursion: Recursion) -> tuple[float, float]:
    """Mass [kg] and length [m] of a chain: joint to joint, and the farthest centre of mass."""
    length = sum(_norm(link.shift_before) + _norm(link.shift) for link in recursion.links)
    beyond = max(_norm(link.com) for link in recursion.links)
    return float(sum(link.mass for link in recursion.links)), length + beyond


def _norm(vector: Vector) -> float:
    return float(np.linalg.norm([vector.x, vector.y, vector.z]))


def mass_matrix_rate(recursion: Recursion, q: Array, dq: Array) -> Array:
    """dB/dt along dq, exact, (..., n, n)."""
    rate: Any = recursion.mass_matrix(q + 1j * STEP * dq)
    return np.asarray(rate.imag / STEP, dtype=np.float64)


def potential_gradient(recursion: Recursion, q: Array) -> Array:
    """dU/dq, exact, (..., n)."""
    steps: Any = q[..., None, :] + 1j * STEP * np.eye(q.shape[-1])
    return np.asarray(recursion.potential_energy(steps).imag / STEP, dtype=np.float64)


def equality(name: str, a: Array, b: Array, floor: float = 0.0) -> Verdict:
    """The verdict on two arrays that are the same to rounding, see `relative`."""
    return Verdict(name, relative(a, b, floor), EXACT, "relative")


def relative(a: Array, b: Array, floor: float = 0.0) -> float:
    """Largest difference over the largest entry of both, or over `floor` if that is more; 0 when all vanish.

    >>> relative(np.array([0.25, 0.5]), np.array([0.25, 0.625]))
    0.2
    """
    scale = max(float(np.abs(a).max(initial=0.0)), float(np.abs(b).max(initial=0.0)), floor)
    return 0.0 if scale == 0.0 else float(np.abs(a - b).max()) / scale


def _swing(dynamics: Dynamics, q: Array, dq: Array, seconds: float) -> tuple[float, float]:
    """Largest |E(t) - E(0)| [J] of a free swing, and the time that it came to [s]: `EVALUATIONS` end it."""
    n, none = dynamics.n, np.zeros(dynamics.n)

    def rates(x: Array) -> Array:
        return np.concatenate([x[n:], dynamics.forward_dynamics(x[:n], x[n:], none)])

    states, t, h, used = [np.concatenate([q, dq])], 0.0, 1e-2, 0
    try:
        while t < seconds and used < EVALUATIONS:
            h = min(h, seconds - t)
            after, error = extrapolated(rates, states[-1], h)
            used += sum(SPLITS) + 1
            if error <= 1.0:
                states.append(after)
                t = seconds if h == seconds - t else t + h
            elif h < SHORTEST:
                return float("nan"), t
            h *= float(np.nan_to_num(np.clip(0.9 * max(error, 1e-9) ** -_POWER, 0.2, 4.0), nan=0.2))
    except (ShapeError, SingularMassError):  # a state that is not finite
        return float("nan"), t
    x = np.array(states)
    energies = mechanical_energy(dynamics, x[:, :n], x[:, n:])
    return float(np.abs(energies - energies[0]).max()), t


_POWER = 1.0 / (2 * len(SPLITS) - 1)


def extrapolated(rates: Callable[[Array], Array], x: Array, h: float) -> tuple[Array, float]:
    """The state after h [s] of dx/dt = rates(x), and its estimated error as a share of what `RTOL` allows.

    By the midpoint rule in 2, 4, 6 ... steps, whose errors have even powers of the step alone, extrapolated to a step
    of 0 (Gragg, Bulirsch, Stoer; Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.9).

    >>> after, error = extrapolated(lambda x: -x, np.ones(1), 0.1)
    >>> bool(abs(after[0] - np.exp(-0.1)) < 1e-15), error < 1.0
    (True, True)
    """
    first, row, last = rates(x), list[Array](), list[Array]()
    for i, splits in enumerate(SPLITS):
        d, last = h / splits, row
        before, now = x, x + d * first
        for _ in range(splits - 1):
            before, now = now, before + 2.0 * d * rates(now)
        row = [(now + before + d * rates(now)) / 2.0]
        for j in range(i):
            row.append(row[j] + (row[j] - last[j]) / ((splits / SPLITS[i - 1 - j]) ** 2 - 1.0))
    size = RTOL * (1.0 + np.maximum(np.abs(x), np.abs(row[-1])))
    return row[-1], float(np.sqrt(np.mean(((row[-1] - row[-2]) / size) ** 2)))


def swing_verdict(dynamics: Dynamics, q: Array, dq: Array, seconds: float = SECONDS) -> Verdict:
    """The energy drift: nothing drives or brakes the arm, so kinetic plus potential energy is constant."""
    drift, end = _swing(dynamics, q, dq, seconds)
    return Verdict(f"energy drift of a free swing, {end:.3g} s", drift, DRIFT, "J")
