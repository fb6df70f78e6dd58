"""Files of a fitted arm: a data file, or a URDF with its sidecars.

A data file with fitted numbers: the tables of the arm's own file as its reading has them, but for what was fitted.

Masses, centres of mass, tensors, rotors and friction have kind `fitted`, a standard error a cell (`sigma`) and the logs
as their source; the logs' digests stand in `[document]`. All other columns keep their source and kind.
"""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.export.data_file import ColumnText, literal, quoted, table_text
from lwr_dyn.arms.papers.schema import FRICTION_OF_A_SIDE, SIDES, TABLES, Column, ColumnRule, Paper
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import check_writable, ends_in, write_file, write_folder
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.identification.fitted.fitted_arm import READING, FittedValues, fitted_arm, fitted_values
from lwr_dyn.identification.motion.motion_result import MotionIdentification
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.friction import JointFriction

_FITTED = ("inertial", "rotors", "friction")
"""Tables that are written from the fit; the last two stay where they were fitted to motors."""


def fitted_paper_text(paper: Paper, values: FittedValues) -> str:
    """The text of a data file of reading `fitted`.

    Parameters
    ----------
    paper : Paper
        The arm's own file under the reading that the fit started from.
    values : FittedValues
    """
    what = "bodies, rotors and friction" if values.joints else "bodies"
    lines = [
        f"# {paper.name}, fitted to logs by lwr_dyn {VERSION}; numbers of kind fitted have a standard error (sigma)",
        "schema = 1",
        f"name = {quoted(paper.name)}",
        f"title = {quoted(f'{_unfitted(paper.title)} (fitted to logs)')}",
        f"default_reading = {quoted(READING)}",
        "",
        "[document]",
        f"title = {quoted(paper.document.get('title', paper.title))}",
        f"origin = {quoted(f'reading {paper.reading.name} of {paper.file or paper.name}, sha256 {paper.digest}')}",
        f"logs = {quoted('; '.join(log.text() for log in values.logs))}",
        f"fit = {quoted(values.about)}",
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
        *_inertial(values),
        *(_rotors(paper, values) if values.joints else ()),
        *(_friction(paper, values) if values.joints else ()),
    ]
    return "\n".join(lines).rstrip("\n") + "\n"


def _unfitted(title: str) -> str:
    return title.removesuffix(" (fitted to logs)")


def _kept(paper: Paper, fitted: Sequence[str]) -> Iterator[str]:
    """The tables that no log says anything of, under the reading."""
    for table, rules in TABLES.items():
        if table in fitted:
            continue
        names = [name for name in rules if f"{table}.{name}" in paper.columns and not _outdated(paper, table, name)]
        columns = [_column(paper, name, paper.columns[f"{table}.{name}"], rules[name]) for name in names]
        lines = [f"convention = {quoted(paper.convention.value)}"] if table == "dh" else []
        lines += [_solids(paper)] if table == "drawing" and paper.solids is not None else []
        yield from table_text(table, columns, *lines)


def _outdated(paper: Paper, table: str, name: str) -> bool:
    """An estimated mass of the base: it is what the links' estimated masses leave of the whole arm's."""
    return (table, name) == ("base", "mass") and paper.columns["base.mass"].kind == "estimated"


def _column(paper: Paper, name: str, column: Column, rule: ColumnRule) -> ColumnText:
    values = _said(column.values if rule.per_joint else column.values[0])
    units = column.unit if rule.per_joint else column.unit[0]
    more = f", note = {quoted(column.note)}" if column.note else ""
    more += f", symbols = {literal(list(column.symbols))}" if column.symbols else ""
    more += f", sigma = {literal(_said(column.sigma if rule.per_joint else column.sigma[0]))}" if column.sigma else ""
    ids = dict.fromkeys(x for row in column.errata.values() for x in row)
    where = column.where + (f"; erratum {', '.join(ids)} of {paper.name} read" if ids else "")
    kinds = [p.kind for e in paper.errata if e.id in ids for p in e.patches if p.kind and p.at.startswith(column.name)]
    return ColumnText(name, values, units, where, [column.kind, *kinds][-1], more)


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
    rows = [
        f"{{ link = {quoted(s.link)}, from = {literal(list(s.start))}, to = {literal(list(s.end))}, "
        f"radius = {literal(s.radius)}, colour = {quoted(s.colour)} }}"
        for s in solids.cylinders
    ]
    fields = f'unit = "m", where = {quoted(solids.where)}, kind = {quoted(solids.kind)}'
    return f"solids = {{ {fields}, rows = [{', '.join(rows)}] }}"


def _fitted(name: str, values: Any, sigma: Any, unit: str | Sequence[str], where: str, more: str = "") -> ColumnText:
    return ColumnText(name, _said(values), unit, where, "fitted", f", sigma = {literal(_said(sigma))}{more}")


def _inertial(values: FittedValues) -> list[str]:
    where, axes = values.where, ', about = "origin", axes = "frame", products = "tensor"'
    columns = [
        _fitted("mass", values.mass, values.mass_sigma, "kg", where),
        _fitted("com", values.com, values.com_sigma, "m", where),
        _fitted("inertia", values.inertia, values.inertia_sigma, "kg m^2", where, axes),
    ]
    return table_text("inertial", columns)


def _rotors(paper: Paper, values: FittedValues) -> list[str]:
    """Gear ratio of the source and fitted inertia, or the fitted inertia at the joint."""
    ratio = paper.columns.get("rotors.gear_ratio")
    if ratio is not None and np.isfinite(factors := np.square(ratio.si())).all():
        inertia = _fitted("inertia", values.armature / factors, values.armature_sigma / factors, "kg m^2", values.where)
        return table_text("rotors", [_column(paper, "gear_ratio", ratio, TABLES["rotors"]["gear_ratio"]), inertia])
    units = ["kg m^2" if kind is JointKind.REVOLUTE else "kg" for kind in paper.kinds]
    return table_text("rotors", [_fitted("armature", values.armature, values.armature_sigma, units, values.where)])


def _friction(paper: Paper, values: FittedValues) -> list[str]:
    turning = [kind is JointKind.REVOLUTE for kind in paper.kinds]
    words = {"coulomb": ("N m", "N"), "viscous": ("N m s/rad", "N s/m"), "static": ("N m", "N")}
    columns = []
    for side in SIDES:
        for name in (x for x in FRICTION_OF_A_SIDE if _wanted(values.friction, x)):
            cells = [_cell(model, side, name, values.friction) for model in values.friction]
            sigma = values.friction_sigma.get(f"{side}_{name}", np.full(len(cells), np.nan))
            units = [words.get(name, ("rad/s", "m/s"))[0 if turns else 1] for turns in turning]
            columns.append(_fitted(f"{side}_{name}", cells, sigma, units, values.where))
    units = ["N m" if turns else "N" for turns in turning]
    offsets = [model.offset for model in values.friction]
    columns.append(_fitted("offset", offsets, values.friction_sigma["offset"], units, values.where))
    if (values.covered > 0.0).all():
        speeds = ["rad/s" if turns else "m/s" for turns in turning]
        columns.append(ColumnText("covered", values.covered, speeds, f"largest speed; {values.where}", "computed"))
    return table_text("friction", columns)


def _wanted(friction: tuple[JointFriction, ...], name: str) -> bool:
    """Stribeck columns only where a joint has the term."""
    given = (getattr(side, name) for model in friction for side in (model.positive, model.negative))
    return any(value is not None for value in given)


def _cell(model: JointFriction, side: str, name: str, friction: tuple[JointFriction, ...]) -> float:
    """A number of a direction; a joint without a Stribeck term has the Coulomb level, at any Stribeck speed."""
    direction = getattr(model, side)
    value = getattr(direction, name)
    if value is None and name == "stribeck_velocity":
        known = [x for m in friction for d in (m.positive, m.negative) if (x := d.stribeck_velocity) is not None]
        return float(min(known))
    return float(direction.coulomb if value is None else value)


ENDINGS = (".toml", ".urdf")


def check_fitted_path(path: str | Path, paper: Paper | None) -> None:
    """Raise `FileAccessError` now for a path that a fitted arm could not be written to later."""
    if not ends_in(path, *ENDINGS):
        raise FileAccessError(str(path), f"ends in {Path(path).suffix or 'nothing'!r}", "a path in .toml or .urdf")
    if paper is None and ends_in(path, ".toml"):
        allowed = "a .urdf, or a robot from a data file (lwr-dyn urdf ROBOT --out arm.toml makes one)"
        raise FileAccessError(str(path), "the robot comes from a .urdf", allowed)
    check_writable(path)


def write_fitted(path: str | Path, result: MotionIdentification, paper: Paper | None) -> tuple[Path, ...]:
    """Write the arm of an identification.

    Parameters
    ----------
    path : str or path
        Ends in .toml (a data file, for an arm from a data file) or .urdf (with sidecars, for any arm).
    result : MotionIdentification
    paper : Paper or None
        The arm's data file under its reading; None for an arm from a URDF.

    Returns
    -------
    tuple of Path
        The files.

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
