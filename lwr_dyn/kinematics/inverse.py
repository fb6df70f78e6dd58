"""Inverse kinematics of one flange pose: every branch in closed form for arms that allow it, else a numeric search.

The search is damped least squares inside the joint limits, from many seeded starts. Each step is dq = J^T (J J^T +
damping)^-1 e over the joints that are not held at a limit they push against; a step that does not bring the pose nearer
is rejected and damped more (Levenberg 1944, Marquardt 1963; Wampler 1986 for robots). All starts run at once. Every
solution is verified, but there may be more. Of a pose out of reach the nearest point that the arm reaches in that
orientation is given.
"""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from lwr_dyn.foundation.arrays import Array, arm_argument, fixed_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.kinematics import solution
from lwr_dyn.kinematics.forward import jacobian_at, joint_axes
from lwr_dyn.kinematics.solution import InverseResult, PoseProblem, joint_ranges, wrap
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.spatial import pose_array

SOLVED = 1e-11
"""Largest entry of FK(q) - T that counts as solved [m and dimensionless]."""

STEPS = 150

WITHIN = 1e-6
"""[m] A position missed by less is within reach."""

APART = 1e-4
"""[rad or m] Solutions nearer than this in every joint count as one."""

_REGULAR = 1e-13
"""Least damping as a share of the trace of J J^T: the sum is regular by a thousand times what a solution by elimination
rounds, also where J has lost rank (a stretched arm, fewer than six joints, held joints)."""

_DAMPING, _EASE, _STIFFEN, _WEAKEST, _STIFFEST = 1e-2, 0.2, 4.0, 1e-20, 1e6

_FAINT = 1e-5
"""[m/rad] Weight of the orientation beside a position that comes first."""


def search(chain: Chain, lower: Array, upper: Array, T: Array, starts: int, seed: int) -> Array:
    """Distinct joint positions (m, n) within lower and upper (n,) whose flange pose is T (4, 4); ungated."""
    ends, residual = descend(chain, lower, upper, T, _starts(chain, lower, upper, starts, seed))
    good = ends[residual <= SOLVED]
    return good[distinct(good, chain.turning)]


def _starts(chain: Chain, lower: Array, upper: Array, starts: int, seed: int) -> Array:
    """The middle of the ranges, then positions drawn uniformly from them."""
    low, high = solution.drawing_range(chain.turning, lower, upper)
    share = np.random.default_rng(seed).uniform(size=(starts, chain.n))
    share[0] = 0.5
    q: Array = low + share * (high - low)
    return q


def descend(
    chain: Chain,
    lower: Array,
    upper: Array,
    T: Array,
    q: Array,
    damping: float = _DAMPING,
    turn_weight: float = 1.0,
) -> tuple[Array, Array]:
    """The ends of starts q (k, n) and their residuals (k,); an orientation of weight 0 does not count."""
    ends, residuals, rows = q.copy(), np.empty(len(q)), np.arange(len(q))
    damped = np.full(len(q), damping)
    error, jacobian, residual = _pose_error(chain, T, q, turn_weight)
    for _ in range(STEPS):
        trial = np.clip(q + _step(jacobian, error, damped, q, lower, upper), lower, upper)
        new_error, new_jacobian, new_residual = _pose_error(chain, T, trial, turn_weight)
        nearer = np.einsum("ki,ki->k", new_error, new_error) < np.einsum("ki,ki->k", error, error)
        # a solution that rounding lets come no nearer is one too
        done = np.where(nearer, new_residual <= SOLVED / 100.0, (residual <= SOLVED) | (damped >= _STIFFEST))
        q = np.where(nearer[:, None], trial, q)
        error = np.where(nearer[:, None], new_error, error)
        jacobian = np.where(nearer[:, None, None], new_jacobian, jacobian)
        residual = np.where(nearer, new_residual, residual)
        damped = np.where(nearer, np.maximum(damped * _EASE, _WEAKEST), np.minimum(damped * _STIFFEN, _STIFFEST))
        ends[rows], residuals[rows] = q, residual
        on = ~done
        if not on.any():
            break
        rows, q, residual, damped = rows[on], q[on], residual[on], damped[on]
        error, jacobian = error[on], jacobian[on]
    return ends, residuals


def _pose_error(chain: Chain, T: Array, q: Array, turn_weight: float) -> tuple[Array, Array, Array]:
    """Pose error (k, 6) from the flange to T, the Jacobian (k, 6, n), both weighted, and the residual (k,)."""
    error, jacobian, flange = pose_error(chain, T, q)
    weights = np.repeat([1.0, turn_weight], 3)
    gap = np.abs(flange - T)[:, :, 0 if turn_weight else 3 :]
    return error * weights, jacobian * weights[:, None], gap.max(axis=(1, 2))


def pose_error(chain: Chain, T: Array, q: Array) -> tuple[Array, Array, Array]:
    """Pose error (..., 6) [m, rad] from the flange to T (..., 4, 4), Jacobian (..., 6, n), flange pose (..., 4, 4)."""
    axes = joint_axes(chain, q)
    flange = axes.flange
    turn = Rotation.from_matrix(T[..., :3, :3] @ np.swapaxes(flange[..., :3, :3], -1, -2)).as_rotvec()
    error = np.concatenate([T[..., :3, 3] - flange[..., :3, 3], turn], axis=-1)
    return error, jacobian_at(axes, flange[..., :3, 3]), flange


def _step(jacobian: Array, error: Array, damping: Array, q: Array, lower: Array, upper: Array) -> Array:
    """The damped step; joints that would leave their limits are held, and a held joint stays held."""
    free = np.ones(q.shape, dtype=bool)
    step = np.zeros_like(q)
    for _ in range(q.shape[1]):
        J = jacobian * free[:, None, :]
        square = J @ np.swapaxes(J, 1, 2)
        least = _REGULAR * np.trace(square, axis1=1, axis2=2)
        square = square + (damping + least)[:, None, None] * np.eye(6)
        step = np.einsum("kij,ki->kj", J, np.linalg.solve(square, error[..., None])[..., 0])
        pushing = ((q <= lower) & (step < 0.0)) | ((q >= upper) & (step > 0.0))
        if not (pushing & free).any():
            break
        free &= ~pushing
    return step


def distinct(q: Array, turning: NDArray[np.bool_]) -> list[int]:
    """Indices of one of each group of equal rows of q (k, n); whole turns of turning joints (n,) do not count."""
    kept: list[int] = []
    for i, row in enumerate(q):
        gaps = row - q[kept]
        if (np.abs(np.where(turning, wrap(gaps), gaps)).max(axis=1) > APART).all():
            kept.append(i)
    return kept


def solve_pose(problem: PoseProblem, chain: Chain) -> InverseResult:
    """Solutions of one flange pose inside the limits, or where there are none, outside; raises `OptionError`."""
    for lower, upper in _ranges(problem):
        q = search(chain, lower, upper, problem.pose, problem.starts, problem.seed)
        if len(q):
            return solution.ranked_result(
                problem, solution.make_solutions(problem, _within_a_turn(problem.arm, q)), complete=False
            )
    return missed(problem, chain)


def _ranges(problem: PoseProblem) -> list[tuple[Array, Array]]:
    if problem.starts < 1:
        raise OptionError("starts", problem.starts, "an integer >= 1")
    anywhere = np.full(problem.arm.n, np.inf)
    return [*[(problem.arm.lower, problem.arm.upper)] * problem.limits, (-anywhere, anywhere)]


def missed(problem: PoseProblem, chain: Chain) -> InverseResult:
    """By how much the position is out of reach, or if it is not, by how much the orientation is missed."""
    (lower, upper), T = _ranges(problem)[-1], problem.pose
    starts = _starts(chain, lower, upper, problem.starts, problem.seed)
    ends, _ = descend(chain, lower, upper, T, starts, turn_weight=_FAINT)
    flange = joint_axes(chain, ends).flange
    distance = np.sqrt(((flange[:, :3, 3] - T[:3, 3]) ** 2).sum(axis=1))
    turn = np.atleast_1d(Rotation.from_matrix(T[:3, :3] @ np.swapaxes(flange[:, :3, :3], 1, 2)).magnitude())
    best = int(np.argmin(np.hypot(distance, _FAINT * turn)))
    if distance[best] > WITHIN:
        return InverseResult("out of reach", (), (), False, distance=float(distance[best]))
    return InverseResult("out of reach", (), (), False, distance=0.0, turn=float(turn[best]))


def solve_position(problem: PoseProblem, chain: Chain) -> InverseResult:
    """One solution of the position of a pose: where `problem.q0` leads to, else the nearest that a search finds."""
    arm, T = problem.arm, problem.pose
    for lower, upper in _ranges(problem):
        starts = _starts(chain, lower, upper, problem.starts, problem.seed)
        first = np.minimum(np.maximum(starts[0] if problem.q0 is None else problem.q0, lower), upper)
        for begin in (first[None], starts[:8], starts):
            ends, residual = descend(chain, lower, upper, T, begin, turn_weight=0.0)
            if (residual <= SOLVED).any():
                q = _within_a_turn(arm, ends[residual <= SOLVED])
                q = q[[np.abs(q - first).sum(axis=1).argmin()]]
                reached = np.block([[joint_axes(chain, q[0]).flange[:3, :3], T[:3, 3:]], [T[3]]])
                found = solution.make_solutions(replace(problem, pose=reached), q)
                return replace(solution.ranked_result(problem, found, complete=False), position_only=True)
    return replace(missed(problem, chain), turn=None)


def _within_a_turn(arm: Arm, q: Array) -> Array:
    """Revolute joints outside their ranges moved by whole turns towards the middle."""
    ranges = joint_ranges(arm)
    outside = np.abs(q - ranges.middle) > np.maximum(ranges.half, np.pi)
    return np.where(arm.chain.turning & outside, ranges.middle + wrap(q - ranges.middle), q)


SOLVER = solution.IkSolver(lambda chain: chain, solve_pose, "any arm")
"""The row "numeric" of the solvers."""

IK_SOLVERS: Registry[solution.IkSolver[Any]] = Registry(
    "solver",
    {
        "srs": Row("lwr_dyn.kinematics.srs_solver:SOLVER", "S-R-S arms with an arm angle, in closed form"),
        "spherical-wrist": Row("lwr_dyn.kinematics.six_joints.exact_arms:WRIST_SOLVER", "six joints, in closed form"),
        "three-parallel": Row(
            "lwr_dyn.kinematics.six_joints.exact_arms:THREE_PARALLEL_SOLVER", "six joints, in closed form, polished"
        ),
        "rounded-wrist": Row(
            "lwr_dyn.kinematics.six_joints.snapped_arms:ROUNDED_WRIST_SOLVER",
            "six joints, the nearest closed form, polished",
        ),
        "numeric": Row("lwr_dyn.kinematics.inverse:SOLVER", "any arm, by damped least squares from many starts"),
        "eaik": Row(
            "lwr_dyn.kinematics.six_joints.snapped_arms:EAIK_SOLVER",
            "six joints, in closed form by the package EAIK",
            "eaik",
        ),
    },
)
"""Solvers of inverse kinematics, in the order in which they are tried; those after "numeric" only by name."""


def inverse_kinematics(
    arm: Arm,
    T: ArrayLike,
    *,
    arm_angle: float | None = None,
    limits: bool = True,
    reference: ArrayLike | None = None,
    starts: int = 64,
    seed: int = 0,
    solver: str | None = None,
    position_only: bool = False,
    q0: ArrayLike | None = None,
) -> InverseResult:
    """Joint positions whose flange pose is T, or with `position_only` one whose flange is there, in any orientation.

    Parameters
    ----------
    arm : Arm
        An S-R-S arm and a six-joint arm with a spherical wrist or three parallel axes (rounded and calibrated ones
        too) are solved in closed form, any other by a numeric search. In closed form all solutions inside the limits
        are listed, whole turns of a joint apart too, of an S-R-S arm at one arm angle a branch.
    T : (4, 4) array_like
        Pose of the flange in the base [m]; with `position_only` its position (3,) will do.
    arm_angle : float, optional
        [rad], see `srs` for its zero; the one with the largest margin on each branch if not given.
    limits : bool
        False: branches outside the position limits are solutions too.
    reference : (3,) array_like, optional
        Direction the arm angle is counted from; the axis of joint 1 if not given.
    starts, seed : int
        Of the numeric search.
    solver : str, optional
        One of `IK_SOLVERS`; the first that recognises the arm if not given.
    position_only : bool
        One solution, near `q0`, of mostly endlessly many.
    q0 : (n,) array_like, optional
        Where the search of a position starts [rad or m]; the middle of the ranges if not given.

    Returns
    -------
    InverseResult
        Branches that coincide are listed once; `complete` says whether anything can be missing.

    Raises
    ------
    ShapeError, OptionError
        T is not a pose, the arm angle not finite or given for an arm that has none, starts not positive, a solver that
        does not recognise the arm.
    UnknownNameError
        No solver of that name.

    >>> import lwr_dyn
    >>> arm = lwr_dyn.load("lwr4plus")
    >>> result = inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, [0.1, 0.5, 0, -1.0, 0, 0.4, 0]))
    >>> result.status, len(result.solutions), result.complete
    ('solved', 8, True)
    """
    arm_argument(arm)
    if reference is None and not position_only and (ready := _ready(arm, solver)) is not None:
        known = type(T) is np.ndarray and T.shape == (4, 4) and T.dtype is _FLOAT
        found = ready(T if known else fixed_array("T", T, (4, 4)), limits, arm_angle)  # type: ignore[arg-type]
        if found is not None:
            return found
    if position_only and (arm_angle is not None or reference is not None or solver not in (None, "numeric")):
        raise OptionError("arm_angle, reference, solver", "given for a position only", 'none, or solver="numeric"')
    if position_only:
        pose, start = np.eye(4), None if q0 is None else fixed_array("q0", q0, (arm.n,))
        pose[:3, 3] = fixed_array("T", T, (3,)) if np.ndim(T) == 1 else fixed_array("T", T, (4, 4))[:3, 3]
        return solve_position(PoseProblem(arm, pose, limits, starts=starts, seed=seed, q0=start), arm.chain)
    pose = pose_array("T", fixed_array("T", T, (4, 4)))
    chosen, geometry = _solver_of(arm, solver)
    if not chosen.has_arm_angle and (arm_angle is not None or reference is not None):
        raise OptionError("arm_angle, reference", f"given for {arm.name}", "only for an S-R-S arm")
    return chosen.solve(PoseProblem(arm, pose, limits, arm_angle, reference, starts, seed), geometry)


_FLOAT = np.dtype(np.float64)


@lru_cache(maxsize=32)
def _ready(arm: Arm, name: str | None) -> solution.ReadySolver | None:
    """What solves poses of this arm one after the other, where its solver has it."""
    solver, _ = _solver_of(arm, name)
    return None if solver.ready is None else solver.ready(arm)


def _solver_of(arm: Arm, name: str | None) -> tuple[solution.IkSolver[Any], Any]:
    """The solver of that name, or the first of our own that recognises the arm, with the arm's geometry."""
    for candidate in IK_SOLVERS.rows if name is None else (name,):
        solver = IK_SOLVERS.load(candidate)
        geometry = solver.recognise(arm.chain)
        if geometry is not None:
            return solver, geometry
    raise OptionError(f"solver {name}", f"{arm.name} is not an arm that it solves", solver.arms)


STEP = 1e-6
"""[m] Of the differences that give the gradient of the distance."""


def nearest_point(arm: Arm, pose: Array, result: InverseResult) -> Array | None:
    """The point (3,) [m], for `result` of a `pose` (4, 4) out of reach; None where the distance is not proven.

    The reach of the closed forms is a shell about the shoulder, so the gradient of the distance leads to its surface.
    """
    if not result.complete or result.distance is None:
        return None
    moved = np.tile(pose, (3, 1, 1))
    moved[:, :3, 3] += STEP * np.eye(3)
    slope = [((inverse_kinematics(arm, T).distance or 0.0) - result.distance) / STEP for T in moved]
    point: Array = pose[:3, 3] - result.distance * np.array(slope)
    return point


def nearest_words(arm: Arm, pose: Array, result: InverseResult) -> str:
    """The point in words, for the end of a line; empty where none is known."""
    point = nearest_point(arm, pose, result)
    if point is None:
        return ""
    return f"; the nearest point in this orientation: {','.join(f'{round(x, 4) + 0.0:.4f}' for x in point)}"
