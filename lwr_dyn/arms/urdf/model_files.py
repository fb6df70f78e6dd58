"""All files of an arm: URDF, SRDF with the rotors, MJCF, and the sidecar with the source of every number."""

import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, replace
from typing import Any
from xml.sax.saxutils import quoteattr

from lwr_dyn.arms.papers.catalog import readings, robots
from lwr_dyn.arms.urdf.elements import Attribute, caveat_lines, comment, number
from lwr_dyn.arms.urdf.writer import urdf_text, urdf_with_sources
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm, Source
from lwr_dyn.model.caveats import DYNAMICS
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.model.spatial import Pose

SCHEMA = 1
UNSOURCED = "no source given"
"""The word for a quantity of an arm that was built in code."""


def provenance_text(arm: Arm) -> str:
    """The sidecar of the arm's URDF as JSON text.

    `attributes` maps the path of each numeric attribute to its numbers as `written` and either the `quantities` they
    are computed from or a `word`: drawn, unknown, by choice, weightless, copied. `quantities` maps each quantity to its
    cells: `value` under the reading in the printed `unit`, and the `errata` that changed it. What a URDF cannot hold
    (friction per direction, motor map, gains) has blocks of its own, in SI.

    >>> from lwr_dyn import load
    >>> sidecar = json.loads(provenance_text(load("lwr4plus")))
    >>> sidecar["attributes"]["/robot/link[@name='link_1']/inertial/mass/@value"]
    {'written': [2.7782], 'quantities': ['link_1.mass']}
    >>> sidecar["quantities"]["link_1.mass"][0]["where"]
    'Fig. 1, column Mass'
    """
    attributes = urdf_with_sources(arm).attributes
    used = [name for attribute in attributes.values() for name in attribute.quantities]
    cells = {name: quantity_sources(arm, name) for name in dict.fromkeys([*used, *sidecar_quantities(arm)])}
    top: dict[str, Any] = {
        "schema": SCHEMA,
        "robot": arm.name,
        "reading": arm.reading,
        "title": arm.title,
        "errata": list(arm.errata),
        "caveat": arm.caveat(DYNAMICS),
        "caveats": asdict(arm.caveats),
        "source_sha256": arm.digest,
        "gravity": [float(x) for x in arm.chain.gravity],
    }
    top |= sidecar_blocks(arm)
    head = json.dumps(top, indent=1, ensure_ascii=False).removesuffix("\n}")
    quantities = _block({
        name: [{key: value for key, value in asdict(source).items() if value not in ((), None)} for source in sources]
        for name, sources in cells.items()
    })  # fmt: skip
    sourced = _block({path: _attribute(item, cells) for path, item in attributes.items()})
    return f'{head},\n "quantities": {quantities},\n "attributes": {sourced}\n}}\n'


def quantity_sources(arm: Arm, quantity: str) -> tuple[Source, ...]:
    """The cells of a quantity of the arm: "link_1.mass", "joint_2.lower", "joint_3.after" ...

    A joint's `before` and `after` (the constant poses around its motion) are parts of its DH row. A standard row is
    all after the motion; of a modified row alpha and a are before it, d and theta after it. The sign is on both sides,
    since a joint of sign -1 has a half turn before and after its motion.
    """
    if quantity in arm.sources:
        return arm.sources[quantity]
    joint, _, part = quantity.rpartition(".")
    if part in ("gear_ratio", "rotor_inertia"):
        columns = {"gear_ratio": ("rotors.gear_ratio",), "rotor_inertia": ("rotors.inertia", "rotors.armature")}[part]
        sources = _of_columns(arm.sources.get(f"{joint}.armature", ()), columns)
        return tuple(replace(source, conversion="to SI") for source in sources)
    if part in ("before", "after"):
        inner = arm.chain.links[1:] or arm.chain.links  # the base's own pose stands before joint 1
        standard = all(_is_half_turn_or_identity(link.before) for link in inner)
        columns = ("base.xyz", "base.rpy", "dh.alpha", "dh.beta", "dh.a", "dh.d", "dh.theta_offset")
        split = 2 if standard else 5
        mine = columns[:split] if part == "before" else columns[split:]
        return _of_columns(arm.sources.get(f"{joint}.dh", ()), (*mine, "dh.sign"))
    return ()


def sidecar_blocks(arm: Arm) -> dict[str, Any]:
    """What a URDF cannot hold, in SI, by block: friction per direction, motor map, gains; only what the arm has."""
    out: dict[str, Any] = {}
    if arm.friction:
        pairs = zip(arm.joint_names, arm.friction, strict=True)
        out["friction"] = {joint: _friction(friction) for joint, friction in pairs if friction is not None}
    if arm.transmission is not None:
        out["transmission"] = {"motors_by_joints": arm.transmission.matrix.tolist()}
    if arm.gains is not None:
        gains = {name: getattr(arm.gains, name) for name in ("Kp", "Ki", "Kd", "effort")}
        out["gains"] = {name: None if value is None else value.tolist() for name, value in gains.items()}
    return out


def _friction(friction: JointFriction) -> dict[str, Any]:
    """As JSON values, sigmoid and share of the load only where there is one."""
    return {name: x for name, x in asdict(friction).items() if name not in ("sigmoid", "load") or x}


def sidecar_quantities(arm: Arm) -> tuple[str, ...]:
    """The quantities in `sidecar_blocks`."""
    blocks = {"friction.": arm.friction, "gains.": arm.gains is not None, "motors": arm.transmission is not None}
    starts = tuple(f"{joint}.{part}" for joint in arm.joint_names for part, given in blocks.items() if given)
    return tuple(name for name in arm.sources if name.startswith(starts))


def _is_half_turn_or_identity(pose: Pose) -> bool:
    diagonal = pose.rotation.diagonal()
    return not pose.position.any() and diagonal[0] == 1.0 and abs(diagonal[1]) == 1.0


def _of_columns(sources: tuple[Source, ...], columns: tuple[str, ...]) -> tuple[Source, ...]:
    return tuple(s for s in sources if s.cell.partition(".values")[0] in columns)


def _attribute(item: Attribute, cells: dict[str, tuple[Source, ...]]) -> dict[str, Any]:
    out: dict[str, Any] = {"written": list(item.written)}
    if item.quantities:
        out["quantities"] = list(item.quantities)
    word = item.word
    if not word and not any(cells[name] for name in item.quantities):
        word = UNSOURCED
    return {**out, "word": word} if word else out


def _block(items: dict[str, Any]) -> str:
    """A JSON object with one item per line."""
    lines = [f"  {json.dumps(k)}: {json.dumps(v, ensure_ascii=False)}" for k, v in items.items()]
    return "{\n" + ",\n".join(lines) + "\n }"


FORMATS: Registry[Callable[[Arm], str]] = Registry(
    "format",
    {
        ".srdf": Row("lwr_dyn.arms.urdf.model_files:srdf_text", "rotors, for Pinocchio"),
        ".xml": Row("lwr_dyn.arms.export.mjcf:mjcf_text", "MJCF, for MuJoCo and Drake"),
        ".toml": Row("lwr_dyn.arms.export.data_file:data_file_text", "a data file with a DH table"),
    },
)
"""Ending of a file -> the arm's text in that format."""


def model_stem(arm: Arm) -> str:
    """ROBOT for the default reading of a robot of this package, else ROBOT_READING.

    >>> from lwr_dyn import load
    >>> model_stem(load("lwr4plus")), model_stem(load("lwr4plus", reading="computed"))
    ('lwr4plus', 'lwr4plus_computed')
    """
    default = readings(arm.name)[0] if arm.name in robots() else ""
    return arm.name if arm.reading == default else f"{arm.name}_{arm.reading}"


def model_files(arm: Arm, stem: str | None = None) -> dict[str, str]:
    """File name -> text: `.urdf`, `.provenance.json`, with rotors `.srdf`, with masses `.xml` (MJCF).

    No MJCF of moments without a mass that it cannot hold.

    Names begin with `stem`, or with `model_stem(arm)`.

    >>> from lwr_dyn import load
    >>> list(model_files(load("lwr4")))
    ['lwr4.urdf', 'lwr4.provenance.json']
    """
    stem = model_stem(arm) if stem is None else stem
    out = {f"{stem}.urdf": urdf_text(arm), f"{stem}.provenance.json": provenance_text(arm)}
    if any(link.rotor is not None for link in arm.chain.links):
        out[f"{stem}.srdf"] = srdf_text(arm)
    if arm.chain.bodies is not None:
        with suppress(MissingDataError):
            out[f"{stem}.xml"] = FORMATS.load(".xml")(arm)
    return out


def weightless_links(arm: Arm) -> tuple[str, ...]:
    """The moving links of mass 0."""
    return tuple(x.link for x in arm.chain.links if x.body is not None and x.body.mass == 0.0)


def srdf_text(arm: Arm) -> str:
    """The arm's known rotors as the `rotor_params` of an SRDF, which `pinocchio.loadRotorParameters` reads.

    Raises `MissingDataError` for an arm without any.
    """
    if all(link.rotor is None for link in arm.chain.links):
        raise MissingDataError(arm.name, "rotors", "an SRDF")
    lines = [
        '<?xml version="1.0" encoding="utf-8"?>',
        "<!--",
        f"  {comment(f'rotors of robot {arm.name}, reading {arm.reading}; written by lwr_dyn, do not edit')}",
        *(f"  {comment(line)}" for line in caveat_lines(arm)),
        "  for pinocchio.loadRotorParameters: mass is the rotor's moment of inertia about its axis [kg m^2];",
        "  armature = gear_ratio^2 mass",
        "-->",
        f"<robot name={quoteattr(arm.name)}>",
        "  <rotor_params>",
    ]
    for link in arm.chain.links:
        if link.rotor is not None:
            mass, ratio = number(link.rotor.inertia), number(link.rotor.gear_ratio)
            lines.append(f'    <joint name={quoteattr(link.joint)} mass="{mass}" gear_ratio="{ratio}"/>')
    return "\n".join([*lines, "  </rotor_params>", "</robot>"]) + "\n"
