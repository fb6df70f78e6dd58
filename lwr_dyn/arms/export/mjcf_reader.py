"""Reads the MJCF that `mjcf_text` writes back as an arm: one chain of bodies, a motor a joint, poses as `xyaxes`.

Others' MJCF is refused: its defaults, classes and other ways to give an orientation or an inertia are not read here.
Speed limits stand in our header. What neither holds is unknown in the arm: limits of one side, gear ratios, friction by
direction.
"""

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from lwr_dyn.arms.export.mjcf import SPEEDS, UNKNOWN
from lwr_dyn.arms.urdf.parse import finite_numbers, own_caveats, own_header, parse_xml
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import UnknownNameError, UrdfError
from lwr_dyn.foundation.files import read_bytes
from lwr_dyn.model.arm import Arm, JointLimits, Source
from lwr_dyn.model.chain import Body, Chain, ChainLink, JointKind, Rotor
from lwr_dyn.model.spatial import SNAP, Pose

READING = "mjcf"
"""The reading of an arm that comes from an MJCF."""
OWN = "an MJCF that lwr_dyn wrote (lwr-dyn urdf ROBOT --out FILE.urdf), or the robot as a .urdf"
"""What is allowed in place of another's MJCF."""
_KINDS = {"hinge": JointKind.REVOLUTE, "slide": JointKind.PRISMATIC}
_ROTATION = 1e-9
"""By which the axes of a frame may miss a rotation."""


def read_mjcf(path: str | Path, reading: str | None = None, lock: Mapping[str, float] | None = None) -> Arm:
    """The arm of an MJCF that this package wrote, in the frames of the file; a mount and a tool are part of its ends.

    Raises
    ------
    FileAccessError
        The file cannot be read.
    UrdfError
        No MJCF, or not one of this package; a number that is missing or wrong: says of which body or joint.
    UnknownNameError
        A reading, or a locked joint that does not exist; otherwise as `Arm.with_locked_joint`.

    >>> import lwr_dyn, tempfile
    >>> from lwr_dyn.arms.export.mjcf import mjcf_text
    >>> file = Path(tempfile.mkdtemp()) / "arm.xml"
    >>> _ = file.write_text(mjcf_text(lwr_dyn.load("lwr4plus")))
    >>> read_mjcf(file).armature[0].round(6)
    np.float64(0.160325)
    """
    if reading is not None:
        raise UnknownNameError("reading of an MJCF", reading, ())
    arm = _arm(_Mjcf(read_bytes(path, "a readable .xml file"), Path(path).name))
    for joint, value in (lock or {}).items():
        arm = arm.with_locked_joint(joint, value)
    return arm


class _Mjcf:
    """The parsed file; its methods raise `UrdfError`."""

    def __init__(self, content: bytes, file: str) -> None:
        self.file, self.digest = file, hashlib.sha256(content).hexdigest()
        self.root = parse_xml(content, file, "MJCF")
        self.header = own_header(content.decode("utf-8", errors="replace"))
        if self.root.tag == "robot":
            raise UrdfError(file, "<robot>", "a URDF", "a name that ends in .urdf, or an MJCF that lwr_dyn wrote")
        if self.root.tag != "mujoco":
            raise UrdfError(file, f"<{self.root.tag}>", "the outermost element", f"<mujoco>: {OWN}")
        if not self.header:
            raise UrdfError(file, "<mujoco>", "not written by lwr_dyn, whose MJCF alone is read", OWN)

    def fault(self, where: str, found: str, allowed: str) -> UrdfError:
        return UrdfError(self.file, where, found, allowed)

    def one(self, parent: ElementTree.Element, tag: str, where: str) -> ElementTree.Element:
        """The only element of a tag."""
        found = parent.findall(tag)
        if len(found) != 1:
            raise self.fault(where, f"{len(found)} elements <{tag}>", f"one, as in {OWN}")
        return found[0]

    def array(self, element: ElementTree.Element, name: str, count: int, where: str) -> Array:
        """The numbers of an attribute."""
        text = element.get(name, "")
        found = finite_numbers(text)
        if found is None or len(found) != count:
            raise self.fault(f"{where} <{element.tag}> {name}", repr(text), f"{count} finite numbers")
        return np.array(found)

    def known(self, element: ElementTree.Element, name: str, where: str) -> float | None:
        """A number of at least 0; None where it is not given."""
        if element.get(name) is None:
            return None
        value = float(self.array(element, name, 1, where)[0])
        if value < 0.0:
            raise self.fault(f"{where} <{element.tag}> {name}", repr(element.get(name)), "a number of at least 0")
        return value

    def pose(self, element: ElementTree.Element, where: str) -> Pose:
        """Of a body or a site in its parent."""
        if element.get("pos") is None and element.get("xyaxes") is None:
            return Pose.identity()
        position = self.array(element, "pos", 3, where)
        if element.get("xyaxes") is None:
            return Pose(np.eye(3), position)
        x, y = self.array(element, "xyaxes", 6, where).reshape(2, 3)
        rotation = np.column_stack([x, y, np.cross(x, y)])
        if np.abs(rotation.T @ rotation - np.eye(3)).max() > _ROTATION:
            found = repr(element.get("xyaxes"))
            raise self.fault(f"{where} <{element.tag}> xyaxes", found, "two directions of length 1 at a right angle")
        whole = np.round(rotation)
        return Pose(np.where(np.abs(rotation - whole) <= SNAP, whole, rotation), position)

    def name(self, element: ElementTree.Element, where: str) -> str:
        name = element.get("name", "")
        if not name.isprintable() or not name:
            raise self.fault(where, f"the name {name!r}", "a name of letters that can be printed in a line")
        return name

    def bodies(self) -> Iterator[tuple[ElementTree.Element, str]]:
        """The bodies from the base outward, each with its place in words."""
        body = self.one(self.one(self.root, "worldbody", "<mujoco>"), "body", "<worldbody>")
        while True:
            where = f"body {self.name(body, '<body>')!r}"
            yield body, where
            inside = body.findall("body")
            if not inside:
                return
            body = self.one(body, "body", where)

    def body(self, element: ElementTree.Element, where: str) -> Body:
        """The inertial of a moving body."""
        inertial = self.one(element, "inertial", where)
        (mass,), com = self.array(inertial, "mass", 1, where), self.array(inertial, "pos", 3, where)
        if mass < 0.0:
            raise self.fault(f"{where} <inertial> mass", repr(inertial.get("mass")), "a mass of at least 0")
        xx, yy, zz, xy, xz, yz = self.array(inertial, "fullinertia", 6, where)
        return Body(float(mass), com, np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))

    def joint(self, element: ElementTree.Element, where: str) -> ElementTree.Element:
        """The joint of a moving body: about or along z of its frame."""
        joint = self.one(element, "joint", where)
        if joint.get("type") not in _KINDS:
            raise self.fault(f"{where} <joint> type", repr(joint.get("type")), ", ".join(_KINDS))
        if self.array(joint, "axis", 3, where).tolist() != [0.0, 0.0, 1.0] or joint.get("pos") is not None:
            raise self.fault(f"{where} <joint>", "an axis beside z of the body", f"0 0 1, as in {OWN}")
        return joint

    def speeds(self, count: int) -> list[float | None]:
        """The speed limits in our header, by joint; all unknown where it has none."""
        line = next((x.removeprefix(SPEEDS) for x in self.header if x.startswith(SPEEDS)), " ".join([UNKNOWN] * count))
        known = finite_numbers(line.replace(UNKNOWN, "0"))
        if known is None or len(known) != count or min(known) < 0.0:
            raise self.fault("header", f"{SPEEDS}{line}", f"{count} numbers of at least 0, or {UNKNOWN}")
        return [None if word == UNKNOWN else x for word, x in zip(line.split(), known, strict=True)]

    def limits(self, joint: ElementTree.Element, where: str, speed: float | None) -> JointLimits:
        lower, upper = (None, None) if joint.get("range") is None else self.array(joint, "range", 2, where).tolist()
        if lower is not None and upper is not None and lower > upper:
            raise self.fault(f"{where} <joint> range", repr(joint.get("range")), "the lower limit first")
        name, motors = joint.get("name"), self.root.findall("actuator/motor")
        motor = next((x for x in motors if x.get("joint") == name), None)
        effort = None
        if motor is not None and motor.get("ctrlrange") is not None:
            effort = float(self.array(motor, "ctrlrange", 2, f"motor of {name!r}")[1])
        viscous, coulomb = (self.known(joint, key, where) for key in ("damping", "frictionloss"))
        return JointLimits(lower, upper, speed, effort, viscous=viscous, coulomb=coulomb)


def _arm(file: _Mjcf) -> Arm:
    (base, at_base), *moving, (flange, at_flange) = _three(file)
    before, links, limits = file.pose(base, at_base), list[ChainLink](), list[JointLimits]()
    for (body, where), speed in zip(moving, file.speeds(len(moving)), strict=True):
        joint = file.joint(body, where)
        inertia = file.known(joint, "armature", where)
        rotor = None if inertia is None else Rotor(1.0, inertia, reflected=True)
        kind, pose = _KINDS[joint.attrib["type"]], before @ file.pose(body, where)
        name = file.name(joint, where)
        links.append(ChainLink(name, body.attrib["name"], kind, pose, Pose.identity(), file.body(body, where), rotor))
        limits.append(file.limits(joint, where, speed))
        before = Pose.identity()
    for part, names in (("joint", [x.joint for x in links]), ("body", [x.link for x in links])):
        twice = next((x for k, x in enumerate(names) if x in names[:k]), None)
        if twice is not None:
            raise file.fault(f"{part} {twice}", "used twice", "a name of its own")
    tool = flange.find("site")
    end = file.pose(flange, at_flange) @ (Pose.identity() if tool is None else file.pose(tool, at_flange))
    gravity = file.array(file.one(file.root, "option", "<mujoco>"), "gravity", 3, "<mujoco>")
    return Arm(
        name=file.root.get("model") or "robot", reading=READING, title=f"read from {file.file}",
        chain=Chain(tuple(links), end, gravity), limits=tuple(limits), sources=_sources(file.file, links),
        digest=file.digest, caveats=own_caveats(file.header),
    )  # fmt: skip


def _three(file: _Mjcf) -> list[tuple[ElementTree.Element, str]]:
    """The base, at least one moving body, the flange."""
    bodies = list(file.bodies())
    if len(bodies) < 3:
        raise file.fault("<worldbody>", f"{len(bodies)} bodies", f"a base, moving bodies and a flange, as in {OWN}")
    return bodies


def _sources(file: str, links: list[ChainLink]) -> dict[str, tuple[Source, ...]]:
    def cell(path: str, conversion: str = "as written") -> tuple[Source, ...]:
        return (Source(f"//{path}", file, "MJCF", "as in the file", "SI", conversion),)

    out = {"flange": cell("body[@name='flange']/@pos, @xyaxes")}
    for link in links:
        body, joint = f"body[@name='{link.link}']", f"joint[@name='{link.joint}']"
        out[f"{link.joint}.before"] = cell(f"{body}/@pos, @xyaxes")
        for name, attribute in (
            ("lower", "range"),
            ("upper", "range"),
            ("viscous", "damping"),
            ("coulomb", "frictionloss"),
        ):
            out[f"{link.joint}.{name}"] = cell(f"{joint}/@{attribute}")
        out[f"{link.joint}.velocity"] = cell("comment()", "speed limits of the header")
        out[f"{link.joint}.effort"] = cell(f"motor[@joint='{link.joint}']/@ctrlrange")
        for name in ("gear_ratio", "rotor_inertia"):
            out[f"{link.joint}.{name}"] = cell(f"{joint}/@armature", "inertia at the joint; a ratio of 1 stands in")
        for name, attribute in (("mass", "mass"), ("com", "pos"), ("inertia", "fullinertia")):
            out[f"{link.link}.{name}"] = cell(f"{body}/inertial/@{attribute}")
    return out
