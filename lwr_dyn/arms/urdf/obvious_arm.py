"""Which chain of a tree is the arm, where the user names no tip.

From the root outward: where joints branch off, a chain twice as long as any other goes on (an arm beside a head and
wheels); an arm ends where fingers begin, shorter than itself. Where neither is so, there are several arms or legs.
"""

from collections.abc import Sequence
from typing import Any

from lwr_dyn.arms.urdf.tree import BASES, KINDS, Tree
from lwr_dyn.foundation.errors import UrdfError

_ARM = 4
"""Joints that make an arm: with fewer behind them, branches are no fingers, and of fewer no branch is the arm."""
_LISTED = 12
"""Largest number of tips that one message lists."""
_FRAMES = ("tool0", "tcp", "end_effector", "gripper_frame_link", "flange")
"""Ends of names of links made to be the tip, the preferred first: tool0 is the flange of ROS-Industrial."""
_FINGERS = ("finger", "gripper", "jaw", "knuckle")


def obvious_tip(tree: Tree) -> str:
    """The link at the end of the only arm in a tree of several ends; raises `UrdfError` naming all arms and legs."""
    arms = [(_tip(tree, link), count) for link, count in _arms(tree)]
    if len(arms) == 1:
        return arms[0][0]
    if not arms:  # what the chain to the deepest end lacks is said when it is read
        return max((link for link in tree.out_of if not tree.out_of[link]), key=lambda end: len(tree.path_to(end)))
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
    return bool(_weight(joint)) or (count == 0 and joint.type in BASES)


def _tip(tree: Tree, link: str) -> str:
    """Of the links fixed to the last moving one: a frame made to be the tip, else the last before they branch."""
    parts = [part for part, _ in tree.fixed_to(link)]
    named = [part for frame in _FRAMES for part in parts if part.lower().endswith(frame)]
    while len(tree.out_of[link]) == 1 and tree.is_fixed(tree.out_of[link][0]):
        link = tree.out_of[link][0].child
    return named[0] if named else link
