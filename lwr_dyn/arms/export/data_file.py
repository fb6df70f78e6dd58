"""An arm as a data file: a DH table in SI with its bodies, limits, rotors and friction; it loads as the same arm.

Every column is `computed` (or what its weakest source is: estimated, assumed, fitted), and `where` names the cells or
elements that it comes from. What the form has no place for is said in `[document]`: link names, shapes, transmissions.
Numbers are written by repr, which is read back bit-exact.
"""

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.export.dh_table import DHTable, dh_table, residual
from lwr_dyn.arms.papers.assembly import CONTRADICTED, LEFT_IN_PLACE, sort_of
from lwr_dyn.arms.papers.schema import FRICTION_OF_A_SIDE, KINDS, LOAD, SIDES, SIGMOID, TABLES, UNKNOWN
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, Convention
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.model.spatial import Pose, to_rpy


@dataclass(frozen=True, slots=True)
class ColumnText:
    """A column to be written: None in `values` is unknown."""

    name: str
    values: Any
    unit: str | Sequence[str]
    where: str
    kind: str = "computed"
    more: str = ""
    """Further fields as TOML, each with a comma before it."""
    how: str = ""
    """Of what is estimated or assumed, in a few words."""

    def line(self) -> str:
        """The column as an inline table."""
        fields = f"values = {literal(self.values)}, unit = {literal(_short(self.unit))}{self.more}"
        how = f", how = {quoted(self.how)}" if self.how else ""
        return f"{self.name} = {{ {fields}, where = {quoted(self.where)}, kind = {quoted(self.kind)}{how} }}"


def table_text(name: str, columns: Sequence[ColumnText], *lines: str) -> list[str]:
    """A table of columns, after lines of its own; nothing where there are no columns and no lines."""
    return [f"[{name}]", *lines, *(column.line() for column in columns), ""] if columns or lines else []


def literal(value: Any) -> str:
    """A number, a text, None (unknown) or a nested list as TOML.

    >>> literal([1, 0.5, None, np.float64(-0.0)])
    '[1, 0.5, "unknown", 0.0]'
    """
    if isinstance(value, np.ndarray | np.generic):
        return literal(value.tolist())
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(literal, value))}]"
    if value is None:
        return quoted(UNKNOWN)
    if isinstance(value, str):
        return quoted(value)
    return repr(value + 0.0) if isinstance(value, float) else repr(value)  # no negative zero


def quoted(text: str) -> str:
    r"""A basic string of TOML.

    >>> print(quoted('a "b" \x7f'))
    "a \"b\" \u007f"
    """
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _short(unit: str | Sequence[str]) -> str | list[str]:
    """One unit where all are the same."""
    units = [unit] if isinstance(unit, str) else list(unit)
    return units[0] if len(set(units)) == 1 else units


Columns = dict[str, Sequence[float | None]]
"""Column -> one value a joint."""
READING = "computed"
"""The name of the only reading."""

_UNITS = {
    "angle": "rad", "length": "m", "angular velocity": "rad/s", "velocity": "m/s", "torque": "N m", "force": "N",
    "angular damping": "N m s/rad", "damping": "N s/m", "angular stiffness": "N m/rad", "stiffness": "N/m",
    "angular integral gain": "N m/(rad s)", "integral gain": "N/(m s)", "inertia": "kg m^2", "mass": "kg",
    "number": "1", "acceleration": "m/s^2", "volume": "m^3", "slope of a sigmoid": "s/rad",
}  # fmt: skip
"""Quantity -> its SI unit."""

_ROW = re.compile(r"(?<=/joint)\[@name='[^']*'\]|(?<=/transmission)\[joint/@name='[^']*'\]|(?<=\.values)\[\d+\]")
"""Which joint a cell is of: the rows of the columns are in the joints' order."""
_LINEAR_LAST = ("limits", "poses", "friction", "gains", "rotors", "elasticity")
"""Tables whose columns name the quantity of a turning joint first, that of a sliding one last."""


def data_file_text(arm: Arm, convention: Convention = Convention.STANDARD) -> str:
    """The arm as the text of a data file, in frames of a DH table of that convention."""
    table = dh_table(arm, convention)
    left, origin = residual(table, arm), Path(arm.file).name if arm.file else f"robot {arm.name}"
    lines = [
        f"# {arm.name}, reading {arm.reading}, as a {convention.value} DH table; written by lwr_dyn from {origin}",
        f"# flange by the table against the source: {left.metres:.1e} m, {left.radians:.1e} rad",
        *(f"# {line}" for line in [arm.caveat()] if line),
        "schema = 1",
        f"name = {quoted(arm.name)}",
        f"title = {quoted(f'{arm.title} (computed)')}",
        f"default_reading = {quoted(READING)}",
        "",
        "[document]",
        f"title = {quoted(arm.title)}",
        f"origin = {quoted(f'{origin}, sha256 {arm.digest}' if arm.digest else origin)}",
        *(f"{key} = {quoted(text)}" for key, text in _notes(arm).items()),
        "",
        f"[reading.{READING}]",
        f"about = {quoted(f'computed from {origin}')}",
        "errata = []",
        "",
        "[joints]",
        f"names = [{', '.join(map(quoted, arm.joint_names))}]",
        f"kinds = [{', '.join(quoted(link.kind.value) for link in arm.chain.links)}]",
        *([f"torques = {quoted(arm.torques)}"] if arm.torques else []),
        "",
        *_kinematics(arm, table, origin),
        *_per_joint(arm, origin),
        *_inertial(arm, table, origin),
    ]
    return "\n".join(lines).rstrip("\n") + "\n"


def _notes(arm: Arm) -> dict[str, str]:
    """What the file has no place for."""
    out: dict[str, str] = {}
    if arm.caveats.left_in_place:
        out[LEFT_IN_PLACE] = " ".join(arm.caveats.left_in_place)
    if arm.caveats.contradicted:
        out[CONTRADICTED] = arm.caveats.contradicted
    out["links"] = ", ".join(f"link_{k} is {x.link}" for k, x in enumerate(arm.chain.links, start=1))
    if arm.loaded_with:
        out["loaded_with"] = "; ".join(f"{key} {value}" for key, value in arm.loaded_with.items())
    lacks = ["shapes, names of links and frames, transmissions, which joints are continuous"] if arm.layout else []
    lacks += [f"limits of {name}: {x.lower} to {x.upper}" for name, x in _without_range(arm).items()]
    lacks += ["drawn cylinders"] if arm.drawing.cylinders else []
    return out | ({"lacks": "; ".join(lacks)} if lacks else {})


def _without_range(arm: Arm) -> dict[str, JointLimits]:
    """Joints whose lower and upper limit are one number, as a URDF that does not know them writes 0 and 0."""
    pairs = zip(arm.joint_names, arm.limits, strict=True)
    return {name: x for name, x in pairs if x.lower is not None and x.lower == x.upper}


def _kinematics(arm: Arm, table: DHTable, origin: str) -> Iterator[str]:
    """The tables base, dh and flange."""
    joints = [f"{joint}.{part}" for joint in arm.joint_names for part in ("before", "after", "dh")]
    where, kind = _cells(arm, joints, origin)
    placed = _pose(table.base, f"axis of {arm.joint_names[0]} in the base; {where}", kind)
    base = [ColumnText("gravity", arm.chain.gravity, "m/s^2", origin), *placed]
    if arm.ratings.base_mass is not None:
        base.append(ColumnText("mass", arm.ratings.base_mass, "kg", origin))
    yield from table_text("base", base)
    numbers = {name: [float(getattr(row, name)) for row in table.rows] for name in ("alpha", "a", "d", "theta_offset")}
    if any(row.beta for row in table.rows):
        numbers["beta"] = [row.beta for row in table.rows]
    where = f"common normals of the joint axes; {where}"
    columns = [ColumnText(x, v, "m" if x in ("a", "d") else "rad", where, kind) for x, v in numbers.items()]
    columns = [_marked(arm, "dh", column) for column in columns]
    yield from table_text("dh", columns, f"convention = {quoted(table.convention.value)}")
    where, kind = _cells(arm, [*joints[-3:], "flange"], origin)
    yield from table_text("flange", _pose(table.flange, f"what the rows leave; {where}", kind))


def _pose(pose: Pose, where: str, kind: str) -> list[ColumnText]:
    if pose.is_identity():
        return []
    rpy = list(to_rpy(pose.rotation))
    return [ColumnText("xyz", pose.position, "m", where, kind), ColumnText("rpy", rpy, "rad", where, kind)]


def _per_joint(arm: Arm, origin: str) -> Iterator[str]:
    """The tables limits, ratings, poses, rotors, transmission, friction, gains, elasticity and drawing, where known."""
    for table, columns in _values(arm).items():
        texts = [_column(arm, table, name, values, origin) for name, values in columns.items()]
        yield from table_text(table, [text for text in texts if text is not None])


def _column(arm: Arm, table: str, name: str, values: Sequence[float | None], origin: str) -> ColumnText | None:
    if all(value is None for value in values):
        return None
    rule = TABLES[table][name]
    part = {"friction": f"friction.{name}" if arm.friction else name, "gains": f"gains.{name}", "rotors": "armature",
            "transmission": "motors"}.get(table, name)  # fmt: skip
    quantities = [f"{joint}.{part}" for joint in arm.joint_names]
    if table == "rotors":
        quantities += [f"{joint}.{x}" for joint in arm.joint_names for x in ("gear_ratio", "rotor_inertia")]
    where, kind = _cells(arm, quantities, origin)
    linear = table in _LINEAR_LAST and len(rule.quantities) > 1
    units = [_UNITS[rule.quantities[-1 if linear and not turns else 0]] for turns in arm.chain.turning]
    given = list(values) if rule.per_joint else values[0]
    return _marked(arm, table, ColumnText(name, given, units, where, kind))


def _marked(arm: Arm, table: str, column: ColumnText) -> ColumnText:
    """The column with the kind and the way of what the arm carries as estimated or assumed."""
    what = sort_of(f"{table}.{column.name}")
    found = next((one for one in arm.caveats.estimates if one.what == what), None)
    return column if found is None else replace(column, kind=found.kind, how=found.how)


def _values(arm: Arm) -> dict[str, Columns]:
    """Table -> its columns."""
    names = ("lower", "upper", "velocity", "effort")
    ratings: Columns
    limits: Columns = {x: [getattr(j, x) for j in arm.limits] for x in names}
    for side in ("lower", "upper"):
        pairs = zip(arm.joint_names, limits[side], strict=True)
        limits[side] = [None if name in _without_range(arm) else value for name, value in pairs]
    if not all(any(x is not None for x in limits[side]) for side in ("lower", "upper")):
        del limits["lower"], limits["upper"]
    ratings = {x: [getattr(arm.ratings, x)] for x in ("payload", "mass", "reach", "envelope_volume")}
    out: dict[str, Columns] = {"limits": limits, "ratings": ratings}
    if arm.mastering:
        out["poses"] = {"mastering": arm.mastering}
    out |= {"rotors": _rotors(arm), "friction": _friction(arm)}
    if arm.transmission is not None:
        out["transmission"] = _motors(arm.transmission.matrix)
    if arm.gains is not None:
        gains = {"kp": arm.gains.Kp, "ki": arm.gains.Ki, "kd": arm.gains.Kd, "effort": arm.gains.effort}
        out["gains"] = {name: value.tolist() for name, value in gains.items() if value is not None}
    if arm.elasticity is not None:
        out["elasticity"] = {x: getattr(arm.elasticity, x).tolist() for x in ("stiffness", "damping")}
    if arm.drawing.radius or arm.drawing.pedestal:
        radius = {"radius": list(arm.drawing.radius)} if arm.drawing.radius else {}
        out["drawing"] = {"pedestal": [arm.drawing.pedestal], **radius}
    return out


def _motors(T: Array) -> Columns:
    """The motor map as one ratio a joint and signs, or as a matrix where a joint's motors have several ratios."""
    ratio = np.abs(T).max(axis=0)
    plain = bool(np.isin(T / ratio, (-1.0, 0.0, 1.0)).all())
    return {"ratio": ratio.tolist(), "signs": (T / ratio).tolist()} if plain else {"matrix": T.tolist()}


def _rotors(arm: Arm) -> Columns:
    """Gear ratio and inertia, or the inertia at the joint alone where one ratio is not known."""
    rotors = [link.rotor for link in arm.chain.links]
    if any(rotor is not None and rotor.reflected for rotor in rotors):
        return {"armature": [None if rotor is None else rotor.armature for rotor in rotors]}
    return {
        "gear_ratio": [None if rotor is None else rotor.gear_ratio for rotor in rotors],
        "inertia": [None if rotor is None else rotor.inertia for rotor in rotors],
    }


def _friction(arm: Arm) -> Columns:
    """A pair for both directions, columns per direction, or those of a sigmoid."""
    if not arm.friction or any(model is None for model in arm.friction):
        return {name: [getattr(limit, name) for limit in arm.limits] for name in ("viscous", "coulomb")}
    models: list[JointFriction] = [model for model in arm.friction if model is not None]
    if all(model.sigmoid is not None for model in models):
        return {name: [getattr(m.sigmoid, name.removeprefix("sigmoid_")) for m in models] for name in SIGMOID}
    sides: Columns = {
        f"{side}_{name}": [getattr(getattr(model, side), name) for model in models]
        for side in SIDES
        for name in FRICTION_OF_A_SIDE
    }
    whole: Columns = {name: values for name, values in sides.items() if None not in values}
    whole["offset"] = [model.offset for model in models]
    if any(model.load for model in models):
        whole[LOAD] = [model.load for model in models]
    covered: Sequence[float | None] = [model.covered for model in models]
    return {**whole, "covered": covered} if None not in covered else whole


def _inertial(arm: Arm, table: DHTable, origin: str) -> list[str]:
    """The bodies in the table's frames; one that is not given, or given in part, is unknown."""
    bodies = [link.body for link in table.chain(arm).links]
    if all(body is None for body in bodies):
        return []
    given = [None if body is None or body.unknown else body for body in bodies]
    more = ', about = "com", axes = "frame", products = "tensor"'
    columns = [
        ColumnText("mass", [x and x.mass for x in given], "kg", *_of_links(arm, "mass", origin)),
        ColumnText("com", [x and x.com for x in given], "m", *_of_links(arm, "com", origin)),
        ColumnText("inertia", [_tensor(x) for x in given], "kg m^2", *_of_links(arm, "inertia", origin), more),
    ]
    return table_text("inertial", [_marked(arm, "inertial", column) for column in columns])


def _tensor(body: Body | None) -> list[list[float]] | None:
    """The exactly symmetric tensor, which the reader asks for."""
    if body is None:
        return None
    upper = np.triu(body.inertia_com)
    rows: list[list[float]] = (upper + np.triu(upper, 1).T).tolist()
    return rows


def _of_links(arm: Arm, part: str, origin: str) -> tuple[str, str]:
    return _cells(arm, [f"{link.link}.{part}" for link in arm.chain.links], origin)


def _cells(arm: Arm, quantities: Sequence[str], origin: str) -> tuple[str, str]:
    """The sources of quantities as one text, each place with its cells, and the weakest of their kinds."""
    sources = [source for name in quantities for source in arm.sources.get(name, ())]
    places: dict[str, dict[str, None]] = {}
    for source in sources:
        places.setdefault(source.where, {})[_ROW.sub("", source.cell)] = None
    text = "; ".join(f"{where}: {', '.join(cells)}" for where, cells in places.items()) or origin
    weak = [source.kind for source in sources if source.kind in KINDS[KINDS.index("fitted") :]]
    return text, weak[-1] if weak else "computed"
