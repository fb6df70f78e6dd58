"""A fitted arm as a model that every command takes (`lwr-dyn identify motion ... --out`): a data file, or a URDF.

Bodies, rotors and friction stand in place of the source's, each number with its standard error and the logs that it
comes from, whose digests stand in `[document]` of a data file. All other columns keep their source and kind.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lwr_dyn.arms.export.data_file import ColumnText, literal, quoted, table_text
from lwr_dyn.arms.papers.assembly import CONTRADICTED
from lwr_dyn.arms.papers.schema import FRICTION_OF_A_SIDE, LOAD, SIDES, TABLES, Column, ColumnRule, Paper
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError, MissingDataError
from lwr_dyn.foundation.files import check_writable, ends_in, write_file, write_folder
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.identification.log_digests import LogDigest, log_digests
from lwr_dyn.identification.motion.friction_rows import load_words
from lwr_dyn.identification.motion.motion_result import MotionIdentification, expected
from lwr_dyn.model.arm import Arm, JointLimits, Source
from lwr_dyn.model.chain import Body, ChainLink, JointKind, Rotor
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.model.inertial_parameters import TENSOR
from lwr_dyn.model.spatial import steiner

READING = "fitted"
"""The name of the reading of a fitted arm."""
UNITS = {
    "armature": ("kg m^2", "kg"), "coulomb": ("N m", "N"), "static": ("N m", "N"), "offset": ("N m", "N"),
    "viscous": ("N m s/rad", "N s/m"), "stribeck_velocity": ("rad/s", "m/s"), "covered": ("rad/s", "m/s"),
}  # fmt: skip
"""Quantities of a joint, and their units where it turns and where it slides."""
_FITTED = ("inertial", "rotors", "friction")
"""Tables that are written from the fit; the last two stay where they were fitted to motors."""
_MORE = {"inertia": ', about = "origin", axes = "frame", products = "tensor"'}


class Fitted(NamedTuple):
    """Numbers [SI] and their standard errors, (n, ...) each."""

    value: Array
    sigma: Array


@dataclass(frozen=True, slots=True, eq=False)
class FittedValues:
    """What a fit says of an arm of n joints, SI; tensors about the origins of the links' frames, in their axes. Errors
    are NaN, written `unknown`, where no torque shows a number.

    `mass` (n,), `com` (n, 3), `inertia` (n, 3, 3), `armature` (n,); `friction`, one model a joint, with
    `friction_sigma`: quantity of a direction ("positive_coulomb", ..., "offset", "load") -> (n,), NaN where there is
    none; `covered` (n,): the largest speed that was seen [rad/s or m/s], 0 for a joint that did not move. `joints` is
    False where rotors and friction were fitted to motors: those of the arm stay then, and these are not used.
    """

    mass: Fitted
    com: Fitted
    inertia: Fitted
    armature: Fitted
    friction: tuple[JointFriction, ...]
    friction_sigma: dict[str, Array]
    covered: Array
    logs: tuple[LogDigest, ...]
    about: str
    """How they were fitted."""
    joints: bool = True
    contradicted: str = ""
    """By what the log contradicts the bodies; empty where it does not."""

    @property
    def where(self) -> str:
        """The source of the numbers, for a data file."""
        return f"fitted to {', '.join(Path(log.source).name for log in self.logs)}; digests in [document]"

    @property
    def bodies(self) -> tuple[tuple[str, Fitted, str], ...]:
        """Name, numbers and unit of what a link has."""
        return ("mass", self.mass, "kg"), ("com", self.com, "m"), ("inertia", self.inertia, "kg m^2")


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
    shown = np.array(result.shown_sigma, dtype=np.float64)
    pi, sigma = (x[: columns.bodies].reshape(n, ten) for x in (fit.parameters, shown))
    com = pi[:, 1:4] / pi[:, :1]
    own = np.einsum("iaib->iab", cov[: columns.bodies, : columns.bodies].reshape(n, ten, n, ten))
    variance = np.diagonal(own, axis1=1, axis2=2)[:, 1:4] - 2.0 * com * own[:, 0, 1:4] + np.square(com) * own[:, 0, :1]
    com_sigma = np.sqrt(np.maximum(variance, 0.0)) / pi[:, :1] + 0.0 * sigma[:, 1:4]
    rotors = columns.rotor_indices
    covered = np.where(result.samples.used, np.abs(result.samples.dq), 0.0).max(axis=0)
    return FittedValues(
        Fitted(pi[:, 0], sigma[:, 0]), Fitted(com, com_sigma), Fitted(pi[:, TENSOR], sigma[:, TENSOR]),
        Fitted(fit.parameters[rotors], shown[rotors]), columns.friction_of(fit.parameters),
        _friction_sigma(result, cov), covered, tuple(log_digests(result.samples)), _about(result),
        columns.transmission is None, result.contradiction,
    )  # fmt: skip


def _friction_sigma(result: MotionIdentification, covariance: Array) -> dict[str, Array]:
    """Standard errors of the columns of a data file; NaN for a number that is not fitted."""
    columns, wanted = result.columns, {"offset": {"offset"}, LOAD: {LOAD}}
    for side, sign in zip(SIDES, "+-", strict=True):
        for name, sum_of in (("coulomb", ["coulomb"]), ("viscous", ["viscous"]), ("static", ["coulomb", "stribeck"])):
            wanted[f"{side}_{name}"] = {*sum_of, *(each + sign for each in sum_of)}
    out = {name: np.full(columns.n, np.nan) for name in wanted}
    for j, joint in enumerate(columns.joints):
        for name, parts in wanted.items():
            at = [columns.of_joint(j).start + k for k, each in enumerate(joint.names) if each in parts]
            if at:
                out[name][j] = np.sqrt(max(0.0, float(covariance[np.ix_(at, at)].sum())))
    return out


def _about(result: MotionIdentification) -> str:
    fit, rule = result.consistent, result.rule
    assert fit is not None
    motors = "" if result.columns.transmission is None else "; rotors and friction were fitted to the motors: not here"
    known = f", known: {'; '.join(fit.constraints)}" if fit.constraints else ""
    terms = " with Stribeck terms" if rule.stribeck else ""
    if rule.gains is not None:
        terms += f", gains known to {rule.gains:.3g}"
    if rule.load_friction:
        terms += f"; {load_words(result.information)}"
    return (
        f"bodies near reading {result.arm.reading}, expected off it {expected(fit)}, {result.equations} "
        f"equations, {result.identified} of {result.base.count} base parameters identified, friction {rule.friction}"
        f"{terms}, positions through {rule.samples.cutoff} Hz, price {np.nanmax(fit.price.rms):.2g} N m (N) RMS at the "
        f"worst joint{known}{motors}; sigma: one standard error, unknown where the number is that of the table"
    )


def fitted_arm(arm: Arm, values: FittedValues) -> Arm:
    """The arm with the values; limits, gains and shapes stay, and where they were fitted to motors rotors and friction.

    `limits` hold friction that is the same both ways, as a URDF has it: the mean of the directions, no slope below 0.
    """
    links = tuple(_link(link, values, i) for i, link in enumerate(arm.chain.links))
    fitted = replace(
        arm, chain=replace(arm.chain, links=links), reading=READING, sources={**arm.sources, **_sources(arm, values)},
        errata=(), caveats=replace(arm.caveats, contradicted=values.contradicted),
    )  # fmt: skip
    if not values.joints:
        return fitted
    limits = tuple(_limits(old, model) for old, model in zip(arm.limits, values.friction, strict=True))
    friction = tuple(
        replace(model, covered=float(v) or None) for model, v in zip(values.friction, values.covered, strict=True)
    )
    return replace(fitted, limits=limits, friction=friction)


def _link(link: ChainLink, values: FittedValues, i: int) -> ChainLink:
    mass, com = float(values.mass.value[i]), values.com.value[i]
    rotor = rotor_of(link.rotor, values.armature.value[i]) if values.joints else link.rotor
    return replace(link, body=Body(mass, com, values.inertia.value[i] - steiner(mass, com)), rotor=rotor)


def rotor_of(table: Rotor | None, armature: float) -> Rotor:
    """A rotor of that inertia at the joint, with the gear ratio of the table's where one is known."""
    if table is None or table.reflected:
        return Rotor(1.0, float(armature), reflected=True)
    return Rotor(table.gear_ratio, float(armature) / table.gear_ratio**2)


def _limits(limits: JointLimits, model: JointFriction) -> JointLimits:
    viscous, coulomb = ((getattr(model.positive, x) + getattr(model.negative, x)) / 2 for x in ("viscous", "coulomb"))
    return replace(limits, viscous=max(0.0, viscous), coulomb=coulomb)


def _sources(arm: Arm, values: FittedValues) -> dict[str, tuple[Source, ...]]:
    out: dict[str, tuple[Source, ...]] = {}
    how = "least squares, bodies near the table"

    def add(name: str, unit: str, value: object, sigma: object) -> None:
        out[name] = (Source("", values.where, "fitted", _plain(value), unit, how, sigma=_plain(sigma)),)

    for i, link in enumerate(arm.chain.links):
        for name, numbers, unit in values.bodies:
            add(f"{link.link}.{name}", unit, *(x[i] for x in numbers))
    for i, link in enumerate(arm.chain.links if values.joints else ()):
        for name in ("armature", "rotor_inertia"):
            add(f"{link.joint}.{name}", _unit("armature", link.kind), *(x[i] for x in values.armature))
        for quantity in (f"{side}_{name}" for side in SIDES for name in ("coulomb", "viscous")):
            side, name = quantity.split("_")
            value, sigma = getattr(getattr(values.friction[i], side), name), values.friction_sigma[quantity][i]
            for place in (f"friction.{quantity}", *((name,) if side == SIDES[0] else ())):
                add(f"{link.joint}.{place}", _unit(name, link.kind), value, sigma)
    _add_loads(arm, values, add)
    return out


def _add_loads(arm: Arm, values: FittedValues, add: Callable[[str, str, object, object], None]) -> None:
    """Shares of the load by which friction grows, where they were fitted."""
    if values.joints and any(model.load for model in values.friction):
        for joint, model, sigma in zip(arm.joint_names, values.friction, values.friction_sigma[LOAD], strict=True):
            add(f"{joint}.friction.{LOAD}", "1", model.load, sigma)


def _unit(name: str, kind: JointKind) -> str:
    return UNITS[name][kind is not JointKind.REVOLUTE]


def _plain(value: Any) -> object:
    return tuple(map(_plain, value)) if np.ndim(value) else float(value)


def fitted_paper_text(paper: Paper, values: FittedValues) -> str:
    """The text of a data file of reading `fitted`; `paper` is the arm's own under that which the fit started from."""
    what = "bodies, rotors and friction" if values.joints else "bodies"
    lines = [
        f"# {paper.name}, fitted to logs by lwr_dyn {VERSION}; numbers of kind fitted have a standard error (sigma)",
        "schema = 1",
        f"name = {quoted(paper.name)}",
        f"title = {quoted(paper.title.removesuffix(' (fitted to logs)') + ' (fitted to logs)')}",
        f"default_reading = {quoted(READING)}",
        "",
        "[document]",
        f"title = {quoted(paper.document.get('title', paper.title))}",
        f"origin = {quoted(f'reading {paper.reading.name} of {paper.file or paper.name}, sha256 {paper.digest}')}",
        f"logs = {quoted('; '.join(log.text() for log in values.logs))}",
        f"fit = {quoted(values.about)}",
        *([f"{CONTRADICTED} = {quoted(values.contradicted)}"] if values.contradicted else []),
        "",
        f"[reading.{READING}]",
        f"about = {quoted(f'{what} fitted to logs, the rest as reading {paper.reading.name}')}",
        "errata = []",
        "",
        "[joints]",
        f"names = [{', '.join(map(quoted, paper.joints))}]",
        f"kinds = [{', '.join(quoted(kind.value) for kind in paper.kinds)}]",
        "",
        *_kept(paper, _FITTED if values.joints else _FITTED[:1]),
        *table_text("inertial", [_fitted(x, f, u, values.where, _MORE.get(x, "")) for x, f, u in values.bodies]),
        *(_rotors(paper, values) if values.joints else ()),
        *(_friction(paper, values) if values.joints else ()),
    ]
    return "\n".join(lines).rstrip("\n") + "\n"


def _kept(paper: Paper, fitted: Sequence[str]) -> Iterator[str]:
    """The tables that no log says anything of, under the reading."""
    for table, rules in TABLES.items():
        if table in fitted:
            continue
        names = [name for name in rules if f"{table}.{name}" in paper.columns]
        if table == "base" and "mass" in names and paper.columns["base.mass"].kind == "estimated":
            names.remove("mass")  # it is what the links' estimated masses leave of the whole arm's
        columns = [_column(paper, name, paper.columns[f"{table}.{name}"], rules[name]) for name in names]
        lines = [f"convention = {quoted(paper.convention.value)}"] if table == "dh" else []
        lines += [_solids(paper)] if table == "drawing" and paper.solids is not None else []
        yield from table_text(table, columns, *lines)


def _column(paper: Paper, name: str, column: Column, rule: ColumnRule) -> ColumnText:
    values = _said(column.values if rule.per_joint else column.values[0])
    units = column.unit if rule.per_joint else column.unit[0]
    more = f", note = {quoted(column.note)}" if column.note else ""
    more += f", symbols = {literal(list(column.symbols))}" if column.symbols else ""
    more += f", sigma = {literal(_said(column.sigma if rule.per_joint else column.sigma[0]))}" if column.sigma else ""
    ids = dict.fromkeys(x for row in column.errata.values() for x in row)
    where = column.where + (f"; erratum {', '.join(ids)} of {paper.name} read" if ids else "")
    kinds = [p.kind for e in paper.errata if e.id in ids for p in e.patches if p.kind and p.at.startswith(column.name)]
    return ColumnText(name, values, units, where, [column.kind, *kinds][-1], more, column.how)


def _said(value: Any) -> Any:
    """Cells with None for NaN, which is written as unknown."""
    if isinstance(value, np.ndarray):
        return _said(value.tolist())
    if isinstance(value, list | tuple):
        return [_said(x) for x in value]
    return None if isinstance(value, float) and math.isnan(value) else value


def _solids(paper: Paper) -> str:
    solids = paper.solids
    assert solids is not None
    rows = ", ".join(
        f"{{ link = {quoted(s.link)}, from = {literal(list(s.start))}, to = {literal(list(s.end))}, "
        f"radius = {literal(s.radius)}, colour = {quoted(s.colour)} }}"
        for s in solids.cylinders
    )
    fields = f'unit = "m", where = {quoted(solids.where)}, kind = {quoted(solids.kind)}'
    return f"solids = {{ {fields}, rows = [{rows}] }}"


def _fitted(name: str, numbers: Fitted, unit: str | Sequence[str], where: str, more: str = "") -> ColumnText:
    sigma = f", sigma = {literal(_said(numbers.sigma))}{more}"
    return ColumnText(name, _said(numbers.value), unit, where, "fitted", sigma)


def _rotors(paper: Paper, values: FittedValues) -> list[str]:
    """Gear ratio of the source and fitted inertia, or the fitted inertia at the joint."""
    ratio, armature = paper.columns.get("rotors.gear_ratio"), values.armature
    if ratio is not None and np.isfinite(factors := np.square(ratio.si())).all():
        inertia = _fitted("inertia", Fitted(*(x / factors for x in armature)), "kg m^2", values.where)
        return table_text("rotors", [_column(paper, "gear_ratio", ratio, TABLES["rotors"]["gear_ratio"]), inertia])
    return table_text("rotors", [_fitted("armature", armature, _units(paper, "armature"), values.where)])


def _units(paper: Paper, name: str) -> list[str]:
    return [_unit(name, kind) for kind in paper.kinds]


def _friction(paper: Paper, values: FittedValues) -> list[str]:
    """Stribeck columns only where a joint has the term; one without has the Coulomb level, at any Stribeck speed."""
    columns, every = [], [getattr(model, side) for model in values.friction for side in SIDES]
    speeds = [x for one in every if (x := one.stribeck_velocity) is not None]
    for side in SIDES:
        for name in (x for x in FRICTION_OF_A_SIDE if any(getattr(one, x) is not None for one in every)):
            own = [getattr(model, side) for model in values.friction]
            otherwise = [min(speeds) if name == "stribeck_velocity" else one.coulomb for one in own]
            cells = [x if (v := getattr(one, name)) is None else v for one, x in zip(own, otherwise, strict=True)]
            sigma = values.friction_sigma.get(f"{side}_{name}", np.full(paper.n, np.nan))
            numbers = Fitted(np.array(cells), sigma)
            columns.append(_fitted(f"{side}_{name}", numbers, _units(paper, name), values.where))
    offsets = Fitted(np.array([model.offset for model in values.friction]), values.friction_sigma["offset"])
    columns.append(_fitted("offset", offsets, _units(paper, "offset"), values.where))
    if any(model.load for model in values.friction):
        shares = Fitted(np.array([model.load for model in values.friction]), values.friction_sigma[LOAD])
        columns.append(_fitted(LOAD, shares, "1", values.where))
    if (values.covered > 0.0).all():
        where = f"largest speed; {values.where}"
        columns.append(ColumnText("covered", values.covered, _units(paper, "covered"), where, "computed"))
    return table_text("friction", columns)


def check_fitted_path(path: str | Path, paper: Paper | None) -> None:
    """Raise `FileAccessError` now for a path that a fitted arm could not be written to later."""
    if not ends_in(path, ".toml", ".urdf"):
        raise FileAccessError(str(path), f"ends in {Path(path).suffix or 'nothing'!r}", "a path in .toml or .urdf")
    if paper is None and ends_in(path, ".toml"):
        allowed = "a .urdf, or a robot from a data file (lwr-dyn urdf ROBOT --out arm.toml makes one)"
        raise FileAccessError(str(path), "the robot comes from a .urdf", allowed)
    check_writable(path)


def write_fitted(path: str | Path, result: MotionIdentification, paper: Paper | None) -> tuple[Path, ...]:
    """Write the arm of an identification; the files are returned.

    Parameters
    ----------
    path : str or path
        Ends in .toml (a data file, for an arm from a data file) or .urdf (with sidecars, for any arm).
    paper : Paper or None
        The arm's data file under its reading; None for an arm from a URDF.

    Raises
    ------
    FileAccessError
        Another ending, a .toml for an arm from a URDF, or a place that cannot be written.
    MissingDataError
        The arm has no masses.
    """
    check_fitted_path(path, paper)
    target, values = Path(path), fitted_values(result)
    if ends_in(path, ".toml"):
        assert paper is not None
        write_file(target, fitted_paper_text(paper, values))
        return (target,)
    files = model_files(fitted_arm(result.arm, values), target.stem)
    write_folder(target.parent, files)
    return tuple(target.parent / name for name in files)
