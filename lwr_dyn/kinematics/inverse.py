"""Inverse kinematics of one flange pose: every branch in closed form for arms that allow it, else a numeric search."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import arm_argument, fixed_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.kinematics.numeric import solve_position
from lwr_dyn.kinematics.solution import IkSolver, InverseResult, PoseProblem
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import pose_array

IK_SOLVERS: Registry[IkSolver[Any]] = Registry(
    "solver",
    {
        "srs": Row("lwr_dyn.kinematics.srs_solver:SOLVER", "S-R-S arms with an arm angle, in closed form"),
        "spherical-wrist": Row("lwr_dyn.kinematics.six_joints.spherical_wrist:SOLVER", "six joints, in closed form"),
        "three-parallel": Row(
            "lwr_dyn.kinematics.six_joints.three_parallel:SOLVER", "six joints, in closed form, polished"
        ),
        "rounded-wrist": Row(
            "lwr_dyn.kinematics.six_joints.snapped_arms:SOLVER", "six joints, the nearest closed form, polished"
        ),
        "numeric": Row("lwr_dyn.kinematics.numeric:SOLVER", "any arm, by damped least squares from many starts"),
        "eaik": Row(
            "lwr_dyn.kinematics.six_joints.eaik_solver:SOLVER", "six joints, in closed form by the package EAIK", "eaik"
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


def _solver_of(arm: Arm, name: str | None) -> tuple[IkSolver[Any], Any]:
    """The solver of that name, or the first of our own that recognises the arm, with the arm's geometry."""
    for candidate in IK_SOLVERS.rows if name is None else (name,):
        solver = IK_SOLVERS.load(candidate)
        geometry = solver.recognise(arm.chain)
        if geometry is not None:
            return solver, geometry
    raise OptionError(f"solver {name}", f"{arm.name} is not an arm that it solves", solver.arms)
