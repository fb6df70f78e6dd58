"""A fitted arm as a model that every command takes (`lwr-dyn identify motion ... --out`): a data file, or a URDF.

Bodies, rotors and friction stand in place of the source's, each number with its standard error and the logs that it
comes from, whose digests stand in `[document]` of a data file. All other columns keep their source and kind.
"""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.export.data_file import ColumnText, literal, quoted, table_text
from lwr_dyn.arms.papers.assembly import CONTRADICTED
from lwr_dyn.arms.papers.schema import FRICTION_OF_A_SIDE, LOAD, SIDES, TABLES, Column, ColumnRule, Paper
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import check_writable, ends_in, write_file, write_folder
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.identification.fitted import READING, Fitted, FittedValues, fitted_arm, fitted_values, unit_of
from lwr_dyn.identification.motion.motion_result import MotionIdentification

_FITTED = ("inertial", "rotors", "friction")
"""Tables that are written from the fit; the last two stay where they were fitted to motors."""
_MORE = {"inertia": ', about = "origin", axes = "frame", products = "tensor"'}


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
    return [unit_of(name, kind) for kind in paper.kinds]


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
