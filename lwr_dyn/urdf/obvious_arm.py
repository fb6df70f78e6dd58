"""Which chain of a tree is the arm, where the user names no tip; and what is held of the joints beside the chain.

From the root outward: where joints branch off, a chain twice as long as any other goes on (an arm beside a head and
wheels); an arm ends where fingers begin, shorter than itself. Where neither is so, there are several arms or legs.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from lwr_dyn.errors import UrdfError
from lwr_dyn.urdf.tree import KINDS, Tree, position_limits, with_mimics

_ARM = 4
"""Joints that make an arm: with fewer behind them, branches are no fingers, and of fewer no branch is the arm."""
_LISTED = 12
"""Largest number of tips that one message lists."""
_FRAMES = ("tool0", "tcp", "end_effector", "gripper_frame_link", "flange")
"""Ends of names of links made to be the tip, the preferred first: tool0 is the flange of ROS-Industrial."""
_FINGERS = ("finger", "gripper", "jaw", "knuckle")
_HELD_BASES = ("floating", "planar")


def obvious_tip(tree: Tree) -> str:
    """The link at the end of the only arm; raises `UrdfError` naming the tips of all arms and legs."""
    ends = [link for link, joints in tree.out_of.items() if not joints]
    if len(ends) == 1 and all(tree.is_fixed(joint) or _weight(joint) for joint in tree.path_to(ends[0])):
        return ends[0]
    arms = [(_tip(tree, link), count) for link, count in _arms(tree)]
    if len(arms) < 2:
        return arms[0][0] if arms else ends[0]
    some = [f"{tip} ({n} joint{'s' if n > 1 else ''})" for tip, n in sorted(arms, key=lambda x: -x[1])[:_LISTED]]
    allowed = f"one of them by --tip: {', '.join(some)}{' ...' if len(arms) > _LISTED else ''}"
    raise UrdfError(tree.urdf.file, "tip", f"the tree has {len(arms)} arms or legs", allowed)


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
    return bool(_weight(joint)) or (count == 0 and joint.type in _HELD_BASES)


def _tip(tree: Tree, link: str) -> str:
    """Of the links fixed to the last moving one: a frame made to be the tip, else the last before they branch."""
    parts = [part for part, _ in tree.fixed_to(link)]
    named = [part for frame in _FRAMES for part in parts if part.lower().endswith(frame)]
    while len(tree.out_of[link]) == 1 and tree.is_fixed(tree.out_of[link][0]):
        link = tree.out_of[link][0].child
    return named[0] if named else link


def with_held_joints(tree: Tree, tip: str) -> tuple[Tree, Mapping[str, float]]:
    """The tree with a free base and all that branches off the chain held, and the values [rad or m] of what is held.

    A joint is held at 0, or at its limit next to 0; one that follows a held joint follows it. Raises `UrdfError` for a
    joint beside the chain that follows one of the chain.
    """
    path = tree.path_to(tip)
    held: dict[str, float] = {}
    for joint in path:
        if joint.type in _HELD_BASES:
            held[joint.name] = 0.0
        elif not tree.is_fixed(joint):
            break
    moved = {x.name for x in path if not tree.is_fixed(x)} - set(held)
    on_path = {x.name for x in path}
    free = [x for x in tree.urdf.joints.values() if x.name not in on_path and not tree.is_fixed(x)]
    follows = {x.name for x in free if x.mimic is not None and x.mimic.joint in moved}
    beside = [x for x in free if x.name in follows or moved & {y.name for y in tree.path_to(x.parent)}]
    held |= {x.name: _rest(x) for x in beside if x.mimic is None}
    locked = with_mimics(tree.urdf, {**tree.locked, **held})
    tied = [joint.name for joint in beside if joint.name not in locked]
    if tied:
        allowed = " ".join(f"--lock {name}=VALUE" for name in tied)
        fault = "off the chain, but a joint of the chain moves it (mimic)"
        raise UrdfError(tree.urdf.file, f"joint {', '.join(tied)}", fault, f"held at a value: {allowed}")
    return replace(tree, locked=locked), {name: locked[name] for name in locked if name not in tree.locked}


def _rest(joint: Any) -> float:
    low, up = position_limits(joint)
    return min(max(0.0, -math.inf if low is None else low), math.inf if up is None else up)
