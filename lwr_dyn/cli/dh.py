"""`lwr-dyn dh`: any arm as a Denavit-Hartenberg table, or as a data file that loads again."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypedDict

import click
import numpy as np

from lwr_dyn.arms.export.data_file import data_file_text
from lwr_dyn.arms.export.dh_table import DHTable, dh_table, residual
from lwr_dyn.cli.options import Loading, OneOf, robot_options, say_caveats, show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import check_writable, ends_in, write_file
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.caveats import ALL, KINEMATICS
from lwr_dyn.model.chain import Convention, JointKind
from lwr_dyn.model.spatial import Pose, to_rpy


@click.command("dh")
@robot_options
@with_shared("--convention", "; both if not given", kind=OneOf([c.value for c in Convention]))
@with_shared("--out", " a .toml: the arm as a data file, with bodies, limits, rotors, friction (standard)")
@with_shared("--json as_json")
def command(robot: str, loading: Loading, convention: str | None, out: str | None, as_json: bool) -> None:
    """ROBOT as a Denavit-Hartenberg table, computed from its joint axes, with what rows cannot carry."""
    arm = loading.arm(robot, KINEMATICS if out is None else ALL)
    if out is not None:
        if not ends_in(out, ".toml"):
            raise FileAccessError(out, f"ends in {Path(out).suffix or 'nothing'!r}", "a path that ends in .toml")
        check_writable(out)
        write_file(out, data_file_text(arm, Convention(convention or Convention.STANDARD.value)))
        say_caveats()
        click.echo(f"wrote {out}; next: lwr-dyn check {out}")
        return
    tables = [dh_table(arm, c) for c in Convention if convention in (None, c.value)]
    show(_document(arm, tables), as_json)


class RowRecord(TypedDict):
    """A joint's row; its coordinate is added to theta_offset (to d, if it slides)."""

    joint: str
    kind: Annotated[Literal["revolute", "prismatic"], "Whether it turns or slides."]
    a: Annotated[float, "m."]
    alpha: Annotated[float, "rad."]
    beta: Annotated[float, "A turn about y after alpha, rad; 0 in most tables."]
    d: Annotated[float, "m."]
    theta_offset: Annotated[float, "rad."]


class TableRecord(TypedDict):
    """An arm in one convention."""

    convention: Annotated[Literal["standard", "modified"], "Of Denavit and Hartenberg."]
    rows: list[RowRecord]
    base: Annotated[list[list[float]], "DH frame 0 in the base, 4 x 4, metres."]
    flange: Annotated[list[list[float]], "The flange in the last DH frame, 4 x 4, metres."]
    residual_m: Annotated[float, "Flange by the table against the model, m."]
    residual_rad: Annotated[float, "The same in angle, rad."]


def _document(arm: Arm, tables: Sequence[DHTable]) -> Document:
    records = [_record(arm, table) for table in tables]
    facts = [
        Fact("robot", arm.name, "Name of the robot."), Fact("reading", arm.reading, "Its reading.", kind=str),
        Fact("tables", records, "One a convention.", kind=list[TableRecord]),
    ]  # fmt: skip
    return Document("", "", [Section("", _parts(arm, table)) for table in tables], "lwr-dyn dh", facts=facts)


def _parts(arm: Arm, table: DHTable) -> list[Table | Fact | Note]:
    left, turned = residual(table, arm), any(row.beta for row in table.rows)
    plain = residual(table.without_beta(), arm) if turned else left
    return [
        _table(arm, table),
        Fact(None, f"DH frame 0 {_placed(table.base, 'in the base')}", head="base"),
        Fact(None, _placed(table.flange, f"in DH frame {arm.n}"), head="flange"),
        Fact(None, f"{left.metres:.2g} m, {left.radians:.2g} rad", head="flange by the table against the model"),
        Note("beta, a turn about y after alpha: these axes are almost parallel, and DH alone would put their common "
             f"normal more than 100 m away; without beta {plain.metres:.1e} m, {plain.radians:.1e} rad", turned),
    ]  # fmt: skip


def _table(arm: Arm, table: DHTable) -> Table:
    """Angles in degrees, lengths in metres; the joint's own coordinate is q."""
    order = "Rz(theta) Tz(d) Tx(a) Rx(alpha)" if table.convention is Convention.STANDARD else (
        "Tx(a) Rx(alpha) Rz(theta) Tz(d)"
    )  # fmt: skip
    beta = any(row.beta for row in table.rows)
    heads = [Heading("joint"), Heading("a", "m", _length), Heading("alpha", "deg", _angle)]
    heads += [Heading("beta", "deg", _angle)] if beta else []
    heads += [Heading("d", "m"), Heading("theta", "deg")]
    rows = []
    for name, kind, row in zip(arm.joint_names, table.kinds, table.rows, strict=True):
        theta, d = _angle(row.theta_offset), _length(row.d)
        turns = kind is JointKind.REVOLUTE
        cells = [name, row.a, row.alpha, *([row.beta] if beta else [])]
        rows.append((*cells, d if turns else _moved(d), _moved(theta) if turns else theta))
    return Table(f"{arm.name}, reading {arm.reading}: {table.convention.value} DH, {order}", heads, rows)


def _moved(constant: str) -> str:
    """The joint's coordinate and the constant part of it."""
    return "q" if float(constant) == 0.0 else f"q {constant[0] if constant[0] == '-' else '+'} {constant.lstrip('-')}"


def _length(metres: float) -> str:
    return f"{round(metres, 9) + 0.0:.9g}"


def _angle(radians: float) -> str:
    return f"{round(float(np.degrees(radians)), 7) + 0.0:.10g}"


def _placed(pose: Pose, where: str) -> str:
    if pose.is_identity():
        return f"is {where.removeprefix('in ')}" if "base" not in where else "is the base"
    xyz = ", ".join(_length(x) for x in pose.position)
    rpy = ", ".join(_angle(x) for x in to_rpy(pose.rotation))
    return f"at {xyz} m, roll, pitch, yaw {rpy} deg {where}"


def _record(arm: Arm, table: DHTable) -> dict[str, Any]:
    left = residual(table, arm)
    names = ("a", "alpha", "beta", "d", "theta_offset")
    rows = [
        {"joint": joint, "kind": kind.value} | {name: getattr(row, name) for name in names}
        for joint, kind, row in zip(arm.joint_names, table.kinds, table.rows, strict=True)
    ]
    return {
        "convention": table.convention.value,
        "rows": rows,
        "base": table.base.matrix(),
        "flange": table.flange.matrix(),
        "residual_m": left.metres,
        "residual_rad": left.radians,
    }
