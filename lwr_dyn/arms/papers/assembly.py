"""Paper -> Arm: columns in SI become DH rows, bodies, rotors, friction and limits; each quantity keeps its cells."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.schema import FRICTION_OF_A_SIDE, LOAD, ORIGINS, SIDES, SIGMOID, UNKNOWN, Column, Paper, to_si
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import OptionError, PaperError
from lwr_dyn.model.arm import Arm, JointGains, JointLimits, Ratings, Source
from lwr_dyn.model.caveats import GUESSED, Caveats, StandIn
from lwr_dyn.model.chain import Body, Chain, ChainLink, DHRow, JointKind, Rotor
from lwr_dyn.model.file_layout import Drawing, DrawnCylinder
from lwr_dyn.model.friction import FRICTIONLESS, Direction, JointFriction, Sigmoid
from lwr_dyn.model.spatial import Pose, from_rpy, steiner
from lwr_dyn.model.transmission import JointElasticity, Transmission

Part = tuple[str, int, str]
"""Column, row, and how its number is converted."""


def rotor_of(paper: Paper, i: int) -> Rotor | None:
    """The rotor of joint i, from gear ratio and inertia or from the inertia reflected to the joint."""
    ratio, inertia, armature = (paper.cell(f"rotors.{name}", i) for name in ("gear_ratio", "inertia", "armature"))
    if armature is not None:
        return Rotor(1.0, armature, reflected=True)
    return None if ratio is None or inertia is None else Rotor(ratio, inertia)


def transmission_of(paper: Paper) -> Transmission | None:
    """The motor map T_ij = signs_ij ratio_j / stage_j, or as it is printed; None if not given."""
    if "transmission.matrix" in paper.columns:
        return Transmission(paper.columns["transmission.matrix"].si())
    if "transmission.ratio" not in paper.columns:
        return None
    ratio, signs = (paper.columns[f"transmission.{name}"].si() for name in ("ratio", "signs"))
    stage = paper.columns["transmission.stage"].si() if "transmission.stage" in paper.columns else np.ones(paper.n)
    return Transmission(signs * (ratio / stage))


def gains_of(paper: Paper) -> JointGains | None:
    """The controller gains of the source; None if not given."""
    if "gains.kp" not in paper.columns:
        return None
    Kp, Kd = (read_only(paper.columns[f"gains.{name}"].si()) for name in ("kp", "kd"))
    optional = (paper.columns.get(f"gains.{name}") for name in ("ki", "effort"))
    return JointGains(Kp, Kd, *(None if column is None else read_only(column.si()) for column in optional))


def elasticity_of(paper: Paper) -> JointElasticity | None:
    """Springs and dampers of the gears; None if not given."""
    if "elasticity.stiffness" not in paper.columns:
        return None
    stiffness, damping = (paper.columns[f"elasticity.{name}"] for name in ("stiffness", "damping"))
    return JointElasticity(stiffness.si(), damping.si(), f"{stiffness.kind}, {stiffness.where}")


def friction_per_direction(paper: Paper) -> tuple[JointFriction, ...]:
    """Friction of every joint if the paper gives it per direction, or as a sigmoid; empty otherwise."""
    if "friction.sigmoid_level" in paper.columns:
        return _sigmoids(paper)
    if "friction.positive_coulomb" not in paper.columns:
        return ()
    ratios = friction_ratios(paper)
    return tuple(
        JointFriction(
            positive=_direction(paper, SIDES[bool(ratios[i] < 0.0)], i, abs(ratios[i])),
            negative=_direction(paper, SIDES[bool(ratios[i] > 0.0)], i, abs(ratios[i])),
            offset=(paper.cell("friction.offset", i) or 0.0) * ratios[i],
            covered=_times(paper.cell("friction.covered", i), 1.0 / abs(ratios[i])),
            load=paper.cell(f"friction.{LOAD}", i) or 0.0,
        )
        for i in range(paper.n)
    )


def _sigmoids(paper: Paper) -> tuple[JointFriction, ...]:
    rows = np.array([paper.columns[f"friction.{name}"].si() for name in SIGMOID]).T.tolist()
    seen = (Sigmoid(*row).from_motor(ratio) for row, ratio in zip(rows, friction_ratios(paper).tolist(), strict=True))
    return tuple(replace(FRICTIONLESS, sigmoid=sigmoid) for sigmoid in seen)


def friction_ratios(paper: Paper) -> Array:
    """Motor speed over joint speed where friction is printed as at the motors, (n,); 1 where it is at the joints.

    A torque f(dq_m) of the motor is r f(r dq) at the joint, so levels take |r|, slopes r^2, and r < 0 swaps directions.
    Raises `PaperError` for friction at the motors without gear ratios, or where motors drive several joints.
    """
    if paper.friction_side == "joint":
        return np.ones(paper.n)
    map_ = transmission_of(paper)
    if map_ is not None:
        T = map_.matrix
        if np.any(T - np.diag(np.diag(T))):
            raise PaperError(paper.file, "friction.side", "'motor' with motors that drive several joints", "joint")
        return np.diag(T)
    if "rotors.gear_ratio" not in paper.columns or np.isnan(paper.columns["rotors.gear_ratio"].si()).any():
        raise PaperError(paper.file, "friction.side", "'motor' without gear ratios", "rotors.gear_ratio of every joint")
    return paper.columns["rotors.gear_ratio"].si()


_POWERS = {"coulomb": 1, "static": 1, "viscous": 2, "stribeck_velocity": -1}
"""Power of the gear ratio that brings a number from the motor to the joint."""


def _times(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


def _direction(paper: Paper, side: str, i: int, ratio: float) -> Direction:
    cells = {name: _times(paper.cell(f"friction.{side}_{name}", i), ratio**power) for name, power in _POWERS.items()}
    return Direction(cells["coulomb"] or 0.0, cells["viscous"] or 0.0, cells["static"], cells["stribeck_velocity"])


def actuation_parts(paper: Paper) -> Iterator[tuple[str, tuple[Part, ...]]]:
    """Quantity of the arm -> the columns and rows it is computed from."""
    seen = "to SI" if paper.friction_side == "joint" else "from the motor to the joint by the gear ratio"
    for i, joint in enumerate(paper.joints):
        product = [(f"rotors.{name}", i, "k_r^2 I_m") for name in ("gear_ratio", "inertia")]
        yield f"{joint}.armature", (*product, ("rotors.armature", i, "to SI"))
        for name in ("stiffness", "damping"):
            yield f"{joint}.{name}", ((f"elasticity.{name}", i, "to SI"),)
        for name in ("viscous", "coulomb"):
            yield f"{joint}.{name}", ((f"friction.{name}", i, seen),)
        directed = (f"{side}_{x}" for side in SIDES for x in FRICTION_OF_A_SIDE)
        for name in (*directed, "offset", "covered", LOAD, *SIGMOID):
            yield f"{joint}.friction.{name}", ((f"friction.{name}", i, seen),)
        for name in ("kp", "ki", "kd", "effort"):
            yield f"{joint}.gains.{name}", ((f"gains.{name}", i, "to SI"),)
        factors = [(f"transmission.{name}", i, "T_ij = signs_ij ratio_j / stage_j") for name in ("ratio", "stage")]
        columns = [
            (f"transmission.{x}", k, "column of the motor map") for x in ("signs", "matrix") for k in range(paper.n)
        ]
        yield f"{joint}.motors", (*factors, *columns)


LEFT_IN_PLACE = "left_in_place"
"""In `[document]` of a file that was written from an arm: proven errors that its reading leaves in place."""
CONTRADICTED = "contradicted"
"""In `[document]` of a fitted arm: by what its log contradicts its bodies."""
STANDARD_GRAVITY = (0.0, 0.0, -9.81)
"""Gravity [m/s^2] when the file gives none."""
_RATINGS = ("ratings.payload", "ratings.mass", "base.mass", "ratings.reach", "ratings.envelope_volume")


def arm_from_paper(paper: Paper) -> Arm:
    """The arm that a paper describes under its reading.

    Chain frames are the paper's DH frames. Tensors are brought to the centre of mass (Steiner) with the tensor sign
    of the products; limits move from the printed to the DH coordinate (q = printed + zero).
    """
    columns = paper.columns
    gravity = columns["base.gravity"].si()[0] if "base.gravity" in columns else np.array(STANDARD_GRAVITY)
    chain = Chain(links=_links(paper), flange=_pose(paper, "flange"), gravity=gravity)
    return Arm(
        name=paper.name, reading=paper.reading.name, title=paper.title, chain=chain, limits=_limits(paper),
        drawing=_drawing(paper, chain), ratings=Ratings(*(paper.cell(name) for name in _RATINGS)),
        mastering=paper.numbers("poses.mastering"),
        sources=_sources(paper), errata=paper.reading.errata, digest=paper.digest,
        friction=friction_per_direction(paper), transmission=transmission_of(paper), gains=gains_of(paper),
        torques=paper.torques, elasticity=elasticity_of(paper), caveats=caveats_of(paper),
    )  # fmt: skip


_SORTS = {
    "limits.lower": "position limits", "limits.upper": "position limits", "limits.velocity": "speed limits",
    "limits.effort": "torque limits", "inertial.mass": "masses", "inertial.com": "centres of mass",
    "inertial.inertia": "inertias", "elasticity.stiffness": "gear stiffness",
    "elasticity.damping": "gear damping", "base.xyz": "geometry", "base.rpy": "geometry",
    "dh": "geometry", "flange": "geometry", "rotors": "rotor inertias", "friction": "friction",
}  # fmt: skip
"""Column, or table -> the sort of its numbers, one of `lwr_dyn.model.caveats.ALL`; gravity and drawings have none."""


def sort_of(column: str) -> str:
    """The sort of the numbers of a column such as "inertial.mass"; empty for one without a sort."""
    return _SORTS.get(column) or _SORTS.get(column.partition(".")[0], "")


def caveats_of(paper: Paper) -> Caveats:
    """What an arm carries before its numbers: proven errors that the reading leaves in place, and its estimates."""
    estimates: dict[StandIn, None] = {}
    for name, column in paper.columns.items():
        what = sort_of(name)
        if what:
            estimates |= {StandIn(what, kind, column.how): None for kind in _kinds(paper, column) if kind in GUESSED}
    left = (*paper.left_in_place(), *paper.document.get(LEFT_IN_PLACE, "").split())
    likely = (e.id for e in paper.errata if e.id in paper.reading.errata and e.status == "likely")
    return Caveats(left, tuple(estimates), tuple(likely), paper.document.get(CONTRADICTED, ""))


def _kinds(paper: Paper, column: Column) -> tuple[str, ...]:
    """The column's kind, and the kinds of its cells that errata read."""
    applied = {id for ids in column.errata.values() for id in ids}
    patches = [p for e in paper.errata if e.id in applied for p in e.patches if p.at.startswith(column.name)]
    return (column.kind, *(p.kind for p in patches if p.kind))


def _si(paper: Paper, name: str, default: float) -> Array:
    return paper.columns[name].si() if name in paper.columns else np.full(paper.n, default)


def dh_rows(paper: Paper) -> tuple[DHRow, ...]:
    """The DH table in SI units."""
    names = ("dh.alpha", "dh.a", "dh.d", "dh.theta_offset", "dh.beta")
    alpha, a, d, theta, beta = (_si(paper, name, 0.0) for name in names)
    sign = _si(paper, "dh.sign", 1.0)
    return tuple(DHRow(alpha[i], a[i], d[i], theta[i], int(sign[i]), beta[i]) for i in range(paper.n))


OWN_AXES = ("inertial.rpy", f"{ORIGINS}.xyz")
"""Columns that give bodies in other axes or frames than those of the DH table."""
BEYOND_DH = ("base.xyz", "base.rpy", "dh.beta", f"{ORIGINS}.xyz")


def require_plain_dh(paper: Paper, needed_for: str) -> None:
    """Raise `OptionError` where the file goes beyond a DH table, as one that was written from a URDF may."""
    for name in (x for x in BEYOND_DH if x in paper.columns):
        raise OptionError(f"{needed_for} of {paper.file}", name, "a DH table without it")


def _links(paper: Paper) -> tuple[ChainLink, ...]:
    links = []
    for i, row in enumerate(dh_rows(paper)):
        before, after = row.fixed_poses(paper.convention)
        before = _pose(paper, "base") @ before if i == 0 else before
        link = f"link_{i + 1}"
        links.append(
            ChainLink(paper.joints[i], link, paper.kinds[i], before, after, _body(paper, i), rotor_of(paper, i))
        )
    if f"{ORIGINS}.xyz" in paper.columns:
        placed = zip(links, frames_of_urdf(paper, links), strict=True)
        links = [replace(x, body=None if x.body is None else x.body.seen_from(pose)) for x, pose in placed]
    return tuple(links)


BESIDE = 1e-6
"""[m] and [rad] by which an axis of a set's URDF may lie beside that of the DH table: rounded pi and lengths."""


def frames_of_urdf(paper: Paper, links: Sequence[ChainLink]) -> list[Pose]:
    """Poses of the frames of the table `origins` in the DH frames, a link each; constant where the axes are the same.

    Raises `PaperError` where an axis of the URDF at zero is not that of the DH table, so the frames move otherwise.
    """
    columns = {name: paper.columns[f"{ORIGINS}.{name}"].si() for name in ("xyz", "rpy")}
    given = paper.columns.get(f"{ORIGINS}.axis")
    axes = np.tile([0.0, 0.0, 1.0], (paper.n, 1)) if given is None else given.si()
    table, own, out = Pose.identity(), Pose.identity(), []
    for i, link in enumerate(links):
        table = table @ link.before  # z is the joint's axis
        own = own @ Pose(from_rpy(columns["rpy"][i]), columns["xyz"][i])
        axis = table.rotation[:, 2]
        turned = float(np.linalg.norm(np.cross(axis, own.rotation @ axes[i])) + (axis @ own.rotation @ axes[i] < 0.0))
        apart = float(np.linalg.norm(np.cross(axis, own.position - table.position))) * (link.kind is JointKind.REVOLUTE)
        if max(turned, apart) > BESIDE:
            found = (
                f"the axis of {link.joint} at zero is {apart:.3g} m and {turned:.3g} rad beside that of the DH table"
            )
            raise PaperError(paper.file, ORIGINS, found, f"the same axes within {BESIDE:g}")
        table = table @ link.after
        out.append(table.inverse() @ own)
    return out


def _body(paper: Paper, i: int) -> Body | None:
    if "inertial.mass" not in paper.columns:
        return None
    given = [np.asarray(paper.columns[f"inertial.{name}"].si()[i]) for name in ("mass", "com", "inertia")]
    if not any(np.isnan(x).any() for x in given):
        return _body_of(paper, i, *given)
    fills = np.random.default_rng(0).uniform(0.5, 2.0, 3)
    filled = [_body_of(paper, i, *(np.where(np.isnan(x), fill, x) for x in given)) for fill in (0.0, *fills)]
    parameters = np.array([[x.mass, *(x.mass * x.com), *x.inertia_origin()[np.triu_indices(3)]] for x in filled])
    scale = np.abs(parameters).max(axis=0)
    open_ones = np.ptp(parameters, axis=0) > 1e-12 * scale  # rounding of Steiner's terms
    return replace(filled[0], unknown=tuple(int(k) for k in np.flatnonzero(open_ones)))


def _body_of(paper: Paper, i: int, mass: Array, com: Array, tensor: Array) -> Body:
    if paper.inertia_products[i] == "integral":
        tensor = np.where(np.eye(3, dtype=bool), tensor, -tensor)
    if "inertial.rpy" in paper.columns:
        turn = from_rpy(paper.columns["inertial.rpy"].si()[i])
        tensor = turn @ tensor @ turn.T
    if paper.inertia_about == "origin":
        tensor = tensor - steiner(float(mass), com)
    return Body(float(mass), com, tensor)


def _pose(paper: Paper, table: str) -> Pose:
    zero, names = np.zeros((1, 3)), (f"{table}.xyz", f"{table}.rpy")
    xyz, rpy = (paper.columns[name].si() if name in paper.columns else zero for name in names)
    return Pose(from_rpy(rpy[0]), xyz[0])


def _limits(paper: Paper) -> tuple[JointLimits, ...]:
    positions = [_from_printed_zero(paper, f"limits.{side}") for side in ("lower", "upper")]
    others = ("limits.velocity", "limits.effort", "friction.viscous", "friction.coulomb")
    unknown: Sequence[None] = [None] * paper.n
    columns = [column or unknown for column in (*positions, *(paper.numbers(name) for name in others))]
    ratios = friction_ratios(paper)
    columns[4:] = [
        column if column is unknown else [x * abs(r) ** _POWERS[name] for x, r in zip(column, ratios, strict=True)]
        for name, column in zip(("viscous", "coulomb"), columns[4:], strict=True)
    ]
    rows = zip(*columns, strict=True)
    return tuple(JointLimits(*(None if x is None or np.isnan(x) else x for x in row)) for row in rows)


def _from_printed_zero(paper: Paper, name: str) -> Sequence[float]:
    """q = printed + zero, added before the conversion if the units are the same: 210 - 90 deg is exactly 120 deg."""
    if name not in paper.columns or "limits.zero" not in paper.columns:
        return paper.numbers(name)
    printed, zero = paper.columns[name], paper.columns["limits.zero"]
    if zero.unit == printed.unit:
        sums = [p + z for p, z in zip(printed.values, zero.values, strict=True)]
        return [to_si(value, unit) for value, unit in zip(sums, printed.unit, strict=True)]
    return [float(v) for v in printed.si() + zero.si()]


def _drawing(paper: Paper, chain: Chain) -> Drawing:
    return Drawing(
        pedestal=paper.cell("drawing.pedestal") or 0.0,
        radius=paper.numbers("drawing.radius"),
        cylinders=() if paper.solids is None else tuple(_drawn(solid, chain) for solid in paper.solids.cylinders),
    )


def _drawn(solid: DrawnCylinder, chain: Chain) -> DrawnCylinder:
    """A cylinder moved from the DH frame to the URDF frame of its link."""
    frame = {"base": Pose.identity()} | {link.link: link.after for link in chain.links}
    turn, shift = frame[solid.link].rotation, frame[solid.link].position
    (x0, y0, z0), (x1, y1, z1) = ((turn @ np.array(end) + shift).tolist() for end in (solid.start, solid.end))
    return replace(solid, start=(x0, y0, z0), end=(x1, y1, z1))


def _sources(paper: Paper) -> dict[str, tuple[Source, ...]]:
    """Quantity of the arm -> the cells it is computed from."""

    def cells(*parts: Part) -> tuple[Source, ...]:
        return tuple(_source(paper, paper.columns[c], i, how) for c, i, how in parts if c in paper.columns)

    out: dict[str, tuple[Source, ...]] = {}
    moved = "moved by q = printed + zero" if "limits.zero" in paper.columns else "to SI"
    about = "to the centre of mass (Steiner)" if paper.inertia_about == "origin" else "about the centre of mass"
    for i, joint in enumerate(paper.joints):
        link = f"link_{i + 1}"
        names = ("alpha", "a", "d", "theta_offset", "sign", "beta")
        placed = [(f"base.{name}", 0, "frame 0 in the base") for name in ("xyz", "rpy") if i == 0]
        out[f"{joint}.dh"] = cells(*((f"dh.{name}", i, "DH row to pose") for name in names), *placed)
        for side in ("lower", "upper"):
            out[f"{joint}.{side}"] = cells((f"limits.{side}", i, moved), ("limits.zero", i, moved))
        for name in ("velocity", "effort"):
            out[f"{joint}.{name}"] = cells((f"limits.{name}", i, "to SI"))
        out[f"{link}.mass"] = cells(("inertial.mass", i, "to SI"))
        placed = [(f"{ORIGINS}.{x}", k, "frame of the set") for x in ("xyz", "rpy", "axis") for k in range(i + 1)]
        out[f"{link}.com"] = cells(("inertial.com", i, "DH frame to URDF frame"), *placed)
        products = paper.inertia_products[i]
        sign = ", products negated" if products == "integral" else ""
        tensor = [
            ("inertial.inertia", i, f"{about}{sign}, DH axes to URDF axes"),
            ("inertial.rpy", i, "the tensor's own axes"),
        ]
        needs = [("inertial.mass", i, about), ("inertial.com", i, about)] if paper.inertia_about == "origin" else []
        out[f"{link}.inertia"] = cells(*tensor, *needs, *placed)
    out |= {name: sources for name, parts in actuation_parts(paper) if (sources := cells(*parts))}
    out["flange"] = cells(("flange.xyz", 0, "to SI"), ("flange.rpy", 0, "to SI"))
    out["pedestal"] = cells(("drawing.pedestal", 0, "drawn only"))
    return out


def _said(value: Any) -> Any:
    """A cell with the word for what is unknown."""
    if isinstance(value, tuple):
        return tuple(_said(x) for x in value)
    return UNKNOWN if isinstance(value, float) and np.isnan(value) else value


def _source(paper: Paper, column: Column, row: int, conversion: str) -> Source:
    """A row of a column; the patch of an erratum may give its cell another kind."""
    errata = column.errata.get(row, ())
    patches = [p for e in paper.errata if e.id in errata for p in e.patches]
    kinds = [p.kind for p in patches if p.kind and p.at.startswith(f"{column.name}.values[{row}]")]
    cell = f"{column.name}.values[{row}]" if len(column.values) > 1 else f"{column.name}.values"
    return Source(
        cell=cell, where=column.where, kind=[column.kind, *kinds][-1], value=_said(column.values[row]),
        unit=column.unit[row], conversion=conversion, errata=errata,
        sigma=_said(column.sigma[row]) if column.sigma else None,
    )  # fmt: skip
