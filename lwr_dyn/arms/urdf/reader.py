"""Reads a foreign URDF as an Arm: the chain from root to tip, fixed links merged.

A limit that is missing, infinite, or (effort, velocity) zero is unknown; a continuous joint has no position limits;
placeholders that our own header lists are unknown again. Links fixed to the root do not move and are left out. A moving
link without `<inertial>` is massless, as the format defines, if a link further out has mass; otherwise it has no body,
and the arm no dynamics.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.assembly import STANDARD_GRAVITY
from lwr_dyn.arms.urdf.elements import PLACEHOLDERS
from lwr_dyn.arms.urdf.parse import UrdfFile, parse_urdf, placeholder_name
from lwr_dyn.arms.urdf.tree import (
    KINDS,
    Tree,
    axis_pose,
    build_tree,
    layout_of,
    listed,
    obvious_tip,
    origin_pose,
    position_limits,
    tips,
    with_held_joints,
)
from lwr_dyn.foundation.errors import UrdfError
from lwr_dyn.model.arm import Arm, JointLimits, Source
from lwr_dyn.model.chain import Body, Chain, ChainLink
from lwr_dyn.model.file_layout import WrittenLink, heavy, welded
from lwr_dyn.model.spatial import Pose

READING = "urdf"
"""The reading of an arm that comes from a URDF."""
_LISTED = 6
"""Largest number of other ends that a note lists."""
_OWN_LINKS = ("base", "flange")
"""Link names that our writer uses; a moving link of that name gets an underscore."""


@dataclass(frozen=True, slots=True, eq=False)
class _Group:
    """Links that move together: the joint that moves them, the links, and the path through them to the next joint."""

    joint: Any
    link: str
    parts: tuple[tuple[str, Pose], ...]
    """Every link of the group with its pose in `link`."""
    exit: Pose
    through: tuple[str, ...]
    """The fixed joints on the path to the next joint or the tip."""


def read_urdf(
    path: str | Path,
    tip: str | None = None,
    lock: Mapping[str, float] | None = None,
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
) -> Arm:
    """The serial arm in a URDF file: its joints and links keep the file's names, joints beside the chain are held.

    Parameters
    ----------
    path : path
    tip : str, optional
        The link that is the flange; if not given the only end, or that of the one obvious arm. `notes` says which.
    lock : mapping of joint name to value, optional
        Joints fixed at a value [rad or m]; a mimic joint follows the locked joint that it mimics.
    xacro_args : mapping, optional
        Arguments of a `.xacro` file.
    trust_xacro : bool
        Whether its expressions run as Python.

    Raises
    ------
    FileAccessError, MissingPackageError
        The file cannot be read; it is a `.xacro` and xacro is not installed.
    UrdfError
        Not a URDF, not a tree, a joint of the chain that is not revolute, continuous, prismatic or fixed or that
        follows another one, several arms and no tip, a lock outside the joint's limits.
    UnknownNameError
        No link named `tip`, no moving joint of a locked name.
    """
    return arm_in(parse_urdf(path, xacro_args, trust_xacro), tip, lock)


def arm_in(urdf: UrdfFile, tip: str | None, lock: Mapping[str, float] | None) -> Arm:
    """The serial arm in a parsed file, or in another form with the same fields; raises as `read_urdf` for its tree."""
    chosen = chosen_chain(build_tree(urdf, lock or {}), tip)
    tree, given, tip, held = chosen.tree, tip, chosen.tip, chosen.held
    base, *groups = chosen.groups
    names = [_free_name(group.link, urdf.links) for group in groups]
    written = [
        tuple(WrittenLink(part, _body(urdf.links[part], pose)) for part, pose in group.parts) for group in groups
    ]
    bodies = _bodies(written)
    links = []
    for before, group, name, body in zip([base, *groups], groups, names, bodies, strict=False):
        joint, turn = group.joint, axis_pose(group.joint)
        pose = before.exit @ origin_pose(joint.origin) @ turn
        rotor = urdf.rotors.get(joint.name)
        links.append(ChainLink(joint.name, name, KINDS[joint.type], pose, turn.inverse(), body, rotor))
    layout = layout_of(tree, [(x.joint, x.link) for x in (base, *groups)], links, groups[-1].exit, tip)
    gravity = np.array(STANDARD_GRAVITY if urdf.gravity is None else urdf.gravity)
    return Arm(
        name=urdf.name, reading=READING, title=f"read from {urdf.file}",
        chain=Chain(links=tuple(links), flange=groups[-1].exit, gravity=gravity),
        limits=tuple(joint_limits(urdf, group.joint) for group in groups),
        sources=_sources(urdf, [base, *groups], written, names), digest=urdf.digest,
        layout=replace(layout, written=_by_carrier(tree, names, written)),
        notes=(*_notes(tree, () if given else chosen.ends, tip, held), *_passed_over(urdf)), caveats=urdf.caveats,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class ChosenChain:
    """The chain that is read of a tree."""

    tree: Tree
    """With what is held beside the chain."""
    ends: tuple[str, ...]
    tip: str
    held: Mapping[str, float]
    groups: tuple[_Group, ...]
    """The root's, then one for each moving joint."""


def chosen_chain(tree: Tree, tip: str | None = None) -> ChosenChain:
    """The chain to a tip, or to that of the one obvious arm; raises `UrdfError` and `UnknownNameError` as `read_urdf`.

    An error whose element has no `<` is about a sound file in which no serial chain is chosen.
    """
    ends = tuple(link for link, joints in tree.out_of.items() if not joints)
    tip = tip or (ends[0] if len(ends) == 1 else obvious_tip(tree))
    tree, held = with_held_joints(tree, tip)
    return ChosenChain(tree, ends, tip, held, tuple(_groups(tree, tree.path_to(tip))))


def _notes(tree: Tree, ends: Sequence[str], tip: str, held: Mapping[str, float]) -> tuple[str, ...]:
    """What was chosen without being asked for: the tip among several ends, and the joints that are held."""
    others = [end for end in ends if end != tip and any(x.type in KINDS for x in tree.path_to(end))]
    some = f", such as {', '.join(others[:_LISTED])}{' ...' if len(others) > _LISTED else ''}" if others else ""
    lines = [f"the arm ends at {tip}; another end: --tip LINK{some}"] if ends not in ((), (tip,)) else []
    values = ", ".join(f"{name} at {value:g}" for name, value in held.items())
    return (*lines, f"held: {values}; other values: --lock JOINT=VALUE") if held else tuple(lines)


def _passed_over(urdf: UrdfFile) -> tuple[str, ...]:
    if not urdf.leftovers:
        return ()
    return (f"{urdf.file}: {', '.join(urdf.leftovers)} left over from xacro, passed over as every reader does",)


def _free_name(link: str, taken: Mapping[str, Any]) -> str:
    while link in _OWN_LINKS:
        link += "_"
        while link in taken:
            link += "_"
    return link


def _groups(tree: Tree, path: Sequence[Any]) -> list[_Group]:
    """The root's group, then one for each moving joint of the path."""
    moving = [joint for joint in path if not tree.is_fixed(joint)]
    for joint in moving:
        _check_moving(tree.urdf, joint)
    if not moving:
        free = "".join(f", and {joint.name} of type {joint.type} is held" for joint in path if joint.type != "fixed")
        found = f"no moving joint between root and tip{free}"
        others = listed(tips(tree))
        raise UrdfError(
            tree.urdf.file, "chain", found, f"another tip{f': {others};' if others else ','} or fewer locks"
        )
    starts = [-1, *(k for k, joint in enumerate(path) if joint in moving), len(path)]
    out = []
    for start, end in pairwise(starts):
        link = tree.root if start < 0 else path[start].child
        parts = () if start < 0 else tuple(tree.fixed_to(link))
        exit_pose = Pose.identity()
        for joint in path[start + 1 : end]:
            exit_pose = exit_pose @ tree.fixed_pose(joint)
        through = tuple(joint.name for joint in path[start + 1 : end])
        out.append(_Group(None if start < 0 else path[start], link, parts, exit_pose, through))
    return out


def _check_moving(urdf: UrdfFile, joint: Any) -> None:
    where, end = f"joint {joint.name!r}", f"a chain that ends before it: --tip {joint.parent}"
    if joint.type not in KINDS:
        found = f"type {joint.type}, in a chain of joints with one coordinate each"
        raise UrdfError(urdf.file, where, found, f"{end}, or a file with revolute, continuous, prismatic, fixed joints")
    if joint.mimic is not None:
        found = f"follows {joint.mimic.joint!r} (mimic), in a chain of joints that move by themselves"
        raise UrdfError(urdf.file, where, found, f"{end}, or held: --lock {joint.name}=VALUE")
    if not np.abs(joint.axis).max() > 0.0:
        raise UrdfError(urdf.file, f"{where} <axis> xyz", "0 0 0", "a direction")


def _by_carrier(
    tree: Tree, names: Sequence[str], written: Sequence[tuple[WrittenLink, ...]]
) -> dict[str, tuple[WrittenLink, ...]]:
    """The links of the file by the link of the chain that carries them; those at rest under ""."""
    resting = tuple(WrittenLink(x, _body(tree.urdf.links[x], pose)) for x, pose in tree.fixed_to(tree.root))
    return {"": resting, **dict(zip(names, written, strict=True))}


def _bodies(written: Sequence[tuple[WrittenLink, ...]]) -> list[Body | None]:
    """One body for the links that move together, from the outermost inward."""
    out: list[Body | None] = []
    for links in reversed(written):
        body = welded(links)
        outside = any(x is not None and x.mass > 0.0 for x in out)
        out.append(Body.massless() if body is None and outside else body)
    return out[::-1]


def _body(link: Any, pose: Pose) -> Body | None:
    """The body of a parsed link at a pose."""
    if link.inertial is None:
        return None
    at_com = Body(link.inertial.mass, np.zeros(3), link.inertial.inertia)
    return at_com.seen_from(origin_pose(link.inertial.origin)).seen_from(pose)


def joint_limits(urdf: UrdfFile, joint: Any) -> JointLimits:
    """Limits and friction of a joint; raises `UrdfError` for exchanged limits and for numbers below 0."""
    lower, upper = position_limits(joint)
    if lower is not None and upper is not None and lower > upper:
        raise UrdfError(urdf.file, f"joint {joint.name!r} <limit>", f"lower {lower}, upper {upper}", "lower <= upper")
    values: dict[str, float | None] = {"lower": lower, "upper": upper}
    for name in ("velocity", "effort"):
        value = None if joint.limit is None else getattr(joint.limit, name)
        values[name] = None if value is None or value == 0.0 or np.isinf(value) else value
    for tag, name in (("damping", "viscous"), ("friction", "coulomb")):
        text = None if joint.dynamics is None else getattr(joint.dynamics, tag)
        values[name] = None if text is None else float(text)
    for name, value in values.items():
        if name not in ("lower", "upper") and value is not None and value < 0.0:
            raise UrdfError(urdf.file, f"joint {joint.name!r} {name}", repr(value), "a number of at least 0")
        if placeholder_name(joint.name, name) in urdf.placeholders and value == PLACEHOLDERS.get(name):
            values[name] = None
    return JointLimits(**values)


def _sources(
    urdf: UrdfFile, groups: Sequence[_Group], written: Sequence[tuple[WrittenLink, ...]], names: Sequence[str]
) -> dict[str, tuple[Source, ...]]:
    """Quantity of the arm -> the elements of the file that it is computed from."""

    def cell(path: str, conversion: str) -> Source:
        return Source(f"/robot/{path}", urdf.file, "URDF", "as in the file", "SI", conversion)

    def origins(joints: Sequence[str]) -> tuple[Source, ...]:
        return tuple(cell(f"joint[@name='{j}']/origin", "origins and locked joints multiplied") for j in joints)

    out = {"flange": origins(groups[-1].through)}
    for before, group, links, name in zip(groups, groups[1:], written, names, strict=False):
        joint = group.joint.name
        at = f"joint[@name='{joint}']"
        out[f"{joint}.before"] = origins((*before.through, joint))
        out[f"{joint}.after"] = (cell(f"{at}/axis", "z turned onto the axis"),)
        for tag in ("lower", "upper", "velocity", "effort"):
            out[f"{joint}.{tag}"] = (cell(f"{at}/limit/@{tag}", "as written"),)
        for tag, quantity in (("damping", "viscous"), ("friction", "coulomb")):
            out[f"{joint}.{quantity}"] = (cell(f"{at}/dynamics/@{tag}", "as written"),)
        for tag in ("gear_ratio", "rotor_inertia"):
            out[f"{joint}.{tag}"] = (cell(f"transmission[joint/@name='{joint}']/actuator/drake:{tag}", "as written"),)
        fixed = [part for part, _ in heavy(links)]
        how = "as written" if fixed == [group.link] else f"welded to {group.link}"
        massless = (cell(f"link[@name='{group.link}']", "no <inertial>: massless, by the format"),)
        for tag in ("mass", "com", "inertia"):
            out[f"{name}.{tag}"] = tuple(cell(f"link[@name='{x}']/inertial", how) for x in fixed) or massless
    return out
