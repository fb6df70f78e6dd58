"""What the readings of a paper differ in, for the page: the errata that not all of them apply, and the numbers."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import Pose, to_rpy
from lwr_dyn.pages.explorer.number_tables import joint_columns, link_columns, number_text


def slips_record(arms: Sequence[Arm]) -> dict[str, Any]:
    """Readings of one robot of the package as JSON values, in the order of the arms.

    `about` and `applied` (ids) of each reading; `errata`: id -> where, printed, read as, why, for those that not all
    readings apply; `numbers`: heading -> one text for each arm, for the numbers that are not the same.
    """
    paper = open_paper(arms[0].name)
    chosen = [paper.readings[arm.reading] for arm in arms]
    common = set.intersection(*(set(reading.errata) for reading in chosen))
    applied = [[name for name in reading.errata if name not in common] for reading in chosen]
    named = {name for names in applied for name in names}
    errata = {e.id: [e.where, e.printed, e.read_as, e.why] for e in paper.errata if e.id in named}
    about = [reading.about for reading in chosen]
    return {"about": about, "applied": applied, "errata": errata, "numbers": differing_numbers(arms)}


def differing_numbers(arms: Sequence[Arm]) -> dict[str, list[str]]:
    """Heading of a number -> its text for each arm, for the numbers that are not the same; arms have the same joints.

    Numbers are those of the tables, the tensors of links in their URDF frames, and the frames of joints and flange,
    each in the link before it.
    """
    cells = [_numbers(arm) for arm in arms]
    rows = {key: [mine.get(key, "") for mine in cells] for key in cells[0]}
    return {key: texts for key, texts in rows.items() if len(set(texts)) > 1}


def _numbers(arm: Arm) -> dict[str, str]:
    columns = (*joint_columns(arm), *link_columns(arm))
    frames = {joint.name: joint.origin for joint in arm.joints()} | {"flange": arm.flange()}
    out = {f"{cell.heading}, {column.unit}": cell.text or "unknown" for column in columns for cell in column.cells}
    for link, body in zip(arm.chain.links, arm.bodies(), strict=True):
        if body is not None and not body.unknown:
            entries = [body.inertia_com[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
            out[f"{link.link}, xx, yy, zz, xy, xz, yz, kg m²"] = ", ".join(number_text(float(x)) for x in entries)
    for name, pose in frames.items():
        out |= _frame_texts(name, pose)
    return out


def _frame_texts(name: str, pose: Pose) -> dict[str, str]:
    angles = np.degrees(to_rpy(pose.rotation))
    return {
        f"{name}, origin x, y, z, mm": ", ".join(number_text(1000.0 * float(x)) for x in pose.position),
        f"{name}, roll, pitch, yaw, deg": ", ".join(number_text(float(x)) for x in angles),
    }
