"""What the page knows of an arm, or of its arms: kinematics, bodies, closed forms, and the stage, as JSON values.

`arm` and `bodies` are all that kinematics.js needs. Poses are 16 numbers, column after column; lengths in m, angles in
rad; null is unknown. The arms of a page are one robot with its paper's other readings, or two robots side by side; arms
with the same kinematics share functions and shapes, because masses, rotors and gravity are data. `closed_forms.toml`
holds short entries of B, C and g of the package's robots; scripts/closed_forms.py writes it.
"""

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.arms.papers.catalog import open_paper, readings, robots
from lwr_dyn.dynamics.regressor import body_parameters, chain_with_dynamics
from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, JointKind, names_of_ends
from lwr_dyn.model.ellipsoid import inertia_ellipsoid, no_ellipsoid
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.replayed_runs import pose_as_run, replayed_runs

_HALF_TURN, _SLIDE = float(np.pi), 1.0
"""Ends of a slider of a joint without known limits: [rad] of a turning joint, [m] of a sliding one."""

ORDER = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
"""Entries of a tensor among a link's inertial parameters, as `lwr_dyn.codegen.kernels` has them."""

_ROUNDING = 1e-9
"""[rad or m] by which a position may be outside its limits: one in whole degrees at a limit in rad."""


def arm_record(arm: Arm) -> dict[str, Any]:
    """The arm's kinematics: joints in URDF frames, the flange in the last link, gravity in the first frame [m/s^2]."""
    first, last = names_of_ends(arm.installation)
    ranges, native = slider_ranges(arm), [replay_page.column_major(link.after) for link in arm.chain.links]
    return {
        "name": arm.name,
        "reading": arm.reading,
        "joints": [
            {
                "name": joint.name,
                "kind": joint.kind.value,
                "origin": replay_page.column_major(joint.origin),
                "lower": joint.limits.lower,
                "upper": joint.limits.upper,
                "slider": ranges[i],
            }
            for i, joint in enumerate(arm.joints())
        ],
        "flange": replay_page.column_major(arm.flange()),
        "native": native if has_frames_of_its_own(arm) else None,
        "gravity": arm.chain.gravity.tolist(),
        "ends": [first, last],
    }


def has_frames_of_its_own(arm: Arm) -> bool:
    """Whether the source's frames (of a DH table) are other than the URDF's."""
    return not all(link.after.is_identity() for link in arm.chain.links)


def body_record(body: Body | None) -> dict[str, Any]:
    """A link's body in its URDF frame, with its ellipsoid as the image of the unit sphere, or why it has none."""
    if body is None:
        return {"mass": None, "ellipsoid": None, "why": no_ellipsoid(body)}
    record = {"mass": body.mass, "com": body.com.tolist(), "inertia": body.inertia_com.tolist()}
    if (shape := inertia_ellipsoid(body)) is None:
        return record | {"ellipsoid": None, "why": no_ellipsoid(body)}
    return record | {"ellipsoid": replay_page.column_major(shape.image)}


def inertial_record(arm: Arm) -> dict[str, Any]:
    """What the dynamics of an arm are computed with; of an arm without masses null.

    `inertia`: ten parameters of each link in its frame of the chain (m, m c, tensor about its origin as `ORDER`);
    `rotors`: of each joint [kg m^2 or kg]; `carrier`: the flange in the last link's frame, where a payload is added.
    """
    try:
        chain = chain_with_dynamics(arm)
    except MissingDataError:
        return {"inertia": None, "rotors": None, "carrier": None}
    rows = [body_parameters(link.body or Body.massless(), ORDER) for link in chain.links]
    return {
        "inertia": [float(x) for row in rows for x in row],
        "rotors": arm.armature.tolist(),
        "carrier": replay_page.column_major(chain.flange),
    }


def slider_ranges(arm: Arm) -> list[tuple[float, float]]:
    """Both ends of each joint's slider [rad or m]: its limits, and where one is unknown half a turn or a metre."""
    out = []
    for joint in arm.joints():
        low, up = joint.limits.lower, joint.limits.upper
        span = _HALF_TURN if joint.kind is JointKind.REVOLUTE else _SLIDE
        low = min(-span, up or 0.0) if low is None else low
        out.append((low, max(span, low) if up is None else up))
    return out


def start_pose(arm: Arm, q: ArrayLike | None = None) -> Array:
    """The positions at the start, (n,) [rad or m]: as given, or zero, moved into the limits where they exclude it.

    Raises
    ------
    ShapeError
        q that is not (n,) or not finite.
    OptionError
        A position outside its limits.
    """
    if q is None:
        return np.clip(np.zeros(arm.n), arm.lower, arm.upper)
    given = fixed_array("q", q, (arm.n,))
    for joint, x in zip(arm.joints(), given, strict=True):
        low, up = joint.limits.lower, joint.limits.upper
        if (low is not None and x < low - _ROUNDING) or (up is not None and x > up + _ROUNDING):
            allowed = f"its limits, {position_text(joint.kind, low)} to {position_text(joint.kind, up)}"
            raise OptionError(f"q of {joint.name}", position_text(joint.kind, float(x)), allowed)
    return given


def position_text(kind: JointKind, x: float | None) -> str:
    """A position in the units of the command line: deg, of a sliding joint m; "unknown" for None."""
    if x is None:
        return "unknown"
    return f"{np.degrees(x):.6g} deg" if kind is JointKind.REVOLUTE else f"{x:.6g} m"


_LETTER = re.compile(r"\b[A-Za-z]+\d+[xyz]*\b")


def closed_forms(arm: Arm) -> dict[str, Any]:
    """`texts` by entry such as "B_23", `values` of their letters, and `command`, which prints an entry; "" has none.

    Letters are those of `dynamics.symbolic.arm_equations`: m, c and I of a link in its DH frame, I about its centre.
    """
    if arm.chain.bodies is None or arm.loaded_with or arm.installation is not None:
        return {"texts": {}, "values": {}, "command": ""}
    has_readings = not arm.file or (ends_in(arm.file, ".toml") and not ends_in(arm.file, ".kuka.toml"))
    asked = [arm.file or arm.name, "ENTRY", *([arm.reading] if has_readings else [])]
    command = (
        f'python -c "from lwr_dyn.dynamics.symbolic.equation_forms import entry_text as e; print(e{tuple(asked)!r})"'
    )
    found = _read().get(arm.name, {}) if not arm.file and arm.name in robots() else {}
    found = found if arm.reading in found.get("readings", ()) else {}
    texts = found.get("texts", {})
    known = letter_values(arm) | length_values(arm, found.get("lengths", {}))
    letters = {letter for text in texts.values() for letter in _LETTER.findall(text)}
    values = {letter: float(f"{known[letter]:.6g}") for letter in sorted(letters & known.keys())}
    return {"texts": texts, "values": values, "command": command}


def letter_values(arm: Arm) -> dict[str, float]:
    """Numbers of the letters of bodies, rotors and gravity along one axis."""
    values = {"g0": float(abs(arm.chain.gravity).max())}
    for k, link in enumerate(arm.chain.links, start=1):
        values |= {} if link.rotor is None else {f"Ia{k}": link.rotor.armature}
        if link.body is None:
            continue
        values |= {f"m{k}": link.body.mass}
        for i, a in enumerate("xyz"):
            values[f"c{k}{a}"] = float(link.body.com[i])
            values |= {f"I{k}{a}{b}": float(link.body.inertia_com[i, j]) for j, b in enumerate("xyz") if j >= i}
    return values


def length_values(arm: Arm, places: Mapping[str, str]) -> dict[str, float]:
    """Numbers of letters [m] that stand for a column and row (from 1) of the arm's paper, such as "dh.d 7"."""
    columns = open_paper(arm.name, arm.reading).columns if places else {}
    split = {letter: place.split() for letter, place in places.items()}
    return {letter: float(columns[column].si()[int(row) - 1]) for letter, (column, row) in split.items()}


@cache
def _read() -> dict[str, Any]:
    return tomllib.loads(files("lwr_dyn.pages.explorer").joinpath("closed_forms.toml").read_text(encoding="utf-8"))


@dataclass(frozen=True, slots=True, eq=False)
class ShownArm:
    """An arm of a page."""

    arm: Arm
    label: str
    """What its button says."""
    start: Array
    """Positions at the start, (n,) [rad or m]."""
    group: int
    """Arms of one group stand at the same place, and one of them is shown; groups stand side by side."""


def readings_shown(arm: Arm, q: ArrayLike | None = None) -> tuple[ShownArm, ...]:
    """The arm with the other readings of its paper, moved into their limits; raises as `start_pose`."""
    start = start_pose(arm, q)
    others = other_readings(arm)
    shown = [ShownArm(other, name, start.clip(other.lower, other.upper), 0) for name, other in others.items()]
    return (ShownArm(arm, arm.reading if others else arm.name, start, 0), *shown)


def beside_each_other(arm: Arm, other: Arm, q: ArrayLike | None = None) -> tuple[ShownArm, ...]:
    """Two arms side by side, q (n,) of the first; raises as `start_pose`."""
    labels = [arm.name, other.name]
    if arm.name == other.name:
        labels = [f"{arm.name} {arm.reading}", f"{other.name} {other.reading}"]
    if labels[0] == labels[1]:
        labels = [f"{labels[0]}, left", f"{labels[1]}, right"]
    start = start_pose(arm, q)
    at = start_pose(other) if other.n != arm.n else start.clip(other.lower, other.upper)
    return ShownArm(arm, labels[0], start, 0), ShownArm(other, labels[1], at, 1)


def other_readings(arm: Arm) -> dict[str, Arm]:
    """The same robot, mounted and loaded as it is, as its paper's other readings have it; none of a robot of a file."""
    if arm.file or arm.name not in robots() or arm.reading not in readings(arm.name):
        return {}
    names = [name for name in readings(arm.name) if name != arm.reading]
    return {name: load_with_paper(arm.name, name, **arm.loaded_with)[0] for name in names}


def shown_records(shown: Sequence[ShownArm], sets: Sequence[int | None], live: bool = False) -> dict[str, Any]:
    """The arms and the stage as JSON values; `sets` says which functions each arm has.

    The scene of a live page are meshcat's commands, else short ones, which own_stage.js reads.
    """
    stage, runs = _stage(shown)
    if not live:
        stage["scene"] = [short_command(command) for command in stage["scene"]]
    records = [
        {
            "label": each.label, "group": each.group, "set": chosen, "run": run, "start": each.start.tolist(),
            "arm": arm_record(each.arm), "bodies": [body_record(body) for body in each.arm.bodies()],
            "motors": [joint.limits.effort for joint in each.arm.joints()],  # N m or N; None is unknown
            **inertial_record(each.arm), "closed_forms": closed_forms(each.arm),
        }
        for each, chosen, run in zip(shown, sets, runs, strict=True)
    ]  # fmt: skip
    return {"arms": records, "stage": stage}


def _stage(shown: Sequence[ShownArm]) -> tuple[dict[str, Any], list[int]]:
    """What is drawn, once for arms that look alike, and the place of each arm among it."""
    places: dict[tuple[int, str], int] = {}
    commands: list[Any] = []
    records: list[Any] = []
    runs = []
    for each in shown:
        (drawn,) = replayed_runs([pose_as_run(each.arm, each.start)], each.arm, [each.arm.name])
        look = (each.group, json.dumps(list(replay_page.arm_commands(drawn, 0))))
        if look not in places:
            places[look] = len(places)
            commands += replay_page.arm_commands(drawn, places[look])
            records.append(replay_page.run_record(drawn))
        runs.append(places[look])
    return {"scene": commands, "runs": records}, runs


def short_command(command: Mapping[str, Any]) -> list[Any]:
    """Run, link, and the link's transform; or run, link, a cylinder's transform, radii, height, colours and token.

    >>> short_command({"type": "set_transform", "path": "/arms/run_0/link_0/link_1", "matrix": [1.0, 0.5]})
    [0, 1, [1, 0.5]]
    """
    links = [part for part in command["path"].split("/") if part.startswith("link_")]
    run = int(command["path"].split("/run_")[1].split("/")[0])
    place = [run, len(links) - 1]
    if command["type"] == "set_transform":
        return [*place, _short_numbers(command["matrix"])]
    shape = command["object"]
    (solid,), (paint,), mesh = shape["geometries"], shape["materials"], shape["object"]
    sizes = [solid["radiusTop"], solid["radiusBottom"], solid["height"], solid["radialSegments"]]
    colours = [paint["color"], paint["specular"], paint["shininess"]]
    return [*place, _short_numbers(mesh["matrix"]), sizes, colours, mesh["userData"]["token"]]


def _short_numbers(values: Sequence[float]) -> list[float]:
    """Whole numbers without a point."""
    return [int(x) if x == int(x) else x for x in values]
