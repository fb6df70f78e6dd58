"""The arm with fitted bodies, rotors and friction in place of its source's, each number with its source.

Bodies, rotors and friction of a fit, each number with its standard error, and the logs that they come from.
"""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lwr_dyn.dynamics.regressor import INERTIAL, ROW_BY_ROW
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.identification.motion.motion_result import MotionIdentification
from lwr_dyn.model.arm import Arm, JointLimits, Source
from lwr_dyn.model.chain import Body, ChainLink, JointKind, Rotor
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.model.spatial import steiner

_CHUNK = 1 << 20


@dataclass(frozen=True, slots=True)
class LogDigest:
    """A log that a fit used: its path, the SHA-256 of its bytes (of a folder: of its files in order), its instants."""

    source: str
    sha256: str
    instants: int

    def text(self) -> str:
        """`moves.csv (sha256 1f..., 982 instants)`."""
        digest = f"sha256 {self.sha256}" if self.sha256 else "not a file"
        return f"{Path(self.source).name} ({digest}, {self.instants} instants)"


@dataclass(frozen=True, slots=True, eq=False)
class FittedValues:
    """What a fit says of an arm of n joints, SI; tensors about the origins of the links' frames, in their axes.

    `mass` (n,), `com` (n, 3), `inertia` (n, 3, 3), `armature` (n,) and as many `*_sigma`; `friction`, one model a
    joint, with `friction_sigma`: quantity of a direction ("positive_coulomb", ..., "offset") -> (n,), NaN where there
    is none; `covered` (n,): the largest speed that was seen [rad/s or m/s], 0 for a joint that did not move. `joints`
    is False where rotors and friction were fitted to motors: those of the arm stay then, and these are not used.
    """

    mass: Array
    mass_sigma: Array
    com: Array
    com_sigma: Array
    inertia: Array
    inertia_sigma: Array
    armature: Array
    armature_sigma: Array
    friction: tuple[JointFriction, ...]
    friction_sigma: dict[str, Array]
    covered: Array
    logs: tuple[LogDigest, ...]
    about: str
    """How they were fitted."""
    joints: bool = True

    def __post_init__(self) -> None:
        freeze_arrays(
            self, "mass", "mass_sigma", "com", "com_sigma", "inertia", "inertia_sigma", "armature", "armature_sigma",
            "covered",
        )  # fmt: skip

    @property
    def where(self) -> str:
        """The source of the numbers, for a data file."""
        return f"fitted to {', '.join(Path(log.source).name for log in self.logs)}; digests in [document]"


def fitted_values(result: MotionIdentification) -> FittedValues:
    """The values of the consistent fit of an identification.

    com = m c / m has the variance (var(m c) - 2 c cov(m c, m) + c^2 var(m)) / m^2, to first order.

    Raises
    ------
    MissingDataError
        The arm has no masses, so there was no consistent fit.
    """
    fit, columns = result.consistent, result.columns
    if fit is None:
        raise MissingDataError(result.arm.name, "masses", "a fitted model")
    n, ten, cov = result.arm.n, len(INERTIAL), fit.covariance
    pi, sigma = (x[: columns.bodies].reshape(n, ten) for x in (fit.parameters, fit.sigma))
    mass, com = pi[:, 0], pi[:, 1:4] / pi[:, :1]
    com_sigma = np.empty((n, 3))
    for i in range(n):
        block = cov[ten * i : ten * i + 4, ten * i : ten * i + 4]
        variance = np.diag(block)[1:] - 2.0 * com[i] * block[0, 1:] + np.square(com[i]) * block[0, 0]
        com_sigma[i] = np.sqrt(np.maximum(variance, 0.0)) / mass[i]
    rotors = columns.rotor_indices
    speed = np.where(result.samples.used, np.abs(result.samples.dq), 0.0)
    return FittedValues(
        mass, sigma[:, 0], com, com_sigma, _tensors(pi[:, 4:]), _tensors(sigma[:, 4:]), fit.parameters[rotors],
        fit.sigma[rotors], columns.friction_of(fit.parameters), _friction_sigma(result, cov), speed.max(axis=0),
        tuple(log_digests(result)), _about(result), columns.transmission is None,
    )  # fmt: skip


def _tensors(entries: Array) -> Array:
    out = np.empty((len(entries), 3, 3))
    for (a, b), column in zip(ROW_BY_ROW, entries.T, strict=True):
        out[:, a, b] = out[:, b, a] = column
    return out


def _friction_sigma(result: MotionIdentification, covariance: Array) -> dict[str, Array]:
    """Standard errors of the columns of a data file; NaN for a number that is not fitted."""
    columns, n = result.columns, result.arm.n
    sides = {"positive": "+", "negative": "-"}
    names = [f"{side}_{x}" for side in sides for x in ("coulomb", "viscous", "static")]
    out = {name: np.full(n, np.nan) for name in (*names, "offset")}
    for j, joint in enumerate(columns.joints):
        first = columns.of_joint(j).start
        at = {name: first + k for k, name in enumerate(joint.names)}
        for side, sign in sides.items():
            coulomb, viscous, drop = ([at[x] for x in (f"{name}{sign}", name) if x in at] for name in
                                      ("coulomb", "viscous", "stribeck"))  # fmt: skip
            out[f"{side}_coulomb"][j] = _sigma_of_sum(covariance, coulomb)
            out[f"{side}_viscous"][j] = _sigma_of_sum(covariance, viscous)
            out[f"{side}_static"][j] = _sigma_of_sum(covariance, [*coulomb, *drop])
        if "offset" in at:
            out["offset"][j] = _sigma_of_sum(covariance, [at["offset"]])
    return out


def _sigma_of_sum(covariance: Array, places: list[int]) -> float:
    return float(np.sqrt(max(0.0, float(covariance[np.ix_(places, places)].sum()))))


def log_digests(result: MotionIdentification) -> Iterable[LogDigest]:
    """The logs of an identification, in their order."""
    samples = result.samples
    for source in dict.fromkeys(samples.sources):
        numbers = [i for i, name in enumerate(samples.sources) if name == source]
        yield LogDigest(source, digest_of(Path(source)), int(np.isin(samples.recording, numbers).sum()))


def digest_of(path: Path) -> str:
    """SHA-256 of a file, or of the files of a folder one after the other by name; empty for what is neither."""
    files = [path] if path.is_file() else sorted(x for x in path.rglob("*") if x.is_file()) if path.is_dir() else []
    digest = hashlib.sha256()
    for file in files:
        with open(file, "rb") as stream:
            for chunk in iter(lambda: stream.read(_CHUNK), b""):
                digest.update(chunk)
    return digest.hexdigest() if files else ""


def _about(result: MotionIdentification) -> str:
    fit, rule = result.consistent, result.rule
    assert fit is not None
    chosen = "of most evidence" if fit.chosen else "as given"
    motors = "" if result.columns.transmission is None else "; rotors and friction were fitted to the motors: not here"
    known = f", known: {'; '.join(fit.constraints)}" if fit.constraints else ""
    return (
        f"bodies near reading {result.arm.reading}, deviation {fit.deviation:.3g} ({chosen}), "
        f"{result.equations} equations, {result.identified} of {result.base.count} base parameters identified, "
        f"friction {rule.friction}"
        f"{' with Stribeck terms' if rule.stribeck else ''}, positions through {rule.samples.cutoff} Hz, price "
        f"{np.nanmax(fit.price.rms):.2g} N m (N) RMS at the worst joint{known}{motors}; sigma: one standard error"
    )


READING = "fitted"
"""The name of the reading of a fitted arm."""
HOW = "least squares, bodies near the table"


def fitted_arm(arm: Arm, values: FittedValues) -> Arm:
    """The arm with the values; limits, gains and shapes stay, and where they were fitted to motors rotors and friction.

    `limits` hold friction that is the same both ways, as a URDF has it: the mean of the directions, no slope below 0.
    """
    links = tuple(_link(link, values, i) for i, link in enumerate(arm.chain.links))
    sources = {**arm.sources, **_sources(arm, values)}
    if not values.joints:
        return replace(arm, chain=replace(arm.chain, links=links), reading=READING, sources=sources, errata=())
    sources |= _joint_sources(arm, values)
    limits = tuple(_limits(old, model) for old, model in zip(arm.limits, values.friction, strict=True))
    return replace(
        arm, chain=replace(arm.chain, links=links), reading=READING, limits=limits, friction=_friction(values),
        sources=sources, errata=(),
    )  # fmt: skip


def _link(link: ChainLink, values: FittedValues, i: int) -> ChainLink:
    com, inertia = values.com[i], values.inertia[i] - steiner(float(values.mass[i]), values.com[i])
    rotor = rotor_of(link.rotor, values.armature[i]) if values.joints else link.rotor
    return replace(link, body=Body(float(values.mass[i]), com, inertia), rotor=rotor)


def rotor_of(table: Rotor | None, armature: float) -> Rotor:
    """A rotor of that inertia at the joint, with the gear ratio of the table's where one is known."""
    if table is None or table.reflected:
        return Rotor(1.0, float(armature), reflected=True)
    return Rotor(table.gear_ratio, float(armature) / table.gear_ratio**2)


def _friction(values: FittedValues) -> tuple[JointFriction, ...]:
    return tuple(
        replace(model, covered=float(v) if v > 0.0 else None)
        for model, v in zip(values.friction, values.covered, strict=True)
    )


def _limits(limits: JointLimits, model: JointFriction) -> JointLimits:
    viscous, coulomb = ((getattr(model.positive, x) + getattr(model.negative, x)) / 2 for x in ("viscous", "coulomb"))
    return replace(limits, viscous=max(0.0, viscous), coulomb=coulomb)


def _source(values: FittedValues, value: object, sigma: object, unit: str) -> tuple[Source, ...]:
    return (Source("", values.where, "fitted", _plain(value), unit, HOW, sigma=_plain(sigma)),)


def _sources(arm: Arm, values: FittedValues) -> dict[str, tuple[Source, ...]]:
    out: dict[str, tuple[Source, ...]] = {}
    for i, link in enumerate(arm.chain.links):
        out[f"{link.link}.mass"] = _source(values, values.mass[i], values.mass_sigma[i], "kg")
        out[f"{link.link}.com"] = _source(values, values.com[i], values.com_sigma[i], "m")
        out[f"{link.link}.inertia"] = _source(values, values.inertia[i], values.inertia_sigma[i], "kg m^2")
    return out


def _joint_sources(arm: Arm, values: FittedValues) -> dict[str, tuple[Source, ...]]:
    out: dict[str, tuple[Source, ...]] = {}
    for i, link in enumerate(arm.chain.links):
        turns = link.kind is JointKind.REVOLUTE
        force, slope = ("N m", "N m s/rad") if turns else ("N", "N s/m")
        rotor = _source(values, values.armature[i], values.armature_sigma[i], "kg m^2" if turns else "kg")
        out |= {f"{link.joint}.{name}": rotor for name in ("armature", "rotor_inertia")}
        for side, direction in (("positive", values.friction[i].positive), ("negative", values.friction[i].negative)):
            for name, unit in (("coulomb", force), ("viscous", slope)):
                sigma = values.friction_sigma[f"{side}_{name}"][i]
                out[f"{link.joint}.friction.{side}_{name}"] = _source(values, getattr(direction, name), sigma, unit)
        for name in ("coulomb", "viscous"):
            out[f"{link.joint}.{name}"] = out[f"{link.joint}.friction.positive_{name}"]
    return out


def _plain(value: object) -> object:
    listed = np.asarray(value).tolist()
    return _tuples(listed)


def _tuples(value: object) -> object:
    return tuple(_tuples(x) for x in value) if isinstance(value, list) else value
