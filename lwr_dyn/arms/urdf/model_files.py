"""All files of an arm: URDF, provenance sidecar, SRDF with the rotors, MJCF."""

from collections.abc import Callable
from xml.sax.saxutils import quoteattr

from lwr_dyn.arms.papers.catalog import readings, robots
from lwr_dyn.arms.urdf.provenance import provenance_text
from lwr_dyn.arms.urdf.writer import urdf_text
from lwr_dyn.arms.urdf.xml_text import comment, number
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm

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
    >>> model_stem(load("lwr4plus")), model_stem(load("lwr4plus", reading="physical"))
    ('lwr4plus', 'lwr4plus_physical')
    """
    default = readings(arm.name)[0] if arm.name in robots() else ""
    return arm.name if arm.reading == default else f"{arm.name}_{arm.reading}"


def model_files(arm: Arm, stem: str | None = None) -> dict[str, str]:
    """File name -> text: `.urdf`, `.provenance.json`, with rotors `.srdf`, with masses of all links `.xml` (MJCF).

    Names begin with `stem`, or with `model_stem(arm)`.

    >>> from lwr_dyn import load
    >>> list(model_files(load("lwr4")))
    ['lwr4.urdf', 'lwr4.provenance.json']
    """
    stem = model_stem(arm) if stem is None else stem
    out = {f"{stem}.urdf": urdf_text(arm), f"{stem}.provenance.json": provenance_text(arm)}
    if any(link.rotor is not None for link in arm.chain.links):
        out[f"{stem}.srdf"] = srdf_text(arm)
    if arm.chain.bodies is not None and not weightless_links(arm):
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
