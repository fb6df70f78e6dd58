"""The files that belong to an arm: URDF, its sidecars, and where the arm has inertias the MJCF."""

from __future__ import annotations

from lwr_dyn.model.arm import Arm
from lwr_dyn.papers.catalog import readings, robots
from lwr_dyn.urdf.mjcf import mjcf_text
from lwr_dyn.urdf.provenance import provenance_text
from lwr_dyn.urdf.srdf import srdf_text
from lwr_dyn.urdf.writer import urdf_text


def model_stem(arm: Arm) -> str:
    """ROBOT for the default reading of a robot of the data room, else ROBOT_READING.

    >>> from lwr_dyn.front import load
    >>> model_stem(load("lwr4plus")), model_stem(load("lwr4plus", reading="physical"))
    ('lwr4plus', 'lwr4plus_physical')
    """
    default = readings(arm.name)[0] if arm.name in robots() else ""
    return arm.name if arm.reading == default else f"{arm.name}_{arm.reading}"


def model_files(arm: Arm, stem: str | None = None) -> dict[str, str]:
    """File name -> text: `.urdf`, `.provenance.json`; `.srdf` where rotors, `.xml` (MJCF) where inertias are given.

    >>> from lwr_dyn.front import load
    >>> list(model_files(load("lwr4")))
    ['lwr4.urdf', 'lwr4.provenance.json']
    """
    stem = model_stem(arm) if stem is None else stem
    out = {f"{stem}.urdf": urdf_text(arm), f"{stem}.provenance.json": provenance_text(arm)}
    if any(link.rotor is not None for link in arm.chain.links):
        out[f"{stem}.srdf"] = srdf_text(arm)
    if arm.chain.bodies is not None:
        out[f"{stem}.xml"] = mjcf_text(arm)
    return out
