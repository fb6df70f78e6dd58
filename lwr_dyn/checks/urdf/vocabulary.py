"""The tags and attributes of a URDF: what each element may hold, what it must, and how many numbers an attribute has.

Sources: the XML specification of urdf (wiki.ros.org/urdf/XML) with urdfdom 4's `capsule`; Drake's, Gazebo's and
ros2_control's own elements are named and not looked into.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

_POSE = {"xyz": 3, "rpy": 3}
_ALIEN = ("gazebo", "ros2_control", "sensor", "transmission", "mujoco", "plugin", "pybullet", "isaac", "loop_joint")
"""Elements of other programs, at any place."""


@dataclass(frozen=True, slots=True, eq=False)
class TagRule:
    """What an element may hold."""

    children: tuple[str, ...] = ()
    needed: tuple[str, ...] = ()
    """Attributes that must be there."""
    texts: tuple[str, ...] = ()
    """Attributes that are words."""
    figures: Mapping[str, int] | None = None
    """Attributes that are numbers, and how many."""
    only: tuple[str, ...] = ()
    """Children that engines read once: a second one is passed over."""

    @property
    def numeric(self) -> Mapping[str, int]:
        """Numeric attributes with their counts."""
        return self.figures or {}

    @property
    def attributes(self) -> tuple[str, ...]:
        """All attributes that are known."""
        return (*self.texts, *self.numeric)


def _figures(*needed: str, optional: tuple[str, ...] = (), texts: tuple[str, ...] = ()) -> TagRule:
    """An element whose attributes are single numbers."""
    return TagRule(needed=needed, texts=texts, figures={name: 1 for name in (*needed, *optional)})


_SHAPE = ("origin", "geometry", "material", "verbose", "contact_coefficients", "surface")
_ENDS = TagRule(texts=("link",), needed=("link",))
TAGS: Mapping[str, TagRule] = {
    "robot": TagRule(("link", "joint", "material", "frame", "muscle"), ("name",), ("name", "version")),
    "link": TagRule(
        ("inertial", "visual", "collision", "contact", "self_collision_checking"), ("name",), ("name", "type"),
        only=("inertial",),
    ),
    "joint": TagRule(
        ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller",
         "joint_properties", "hardwareInterface"),
        ("name", "type"), ("name", "type"),
        only=("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
    ),
    "inertial": TagRule(("origin", "mass", "inertia"), only=("origin", "mass", "inertia")),
    "visual": TagRule(_SHAPE, texts=("name", "concave", "group"), only=("origin", "geometry")),
    "collision": TagRule(_SHAPE, texts=("name", "concave", "group"), only=("origin", "geometry")),
    "origin": TagRule(figures={**_POSE, "quat_xyzw": 4, "quat_wxyz": 4}),
    "mass": _figures("value"),
    "inertia": _figures("ixx", "iyy", "izz", optional=("ixy", "ixz", "iyz")),
    "geometry": TagRule(("box", "cylinder", "sphere", "mesh", "capsule", "plane", "cdf", "ellipsoid")),
    "box": TagRule(needed=("size",), figures={"size": 3}),
    "cylinder": _figures("radius", "length"),
    "capsule": _figures("radius", "length"),
    "sphere": _figures("radius"),
    "mesh": TagRule(needed=("filename",), texts=("filename",), figures={"scale": 3}),
    "material": TagRule(("color", "texture"), texts=("name",)),
    "color": TagRule(needed=("rgba",), figures={"rgba": 4}),
    "texture": TagRule(texts=("filename",)),
    "axis": TagRule(needed=("xyz",), figures={"xyz": 3}),
    "parent": _ENDS,
    "child": _ENDS,
    "limit": _figures("effort", "velocity", optional=("lower", "upper", "acceleration", "jerk", "deceleration")),
    "dynamics": _figures(optional=("damping", "friction", "spring_reference", "spring_stiffness", "armature")),
    "mimic": _figures(optional=("multiplier", "offset"), texts=("joint",)),
    "calibration": _figures(optional=("rising", "falling", "reference_position")),
    "safety_controller": _figures("k_velocity", optional=("k_position", "soft_lower_limit", "soft_upper_limit")),
}  # fmt: skip
"""Elements that are looked into; children and attributes of others are not."""


def is_alien(tag: str) -> bool:
    """Whether an element belongs to another program: `drake:...`, `gazebo`, `ros2_control`."""
    return ":" in tag or tag in _ALIEN


@lru_cache(maxsize=4096)
def nearest(name: str, known: tuple[str, ...]) -> str:
    """The known name that a misspelt one is meant to be; empty where none is near.

    One slip (a letter left out, added, wrong, or two exchanged) in short names, two in those of six letters or more.

    >>> nearest("intertial", ("inertial", "visual")), nearest("xzy", ("xyz", "rpy")), nearest("gravity", ("inertial",))
    ('inertial', 'xyz', '')
    """
    slips = {other: _distance(name.lower(), other.lower()) for other in known}
    near = [other for other, count in slips.items() if count <= (2 if len(other) >= 6 else 1)]
    return min(near, key=lambda other: slips[other], default="")


def _distance(a: str, b: str) -> int:
    """Slips between two words: letters left out, added, wrong, neighbours exchanged."""
    if abs(len(a) - len(b)) > 2:
        return 9
    rows = [list(range(len(b) + 1))]
    for i, letter in enumerate(a, start=1):
        row = [i]
        for j, other in enumerate(b, start=1):
            best = min(row[-1] + 1, rows[-1][j] + 1, rows[-1][j - 1] + (letter != other))
            if i > 1 and j > 1 and letter == b[j - 2] and a[i - 2] == other:
                best = min(best, rows[-2][j - 2] + 1)
            row.append(best)
        rows.append(row)
    return rows[-1][-1]
