"""The link tree of a URDF: parents, fixed joints, path from root to tip, and the layout that an arm keeps of it.

Where the user names no tip, the arm is found from the root outward: where joints branch off, a chain twice as long as
any other goes on (an arm beside a head and wheels); an arm ends where fingers begin, shorter than itself. Where neither
is so, there are several arms or legs.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lwr_dyn.arms.urdf.parse import UrdfFile
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import UnknownNameError, UrdfError
from lwr_dyn.model.chain import ChainLink, JointKind, joint_motion
from lwr_dyn.model.file_layout import FileJoint, FileLayout, FixedLink
from lwr_dyn.model.spatial import SNAP, Pose, axis_to_z

KINDS = {
    "revolute": JointKind.REVOLUTE,
    "continuous": JointKind.REVOLUTE,
    "prismatic": JointKind.PRISMATIC,
}
"""URDF joint types with one degree of freedom."""

BASES = ("floating", "planar")
"""Types of joints that are held where they are the base of a chain."""


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """The tree of links; `locked` maps each locked joint to its value, mimics of locked joints included."""

    urdf: UrdfFile
    root: str
    out_of: Mapping[str, tuple[Any, ...]]
    """Link -> its child joints."""
    into: Mapping[str, Any]
    """Link -> its parent joint."""
    locked: Mapping[str, float]

    def is_fixed(self, joint: Any) -> bool:
        """Whether the joint is fixed or locked."""
        return joint.type == "fixed" or joint.name in self.locked

    def fixed_pose(self, joint: Any) -> Pose:
        """The pose of the child of a fixed or locked joint in its parent."""
        pose = origin_pose(joint.origin)
        if not self.locked.get(joint.name):
            return pose
        turn = axis_pose(joint)
        return pose @ turn @ joint_motion(KINDS[joint.type], self.locked[joint.name]) @ turn.inverse()

    def path_to(self, tip: str) -> list[Any]:
        """The joints from the root to a link; raises `UnknownNameError`, which names the ends of arms first."""
        if tip not in self.urdf.links:
            known = dict.fromkeys((*tips(self), *self.urdf.links))
            raise UnknownNameError(f"link of {self.urdf.file}", tip, known)
        path = []
        while tip != self.root:
            path.append(self.into[tip])
            tip = path[-1].parent
        return path[::-1]

    def fixed_to(self, link: str) -> list[tuple[str, Pose]]:
        """`link` and all links fixed to it, each with its pose in `link`."""
        parts = [(link, Pose.identity())]
        for here, pose in parts:
            parts += [(j.child, pose @ self.fixed_pose(j)) for j in self.out_of[here] if self.is_fixed(j)]
        return parts


def layout_of(
    tree: Tree, groups: Sequence[tuple[Any, str]], links: Sequence[ChainLink], flange: Pose, tip: str
) -> FileLayout:
    """The layout of the chain: `groups` are the root's and then each moving joint with the link that it moves."""
    carried, root = tree.urdf.carried, groups[0][1]
    fixed = tuple(_fixed_links(tree, link) for _, link in groups)
    resting = (root, *(x.link for x in fixed[0]))
    kept = [link for _, link in groups] + [x.link for row in fixed for x in row]
    return FileLayout(
        root=root,
        joints=tuple(_file_joint(tree, joint, link) for (joint, _), link in zip(groups[1:], links, strict=True)),
        flange=flange,
        fixed=fixed,
        shapes={name: carried.shapes[name] for name in kept},
        inertials={name: carried.inertials[name] for name in resting if name in carried.inertials},
        materials=carried.materials,
        tip=tip,
    )


def _fixed_links(tree: Tree, link: str) -> tuple[FixedLink, ...]:
    parts = [name for name, _ in tree.fixed_to(link)]
    into = [tree.into[name] for name in parts[1:]]
    return tuple(FixedLink(x.child, x.name, x.parent, tree.fixed_pose(x)) for x in into)


def _file_joint(tree: Tree, joint: Any, link: ChainLink) -> FileJoint:
    return FileJoint(
        joint=joint.name, parent=joint.parent, child=joint.child, origin=origin_pose(joint.origin),
        axis=tuple(float(x) for x in joint.axis), unlimited=joint.type == "continuous", before=link.before,
        transmission=tree.urdf.carried.transmissions.get(joint.name, ""),
    )  # fmt: skip


def build_tree(urdf: UrdfFile, lock: Mapping[str, float]) -> Tree:
    """The tree of a file with some joints locked.

    Raises `UrdfError`: no or several roots, a link with two parent joints, a loop, a lock outside the joint's limits;
    `UnknownNameError`: no moving joint of a locked name.
    """
    into: dict[str, Any] = {}
    out_of: dict[str, list[Any]] = {link: [] for link in urdf.links}
    for joint in urdf.joints.values():
        if joint.child in into:
            parents = f"carried by {into[joint.child].name} and {joint.name}"
            raise UrdfError(urdf.file, f"link {joint.child!r}", parents, "one joint, as in a tree")
        into[joint.child] = joint
        out_of[joint.parent].append(joint)
    roots = [link for link in urdf.links if link not in into]
    if len(roots) != 1:
        listed = f"{len(roots)} links without a parent: {', '.join(roots) or 'none'}"
        raise UrdfError(urdf.file, "tree", listed, "one root")
    reached = [roots[0]]
    for link in reached:
        reached += [joint.child for joint in out_of[link]]
    if len(reached) != len(urdf.links):
        lost = ", ".join(x for x in urdf.links if x not in reached)
        raise UrdfError(urdf.file, "tree", f"a loop through {lost}", "a tree")
    return Tree(urdf, roots[0], {k: tuple(v) for k, v in out_of.items()}, into, _locked(urdf, lock))


def _locked(urdf: UrdfFile, lock: Mapping[str, float]) -> dict[str, float]:
    """The locked joints, checked, with those that mimic one of them."""
    moving = [name for name, joint in urdf.joints.items() if joint.type in KINDS]
    locked = {}
    for name, value in lock.items():
        if name not in moving:
            raise UnknownNameError(f"moving joint of {urdf.file}", name, moving)
        low, up = position_limits(urdf.joints[name])
        low, up = -math.inf if low is None else low, math.inf if up is None else up
        if not (math.isfinite(value) and low <= value <= up):
            raise UrdfError(urdf.file, f"lock of joint {name!r}", repr(value), f"a number from {low} to {up}")
        locked[name] = float(value)
    return with_mimics(urdf, locked)


def with_mimics(urdf: UrdfFile, held: Mapping[str, float]) -> dict[str, float]:
    """Held joints with those that mimic one of them."""
    locked, moving = dict(held), [name for name, joint in urdf.joints.items() if joint.type in KINDS]
    mimics = [urdf.joints[name] for name in moving if urdf.joints[name].mimic is not None and name not in locked]
    while True:
        follow = [j for j in mimics if j.name not in locked and j.mimic.joint in locked]
        if not follow:
            return locked
        for joint in follow:
            locked[joint.name] = joint.mimic.multiplier * locked[joint.mimic.joint] + joint.mimic.offset


def position_limits(joint: Any) -> tuple[float | None, float | None]:
    """Lower and upper limit of a joint; None if missing or infinite."""
    if joint.limit is None or joint.type == "continuous":
        return None, None
    low, up = (None if x is None or math.isinf(x) else float(x) for x in (joint.limit.lower, joint.limit.upper))
    return low, up


def axis_pose(joint: Any) -> Pose:
    """The rotation of z onto the joint's axis."""
    return Pose(axis_to_z(joint.axis), np.zeros(3))


def origin_pose(matrix: Array | None) -> Pose:
    """A parsed `<origin>`; entries within rounding of 0 and +-1 are set to these, since pi/2 is not a float."""
    if matrix is None:
        return Pose.identity()
    rotation = matrix[:3, :3]
    whole = np.round(rotation)
    return Pose(np.where(np.abs(rotation - whole) <= SNAP, whole, rotation), matrix[:3, 3])


def with_held_joints(tree: Tree, tip: str) -> tuple[Tree, Mapping[str, float]]:
    """The tree with a free base and what branches off the chain held at 0 or the limit next to it; and these values.

    Raises `UrdfError` for a joint off the chain that a joint of the chain moves by `mimic`.
    """
    path = tree.path_to(tip)
    first = next((k for k, joint in enumerate(path) if not tree.is_fixed(joint) and joint.type not in BASES), len(path))
    held = {joint.name: 0.0 for joint in path[:first] if joint.type in BASES}
    moved, on_path = {x.name for x in path[first:] if not tree.is_fixed(x)}, {x.name for x in path}
    free = [x for x in tree.urdf.joints.values() if x.name not in on_path and not tree.is_fixed(x)]
    follows = {x.name for x in free if x.mimic is not None and x.mimic.joint in moved}
    beside = [x for x in free if x.name in follows or moved & {y.name for y in tree.path_to(x.parent)}]
    for joint in (x for x in beside if x.mimic is None):
        low, up = position_limits(joint)
        held[joint.name] = min(max(0.0, -math.inf if low is None else low), math.inf if up is None else up)
    locked = with_mimics(tree.urdf, {**tree.locked, **held})
    tied = [joint.name for joint in beside if joint.name not in locked]
    if tied:
        allowed = " ".join(f"--lock {name}=VALUE" for name in tied)
        fault = "off the chain, but a joint of the chain moves it (mimic)"
        raise UrdfError(tree.urdf.file, f"joint {', '.join(tied)}", fault, f"held at a value: {allowed}")
    return replace(tree, locked=locked), {name: locked[name] for name in locked if name not in tree.locked}


_ARM = 4
"""Joints that make an arm: with fewer behind them, branches are no fingers, and of fewer no branch is the arm."""
_LISTED = 12
"""Largest number of tips that one message lists."""
_FRAMES = ("tool0", "tcp", "end_effector", "gripper_frame_link", "flange")
"""Ends of names of links made to be the tip, the preferred first: tool0 is the flange of ROS-Industrial."""
_FINGERS = ("finger", "gripper", "jaw", "knuckle")


def obvious_tip(tree: Tree) -> str:
    """The link at the end of the only arm in a tree of several ends; raises `UrdfError` naming all arms and legs."""
    arms = tips(tree)
    if len(arms) == 1:
        return next(iter(arms))
    if not arms:  # what the chain to the deepest end lacks is said when it is read
        return max((link for link in tree.out_of if not tree.out_of[link]), key=lambda end: len(tree.path_to(end)))
    raise UrdfError(
        tree.urdf.file, "tip", f"the tree has {len(arms)} arms or legs", f"one of them by --tip: {listed(arms)}"
    )


def tips(tree: Tree) -> dict[str, int]:
    """The links at the ends of all arms and legs, each with the joints that move it, the most first."""
    found = [(_tip(tree, link), count) for link, count in _arms(tree)]
    return dict(sorted(found, key=lambda x: -x[1]))


def listed(arms: Mapping[str, int]) -> str:
    """Ends of arms with their joints, as a message lists them."""
    some = [f"{tip} ({n} joint{'s' if n > 1 else ''})" for tip, n in [*arms.items()][:_LISTED]]
    return f"{', '.join(some)}{' ...' if len(arms) > _LISTED else ''}"


def _arms(tree: Tree) -> list[tuple[str, int]]:
    """The last moving link of each arm, with the number of joints that move it."""
    lengths, todo = _lengths(tree), [(tree.root, 0)]
    found, smaller = list[tuple[str, int]](), list[tuple[str, int]]()
    while todo or (smaller and len(found) > 1):
        link, count = (todo or smaller).pop()
        branches = [j for part, _ in tree.fixed_to(link) for j in tree.out_of[part] if not tree.is_fixed(j)]
        ahead = sorted((j for j in branches if _walks(j, count)), key=lambda j: -lengths[j.name])
        longest, second = [*(lengths[j.name] for j in ahead), 0, 0][:2]
        if not ahead or (count >= _ARM and longest < count and _is_hand(branches, ahead[0], longest)):
            found.append((link, count))
            continue
        after = [(joint.child, count + _weight(joint)) for joint in ahead]
        going = 1 if longest >= max(_ARM, 2 * second) else len(after)
        todo += after[:going][::-1]
        smaller += after[going:][::-1]
    return [arm for arm in found if arm[1]]


def _is_hand(branches: Sequence[Any], first: Any, longest: int) -> bool:
    """Several fingers, or one last joint that is called so."""
    named = any(word in name.lower() for word in _FINGERS for name in (first.name, first.child))
    return len(branches) > 1 or (named and longest == 1)


def _lengths(tree: Tree) -> dict[str, int]:
    """The moving joints of the longest chain that begins with each joint."""
    order = [tree.root]
    for link in order:
        order += [joint.child for joint in tree.out_of[link]]
    below, lengths = dict.fromkeys(order, 0), dict[str, int]()
    for link in reversed(order[1:]):
        joint = tree.into[link]
        lengths[joint.name] = below[link] + (0 if tree.is_fixed(joint) else _weight(joint))
        below[joint.parent] = max(below[joint.parent], lengths[joint.name])
    return lengths


def _weight(joint: Any) -> int:
    return int(joint.type in KINDS and joint.mimic is None)


def _walks(joint: Any, count: int) -> bool:
    """Whether an arm can go through a joint: by one coordinate of its own, or as the base that is held."""
    return bool(_weight(joint)) or (count == 0 and joint.type in BASES)


def _tip(tree: Tree, link: str) -> str:
    """Of the links fixed to the last moving one: a frame made to be the tip, else the last before they branch."""
    parts = [part for part, _ in tree.fixed_to(link)]
    named = [part for frame in _FRAMES for part in parts if part.lower().endswith(frame)]
    while len(tree.out_of[link]) == 1 and tree.is_fixed(tree.out_of[link][0]):
        link = tree.out_of[link][0].child
    return named[0] if named else link
