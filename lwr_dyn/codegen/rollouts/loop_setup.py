"""What goes into rollouts, checked: the loop that runs share, and the parameters that differ from run to run.

The loop is checked as `simulate` checks it: arms, references at every sample, options. References are sampled once for
many calls (`simulation.setup.known_motion`). Parameters have names, shapes and what is
allowed; of them come arms of runs, and rows for kernels. Gains obey the rules of the controllers' own constructors. A
load is a point mass at its centre in the flange's frame, as `model.arm.arm_with_payload` without an inertia.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from math import isfinite, prod
from typing import Any

import casadi
import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels.kernel_spec import FRICTION, TENSOR, friction_table
from lwr_dyn.codegen.rollouts.philox_code import MOST_SEED
from lwr_dyn.codegen.rollouts.step import MOST_DELAY
from lwr_dyn.codegen.rollouts.symbolic_arm import KeptParameters, SymbolicModel, check_friction
from lwr_dyn.control.protocol import Controller
from lwr_dyn.foundation.arrays import Array, read_only, real_array
from lwr_dyn.foundation.errors import OptionError, ShapeError, UnknownNameError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, Chain, Rotor, with_bodies, with_payload
from lwr_dyn.model.run import Motion, Reference, reference_argument
from lwr_dyn.model.spatial import steiner
from lwr_dyn.simulation.arm_friction import SMOOTH_SPEED
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import LONGEST, Loop, prepare

ABOVE_ZERO = (
    "Kp", "Kd", "Ki", "tracking_time", "law_effort", "omega_n", "rho", "layer", "law_friction_width",
)  # fmt: skip

NOT_NEGATIVE = ("adaptation_gains", "friction_gains", "upper_load")

COULOMB = [i for i, name in enumerate(FRICTION) if name.endswith("coulomb")]

RULES: dict[str, tuple[Callable[[Array], NDArray[np.bool_]], str]] = {
    **dict.fromkeys(ABOVE_ZERO, (lambda x: x <= 0.0, "numbers above 0")),
    **dict.fromkeys(NOT_NEGATIVE, (lambda x: x < 0.0, "numbers from 0 on")),
    "lower_load": (lambda x: x > 0.0, "numbers up to 0"),
    "law_friction": (lambda x: (x < 0.0) & np.isin(np.arange(len(FRICTION)), COULOMB)[:, None], "levels from 0 on"),
}
"""Name -> what is refused, and what is allowed."""


def check_gains(given: Mapping[str, Array]) -> None:
    """Raise `OptionError` for gains (runs, ...) that no controller has, naming the first run."""
    for name, (refused, allowed) in RULES.items():
        bad = refused(given[name]) if name in given else np.zeros(0, dtype=bool)
        if bad.any():
            where = np.argwhere(bad)[0]
            raise OptionError(f"parameter {name}", f"{given[name][tuple(where)]:g} in run {where[0]}", allowed)


MOST_RUNS = 10_000_000


def parameter_shapes(n: int, gains: Mapping[str, tuple[int, ...]] | None = None) -> dict[str, tuple[int, ...]]:
    """Name -> shape of one run's value, for n joints; `gains` are those of the law.

    >>> parameter_shapes(7)["inertia"], parameter_shapes(7)["payload_com"]
    ((70,), (3,))
    """
    plant: dict[str, tuple[int, ...]] = {
        "inertia": (10 * n,), "payload": (), "payload_com": (3,), "armature": (n,), "friction": (5, n), "effort": (n,),
        "q0": (n,), "dq0": (n,), "delay": (), "resolution": (), "noise": (), "reference": (),
        "model_inertia": (10 * n,), "model_payload": (), "model_payload_com": (3,),
    }  # fmt: skip
    return plant | dict(gains or {})


def run_parameters(
    given: Mapping[str, Any], runs: int | None, shapes: Mapping[str, tuple[int, ...]], references: int = 1
) -> tuple[int, dict[str, Array]]:
    """The number of runs, and each parameter as an array (runs, *shape).

    A row (runs,) or (runs, 1) for a joint vector stands for all joints; trailing axes may be flat, and inertias may
    have an axis of links (runs, n, 10). Other axes are refused: transposed ones would be read as other numbers.

    Raises
    ------
    UnknownNameError
        A name that is not in `shapes`.
    ShapeError
        Another shape, a number that is not finite, parameters with different numbers of rows.
    OptionError
        No number of runs, or one that is not from 1 on; a value outside what is allowed.
    """
    for name in given:
        if name not in shapes:
            raise UnknownNameError("parameter of rollouts", name, shapes)
    arrays = {name: _rows(name, value) for name, value in given.items()}
    rows = {name: len(array) for name, array in arrays.items()}
    count = next(iter(rows.values()), None) if runs is None else runs
    if count is None:
        raise OptionError("runs", "not given", "a number of runs, or parameters with a row for each")
    if not (isinstance(count, int) and not isinstance(count, bool) and 1 <= count <= MOST_RUNS):
        raise OptionError("runs", count, f"a whole number from 1 to {MOST_RUNS}")
    for name, found in rows.items():
        if found != count:
            raise ShapeError(f"parameter {name}", f"{found} rows", f"{count} rows, one a run")
    whole = {name: _whole(name, array, shapes[name]) for name, array in arrays.items()}
    _check(whole, references)
    return count, whole


def _rows(name: str, value: Any) -> Array:
    array = real_array(f"parameter {name}", value)
    if array.ndim == 0:
        raise ShapeError(f"parameter {name}", "a single number", "an array with a row a run")
    return array


def _whole(name: str, array: Array, shape: tuple[int, ...]) -> Array:
    runs, rest = len(array), array.shape[1:]
    by_link = (shape[0] // 10, 10) if name.endswith("inertia") else shape
    if rest in (shape, by_link) or (len(rest) <= 1 and prod(rest) == prod(shape)):
        return np.ascontiguousarray(array.reshape(runs, *shape))
    if len(shape) == 1 and prod(rest) == 1 and not name.endswith(("inertia", "com")):
        return np.repeat(array.reshape(runs, 1), shape[0], axis=1)
    words = f"({runs}, {', '.join(map(str, shape))})" if shape else f"({runs},)"
    raise ShapeError(f"parameter {name}", f"shape {array.shape}", words)


def _check(values: Mapping[str, Array], references: int) -> None:
    bounds = {"payload": np.inf, "model_payload": np.inf, "armature": np.inf, "effort": np.inf, "resolution": np.inf}
    bounds |= {"noise": np.inf, "delay": MOST_DELAY, "reference": references - 1}
    for name, most in ((name, most) for name, most in bounds.items() if name in values):
        array = values[name]
        bad = (array < 0.0) | (array > most)
        if name in ("delay", "reference"):
            bad |= array != np.round(array)
        if bad.any():
            where = int(np.argwhere(bad)[0][0])
            kind = "whole numbers" if name in ("delay", "reference") else "numbers"
            end = "from 0 on" if np.isinf(most) else f"from 0 to {most}"
            raise OptionError(f"parameter {name}", f"{array[bad][0]:g} in run {where}", f"{kind} {end}")
    for load in ("payload", "model_payload"):
        if f"{load}_com" in values and load not in values:
            raise OptionError(f"parameter {load}_com", f"given without {load}", f"both, or {load} alone")
    for name in ("inertia", "model_inertia"):
        masses = values.get(name, np.zeros((0, 10)))[:, ::10]
        for run, link in np.argwhere(masses < 0.0)[:1].tolist():
            found = f"a mass of {masses[run, link]:g} kg in run {run}, link {link + 1}"
            raise OptionError(f"parameter {name}", found, "masses from 0 on")
    check_gains(values)


def kept_values(chain: Chain, inertia: Array | None, load: Array | None, com: Array | None) -> Array:
    """Kept parameters of every run, (runs, kept).

    Parameters
    ----------
    inertia : (runs, 10 n) array, optional
        As `kernel_spec.inertial_parameters`, flat; the chain's own if not given.
    load : (runs,) array, optional
        [kg] at the flange, with its centre `com` (runs, 3) [m] there; at its origin if not given.
    """
    kept = KeptParameters.of(chain)
    out = kept.own[None] if inertia is None else _product(inertia, kept.matrix)
    return out if load is None else out + _product(_point_masses(load, com), kept.payload_matrix)


def mass_matrices(chain: Chain, q: Array, given: Mapping[str, Array]) -> Array:
    """Mass matrices (runs, n, n) at q (n,) of plants with the rows `inertia`, `payload`, `armature`; (1, n, n) of none.

    A mass matrix is linear in the kept parameters: one evaluation of its matrix serves all runs.
    """
    n, own = chain.n, KeptParameters.of(chain).own
    symbols = casadi.SX.sym("kept", own.size)
    rows = SymbolicModel.of(chain, symbols, [0.0] * n).mass_matrix(casadi.DM(q))
    flat = casadi.vertcat(*(x for row in rows for x in row))
    linear = np.array(casadi.Function("B", [symbols], [casadi.jacobian(flat, symbols)])(own).full())
    kept = kept_values(chain, *(given.get(name) for name in ("inertia", "payload", "payload_com")))
    rotors = given.get("armature", chain.armature[None])
    return _product(kept, linear).reshape(-1, n, n) + rotors[:, :, None] * np.eye(n)


def _product(rows: Array, matrix: Array) -> Array:
    """rows matrix^T, summed in order: the same bits for any number of rows."""
    out = np.zeros((len(rows), len(matrix)))
    for k in np.flatnonzero(matrix.any(axis=0)):
        column = matrix[:, k]
        used = np.flatnonzero(column)
        out[:, used] += rows[:, k, None] * column[used]
    return out


def _point_masses(load: Array, com: Array | None) -> Array:
    """Inertial parameters (runs, 10) of point masses."""
    x, y, z = np.zeros((3, len(load))) if com is None else com.T
    second = {(0, 0): y * y + z * z, (1, 1): x * x + z * z, (2, 2): x * x + y * y}
    second |= {(0, 1): -x * y, (0, 2): -x * z, (1, 2): -y * z}
    columns = [np.ones_like(load), x, y, z, *(second[place] for place in TENSOR)]
    return np.asarray(load[:, None] * np.stack(columns, axis=1))


def arm_of_run(arm: Arm, row: Mapping[str, Array], prefix: str = "") -> Arm:
    """The arm with one run's inertia, payload, armature and effort; `prefix` "model_" is the arm that its law knows."""
    chain = arm.chain
    if prefix + "inertia" in row:
        chain = with_bodies(chain, _bodies(row[prefix + "inertia"].reshape(chain.n, 10)))
    if prefix + "payload" in row:
        chain = with_payload(chain, float(row[prefix + "payload"]), row.get(prefix + "payload_com", np.zeros(3)))
    limits: tuple[JointLimits, ...] = arm.limits
    if not prefix and "armature" in row:
        rotors = [Rotor(1.0, float(x), reflected=True) for x in row["armature"]]
        links = [replace(link, rotor=rotor) for link, rotor in zip(chain.links, rotors, strict=True)]
        chain = replace(chain, links=tuple(links))
    if not prefix and "effort" in row:
        limits = tuple(replace(x, effort=float(e)) for x, e in zip(limits, row["effort"], strict=True))
    return arm if chain is arm.chain and limits is arm.limits else replace(arm, chain=chain, limits=limits)


def _bodies(rows: Array) -> list[Body]:
    """Bodies from their inertial parameters (n, 10)."""
    bodies = []
    for m, *rest in rows.tolist():
        tensor = np.zeros((3, 3))
        for (i, j), value in zip(TENSOR, rest[3:], strict=True):
            tensor[i, j] = tensor[j, i] = value
        com = np.array(rest[:3]) / m if m else np.zeros(3)
        bodies.append(Body(m, com, tensor - steiner(m, com)))
    return bodies


_KEPT = 16
"""Tables that are kept."""


def joint_rows(motion: Motion) -> Array:
    """Rows of a kernel's table, (samples, 3 n), read-only: q, dq, ddq."""
    return (_kept_rows if motion.t.size <= LONGEST else _rows_of)(motion, None)


def reference_rows(motion: Motion, chain: Chain) -> Array:
    """The same with the place of the tip, (samples, 3 n + 3)."""
    return (_kept_rows if motion.t.size <= LONGEST else _rows_of)(motion, chain)


def _rows_of(motion: Motion, chain: Chain | None) -> Array:
    tip = [] if chain is None else [flange_pose(chain, motion.q)[:, :3, 3]]
    return read_only(np.hstack([motion.q, motion.dq, motion.ddq, *tip]))


_kept_rows = lru_cache(maxsize=_KEPT)(_rows_of)


FRICTIONS = ("none", "smooth")


@dataclass(frozen=True, slots=True, eq=False)
class LoopSetup:
    """What all runs share: `motions` are the references at all samples; `loop` has the friction and the duration."""

    arm: Arm
    controller: Controller
    references: tuple[Reference, ...]
    motions: tuple[Motion, ...]
    loop: Loop
    friction_width: float

    @property
    def plant(self) -> Arm:
        """The arm that is simulated."""
        return self.arm if self.loop.plant is None else self.loop.plant

    @property
    def samples(self) -> int:
        """Samples of a run."""
        return int(self.motions[0].t.size)

    @property
    def t(self) -> Array:
        """Times of the samples [s]."""
        return self.motions[0].t

    def table(self) -> Array:
        """Rows of all references, (references, samples, 3 n + 3): q, dq, ddq, and the place of the tip."""
        rows = [reference_rows(motion, self.plant.chain) for motion in self.motions]
        return rows[0][None] if len(rows) == 1 else np.stack(rows)

    def record(self) -> dict[str, Any]:
        """The options as JSON values."""
        names = ("rate", "substeps", "friction", "saturate", "position_limits", "delay", "seed", "duration")
        width = {} if self.loop.friction == "none" else {"friction_width": self.friction_width}
        references = [str(getattr(each, "name", type(each).__name__)) for each in self.references]
        encoder = None if self.loop.encoder is None else asdict(self.loop.encoder)
        return (
            {name: getattr(self.loop, name) for name in names} | width | {"references": references, "encoder": encoder}
        )


def loop_setup(
    arm: Arm,
    controller: Controller,
    reference: Reference | Sequence[Reference],
    loop: Loop,
    friction_width: float = SMOOTH_SPEED,
) -> LoopSetup:
    """The loop, checked as `simulate` checks it; errors as of `rollouts`, whose friction is "none" or "smooth"."""
    references = tuple(reference) if isinstance(reference, Sequence) else (reference,)
    for each in references:
        reference_argument(each)
    if not references:
        raise OptionError("reference", "an empty sequence", "a reference, or several")
    _check_friction(arm if loop.plant is None else loop.plant, loop.friction, friction_width)
    encoder = loop.encoder
    if encoder is not None and type(encoder).sensor is not Encoder.sensor:
        raise OptionError("encoder", f"{type(encoder).__name__}, with a sensor of its own", "an Encoder")
    long = max(float(each.duration) for each in references) if loop.duration is None else loop.duration
    free = replace(loop, friction="none", duration=long)
    motions = tuple(prepare(arm, controller, each, free).motion for each in references)
    if loop.seed > MOST_SEED:
        raise OptionError("seed", loop.seed, "a whole number below 2^64")
    own = replace(free, friction="smooth") if loop.friction == "smooth" else free
    return LoopSetup(arm, controller, references, motions, own, friction_width)


def _check_friction(plant: Arm, friction: Any, width: float) -> None:
    if friction not in (*FRICTIONS, "set-valued"):
        raise OptionError("friction", repr(friction), ", ".join(FRICTIONS))
    if friction == "set-valued" and plant.has_friction:
        other = "friction 'smooth' with friction_width [rad/s], or simulate"
        raise OptionError("friction", "'set-valued': a kernel has no true stick", other)
    if friction == "smooth":
        friction_table(plant.friction_models())
        if not (isfinite(width) and width > 0.0):
            raise OptionError("friction_width", width, "a speed above 0")


def check_starts(setup: LoopSetup, given: Mapping[str, Array]) -> None:
    """Raise `OptionError` for a run that starts outside the position limits."""
    if not (setup.loop.position_limits and "q0" in given):
        return
    q0, lower, upper = given["q0"], setup.plant.lower, setup.plant.upper
    for run, joint in np.argwhere((q0 < lower) | (q0 > upper))[:1].tolist():
        allowed = f"{lower[joint]:.6g} to {upper[joint]:.6g}, or position_limits=False"
        name = f"q0 of run {run}, {setup.plant.joint_names[joint]}"
        raise OptionError(name, f"{q0[run, joint]:.6g}", allowed)


def check_smooth_friction(setup: LoopSetup, given: Mapping[str, Array]) -> float:
    """The fastest rate at which smooth friction brakes a run [1/s], where the first reference begins; 0 without it.

    Raises `OptionError` for friction of single runs without "smooth", or too stiff for the step.
    """
    own = given.get("friction")
    if setup.loop.friction != "smooth":
        if own is not None:
            raise OptionError("friction", f"{setup.loop.friction!r} with a parameter friction", "'smooth'")
        return 0.0
    tables = friction_table(setup.plant.friction_models()) if own is None else own
    B = mass_matrices(setup.plant.chain, setup.motions[0].q[0], given)
    rates = check_friction(B, tables, setup.friction_width, setup.loop.rate, setup.loop.substeps)
    return float(rates.max())
