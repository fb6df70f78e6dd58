"""An MJCF as an arm: MuJoCo compiles the file, and its tree of bodies is read as that of a URDF.

MuJoCo alone knows what an MJCF means: defaults and classes, five ways to write an orientation, inertias of shapes and
meshes, included files. So it reads ours too; a second reader for these would only be a second opinion on the same text.

    T_body(q) = T_0 M_1(q_1 - ref_1) M_2(q_2 - ref_2) ...        (the joints of a body act in their order)

A frame of the tree stands at the anchor of the joint that moves it, in axes of the body; `ref` is part of its origin,
so that q is MuJoCo's `qpos`. An armature, damping or friction of 0 is the format's default, and is read as not given.
What an arm has no place for is named in `notes`.
"""

import hashlib
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.export.mjcf import SPEEDS, UNKNOWN
from lwr_dyn.arms.urdf.parse import UrdfFile, finite_numbers, own_caveats, own_header
from lwr_dyn.arms.urdf.reader import arm_in
from lwr_dyn.arms.urdf.writer import CarriedXml
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import UrdfError, needs_extra
from lwr_dyn.foundation.files import read_bytes
from lwr_dyn.model.arm import Arm, Source
from lwr_dyn.model.chain import JointKind, Rotor, joint_motion
from lwr_dyn.model.spatial import SNAP, Pose, axis_to_z

READING = "mjcf"
"""The reading of an arm that comes from an MJCF."""
_TYPES = {0: "floating", 1: "ball", 2: "prismatic", 3: "revolute"}
"""mjtJoint -> a type of URDF joint; a ball has none, and ends a chain."""
_KINDS = {"prismatic": JointKind.PRISMATIC, "revolute": JointKind.REVOLUTE}
_ROOT = re.compile(rb"<!--.*?-->|<(?![?!])([^\s/>]*)", re.DOTALL)
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]")
_BODY, _JOINT = ("pos", "quat", "mass", "inertia", "ipos", "iquat"), ("pos", "axis", "range")
"""Fields of the compiled model whose numbers are checked."""
_REPLICAS = 1000
"""The most copies that one element may ask for."""
_COUNT = re.compile(rb'<(?:replicate|composite|flexcomp|array)\b[^>]*?\bcount\s*=\s*["\']([^"\']*)')
_TOOL = "tool"
"""The site of our own files at the tool centre point."""


def read_mjcf(path: str | Path, tip: str | None = None, lock: Mapping[str, float] | None = None) -> Arm:
    """The serial arm in an MJCF: bodies and joints keep the file's names, joints beside the chain are held.

    Parameters
    ----------
    path : path
    tip : str, optional
        The body or site that is the flange; if not given as for a URDF.
    lock : mapping of joint name to value, optional
        Joints fixed at a value [rad or m].

    Raises
    ------
    FileAccessError, MissingPackageError
        The file cannot be read; MuJoCo is not installed.
    UrdfError
        MuJoCo refuses the file; as `read_urdf` for its tree: several arms and no tip, a ball joint in the chain, a lock
        outside the joint's limits.
    UnknownNameError
        No body or site named `tip`, no moving joint of a locked name.

    >>> import lwr_dyn, tempfile
    >>> from lwr_dyn.arms.export.mjcf import mjcf_text
    >>> file = Path(tempfile.mkdtemp()) / "arm.xml"
    >>> _ = file.write_text(mjcf_text(lwr_dyn.load("lwr4plus")))
    >>> read_mjcf(file).armature[0].round(6)
    np.float64(0.160325)
    """
    file = _Mjcf(path)
    sites = () if tip is None and not file.header else (tip or _TOOL,)
    arm = arm_in(file.tree(sites), tip, lock)
    assert arm.layout is not None
    end = arm.chain.flange @ file.back_from_anchor(arm.layout.tip)
    notes = (*arm.notes, *file.left_out(arm.joint_names))
    return replace(
        arm, reading=READING, chain=replace(arm.chain, flange=end), limits=file.with_speeds(arm), layout=None,
        sources=_sources(file.name, arm), notes=notes,
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Inertial:
    """As yourdfpy's."""

    mass: float
    inertia: Array
    origin: Array


@dataclass(frozen=True, slots=True)
class _Link:
    """As yourdfpy's."""

    name: str
    inertial: _Inertial | None = None


@dataclass(frozen=True, slots=True)
class _Limit:
    """As yourdfpy's."""

    lower: float | None
    upper: float | None
    effort: float | None
    velocity: float | None = None


@dataclass(frozen=True, slots=True)
class _Losses:
    """As yourdfpy's."""

    damping: float | None
    friction: float | None


@dataclass(frozen=True, slots=True)
class _Joint:
    """As yourdfpy's."""

    name: str
    type: str
    parent: str
    child: str
    origin: Array
    axis: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    limit: _Limit | None = None
    dynamics: _Losses | None = None
    mimic: None = None


class _Mjcf:
    """The compiled file; its methods raise `UrdfError`."""

    def __init__(self, path: str | Path) -> None:
        content, self.name = read_bytes(path, "a readable .xml file"), Path(path).name
        self.header = own_header(content.decode("utf-8", errors="replace"))
        root = next((found[1] for found in _ROOT.finditer(content) if found[1] is not None), b"")
        if root == b"robot":
            raise self.fault("<robot>", "a URDF", "a name that ends in .urdf, or an MJCF")
        copies = [n for found in _COUNT.findall(content) for n in finite_numbers(found.decode(errors="replace")) or ()]
        if max(copies, default=0.0) > _REPLICAS:
            raise self.fault("count", f"{max(copies):g} copies", f"at most {_REPLICAS} an element")
        with needs_extra("parity"):
            import mujoco
        try:
            self.model: Any = mujoco.MjModel.from_xml_path(str(path))
        except (ValueError, mujoco.FatalError) as fault:
            words = "; ".join(line.strip() for line in str(fault).splitlines() if line.strip())
            raise self.fault("MuJoCo refuses it", words, "an MJCF that MuJoCo compiles") from None
        self.digest = hashlib.sha256(content + b"".join(_beside(mujoco, Path(path)))).hexdigest()
        self.bodies, self.joints = self._names("body", self.model.nbody), self._names("joint", self.model.njnt)
        self._check()

    def _check(self) -> None:
        """Refuse numbers that MuJoCo takes, or passes over, without a word."""
        numbers = {
            f"{what} {name!r}": x for what, names, x in self._numbers() for name, x in zip(names, x, strict=True)
        }
        wrong = next((where for where, x in numbers.items() if not np.isfinite(x).all()), None)
        if wrong is not None:
            raise self.fault(wrong, "a number that is not finite", "finite numbers")
        for j, name in enumerate(self.joints):
            low, up = self.model.jnt_range[j]
            if low > up:
                raise self.fault(f"joint {name!r} range", f"{low:g} {up:g}", "the lower limit first")
            for what in ("armature", "damping", "frictionloss"):
                value = float(np.ravel(getattr(self.model, f"dof_{what}")[self.model.jnt_dofadr[j]])[0])
                if not 0.0 <= value < np.inf:
                    raise self.fault(f"joint {name!r} {what}", repr(value), "a number of at least 0")

    def _numbers(self) -> Iterator[tuple[str, list[str], Any]]:
        """Field in words, names, a row of numbers a name."""
        for prefix, names, fields in (("body", self.bodies, _BODY), ("jnt", self.joints, _JOINT)):
            for key in fields:
                yield f"{key} of", names, getattr(self.model, f"{prefix}_{key}")

    def fault(self, where: str, found: str, allowed: str) -> UrdfError:
        return UrdfError(self.name, where, found, allowed)

    def _names(self, what: str, count: int) -> list[str]:
        """The names of bodies or joints, which a file need not give: others get one that is free."""
        names = [str(getattr(self.model, what)(k).name) for k in range(count)]
        for k, name in enumerate(names):
            if _CONTROL.search(name):
                raise self.fault(f"{what} {k}", f"the name {name!r}", "letters that can be printed in a line")
            free = f"{what}_{k}"
            while not name and free in names:
                free += "_"
            names[k] = name or free
        return names

    def tree(self, sites: tuple[str, ...]) -> UrdfFile:
        """The bodies, and sites of these names, as links of a URDF."""
        links = {name: _Link(name, self._inertial(b)) for b, name in enumerate(self.bodies)}
        joints = [joint for b in range(1, self.model.nbody) for joint in self._into(b)]
        links |= {joint.child: _Link(joint.child) for joint in joints if joint.child not in links}
        for k in (k for k in range(self.model.nsite) if self.model.site(k).name in sites):
            name, b = str(self.model.site(k).name), int(self.model.site_bodyid[k])
            if name not in links:
                at = self.back_from_anchor(self.bodies[b]) @ _pose(self.model.site_pos[k], self.model.site_quat[k])
                joints.append(_Joint(f"{name}_site", "fixed", self.bodies[b], name, at.matrix()))
                links[name] = _Link(name)
        names = [joint.name for joint in joints]
        twice = next((x for x in names if names.count(x) > 1), None)
        if twice is not None:
            raise self.fault(f"joint {twice}", "used twice", "a name of its own")
        model = str(self.model.names.split(b"\0")[0].decode("utf-8", errors="replace"))
        off = int(self.model.opt.disableflags) & _disabled("GRAVITY")
        return UrdfFile(
            file=self.name, name=model if model and not _CONTROL.search(model) else "robot", digest=self.digest,
            links=links, joints={joint.name: joint for joint in joints}, rotors=self._rotors(),
            placeholders=frozenset(), gravity=(0.0,) * 3 if off else tuple(map(float, self.model.opt.gravity)),
            caveats=own_caveats(self.header), leftovers=(),
            carried=CarriedXml(dict.fromkeys(links, ()), {}, {}, ()),
        )  # fmt: skip

    def back_from_anchor(self, link: str) -> Pose:
        """The body's own frame in its frame of the tree; the identity for a site."""
        anchor = self._anchor(self.bodies.index(link)) if link in self.bodies else np.zeros(3)
        return Pose(np.eye(3), -anchor)

    def _of(self, b: int) -> range:
        first = int(self.model.body_jntadr[b])
        return range(first, first + int(self.model.body_jntnum[b]))

    def _anchor(self, b: int) -> Array:
        """Of the last joint of a body, in the body (3,) [m]."""
        moving = [j for j in self._of(b) if _TYPES[int(self.model.jnt_type[j])] in _KINDS]
        return np.array(self.model.jnt_pos[moving[-1]]) if moving else np.zeros(3)

    def _inertial(self, b: int) -> _Inertial | None:
        m, mass = self.model, float(self.model.body_mass[b])
        if mass == 0.0 and not m.body_inertia[b].any():
            return None
        return _Inertial(mass, np.diag(m.body_inertia[b]), self._at_anchor(b, _pose(m.body_ipos[b], m.body_iquat[b])))

    def _at_anchor(self, b: int, pose: Pose) -> Array:
        return (self.back_from_anchor(self.bodies[b]) @ pose).matrix()

    def _into(self, b: int) -> Iterator[_Joint]:
        """The joints of a body as a chain from its parent; a fixed one where it has none."""
        m, own = self.model, list(self._of(b))
        parent, link = self.bodies[int(m.body_parentid[b])], self.bodies[b]
        at = self.back_from_anchor(parent) @ _pose(m.body_pos[b], m.body_quat[b])
        if not own:
            yield _Joint(f"{link}_fixed", "fixed", parent, link, at.matrix())
        before = np.zeros(3)
        for j in own:
            kind, child = _TYPES[int(m.jnt_type[j])], link if j == own[-1] else f"{link}_before_{self.joints[j + 1]}"
            anchor = np.array(m.jnt_pos[j]) if kind in _KINDS else before
            at = at @ Pose(np.eye(3), anchor - before)
            yield replace(self._joint(j, kind, at), parent=parent, child=child)
            parent, before, at = child, anchor, Pose.identity()

    def _joint(self, j: int, kind: str, at: Pose) -> _Joint:
        m, name = self.model, self.joints[j]
        if kind not in _KINDS:
            return _Joint(name, kind, "", "", at.matrix())
        dof, axis = int(m.jnt_dofadr[j]), np.array(m.jnt_axis[j])
        turn, zero = Pose(axis_to_z(axis), np.zeros(3)), float(m.qpos0[m.jnt_qposadr[j]])
        start = at @ turn @ joint_motion(_KINDS[kind], -zero) @ turn.inverse() if zero else at
        lower, upper = map(float, m.jnt_range[j]) if m.jnt_limited[j] else (None, None)
        damping = float(np.ravel(m.dof_damping[dof])[0]) + self._of_motors(j, "actuator_damping")
        losses = _Losses(damping or None, float(m.dof_frictionloss[dof]) or None)
        return _Joint(name, kind, "", "", start.matrix(), axis, _Limit(lower, upper, self._effort(j)), losses)

    def _motors(self, j: int) -> list[int]:
        """The actuators that push a joint alone."""
        m = self.model
        return [a for a in range(m.nu) if int(m.actuator_trntype[a]) in (0, 1) and int(m.actuator_trnid[a, 0]) == j]

    def _of_motors(self, j: int, what: str) -> float:
        """Armature or damping of a joint's actuators, seen at the joint: times the square of the gear."""
        values = getattr(self.model, what, None)  # MuJoCo 4
        gears = {a: float(self.model.actuator_gear[a, 0]) for a in self._motors(j)}
        return 0.0 if values is None else sum(gear**2 * float(np.ravel(values[a])[0]) for a, gear in gears.items())

    def _rotors(self) -> dict[str, Rotor]:
        m, out = self.model, dict[str, Rotor]()
        for j, name in enumerate(self.joints):
            armature = float(m.dof_armature[m.jnt_dofadr[j]]) + self._of_motors(j, "actuator_armature")
            if armature and _TYPES[int(m.jnt_type[j])] in _KINDS:
                out[name] = Rotor(1.0, armature, reflected=True)
        return out

    def _effort(self, j: int) -> float | None:
        """The sum of its actuators' largest torques, and not above the joint's own limit; None where neither is given.

        A servo has a limit by `forcerange` alone: its control is a position or a speed.
        """
        m, total = self.model, 0.0
        for a in self._motors(j):
            gear = abs(float(m.actuator_gear[a, 0]))
            if m.actuator_forcelimited[a]:
                total += gear * float(np.abs(m.actuator_forcerange[a]).max())
            elif m.actuator_ctrllimited[a] and not m.actuator_biasprm[a].any() and int(m.actuator_gaintype[a]) == 0:
                total += gear * abs(float(m.actuator_gainprm[a, 0])) * float(np.abs(m.actuator_ctrlrange[a]).max())
            else:
                total = np.inf
        limits = [total] if total else []
        if getattr(m, "jnt_actfrclimited", np.zeros(m.njnt))[j]:
            limits.append(float(np.abs(m.jnt_actfrcrange[j]).max()))
        least = min(limits, default=np.inf)
        return least if np.isfinite(least) else None

    def with_speeds(self, arm: Arm) -> tuple[Any, ...]:
        """The limits with the speed limits of our own header."""
        line = next((x.removeprefix(SPEEDS) for x in self.header if x.startswith(SPEEDS)), None)
        if line is None or arm.n != len(line.split()):
            return arm.limits
        known = finite_numbers(line.replace(UNKNOWN, "0"))
        if known is None or min(known) < 0.0:
            raise self.fault("header", f"{SPEEDS}{line}", f"{arm.n} numbers of at least 0, or {UNKNOWN}")
        rows = zip(arm.limits, line.split(), known, strict=True)
        return tuple(row if word == UNKNOWN else replace(row, velocity=x) for row, word, x in rows)

    def left_out(self, joints: tuple[str, ...]) -> Iterator[str]:
        """What the file has and the arm has not, a line each that names it."""
        m, ids = self.model, [self.joints.index(name) for name in joints]
        dofs = [int(m.jnt_dofadr[j]) for j in ids]
        for what, there in (
            ("springs of joints", _some(m, "jnt_stiffness", ids) or _some(m, "jnt_stiffnesspoly", ids)),
            ("damping that grows with speed", _some(m, "dof_dampingpoly", dofs)),
            ("equality constraints", m.neq),
            ("tendons", m.ntendon),
            ("gravity compensation of bodies", m.body_gravcomp.any()),
            ("fluid forces", m.opt.density or m.opt.viscosity),
            ("flexible bodies", m.nflex),
            ("feedback of servos", any(m.actuator_biasprm[a].any() for j in ids for a in self._motors(j))),
        ):
            if there:
                yield f"{self.name}: {what} of the MJCF left out"


def _disabled(what: str) -> int:
    import mujoco

    return int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{what}"))


def _some(model: Any, name: str, ids: list[int]) -> bool:
    values = getattr(model, name, None)
    return values is not None and bool(np.any(values[ids]))


def _beside(mujoco: Any, path: Path) -> Iterator[bytes]:
    """The files that an MJCF includes or whose meshes it weighs."""
    listed = getattr(mujoco, "mju_getXMLDependencies", lambda _: ())(str(path))
    for name in sorted(map(str, listed)):
        if Path(name).resolve() != path.resolve():
            with suppress(OSError):
                yield (path.parent / name).read_bytes()


def _pose(position: Any, quaternion: Any) -> Pose:
    """Of MuJoCo's w x y z; entries within rounding of 0 and +-1 are these."""
    w, x, y, z = map(float, quaternion)
    rotation = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    whole = np.round(rotation)
    return Pose(np.where(np.abs(rotation - whole) <= SNAP, whole, rotation), np.array(position))


_CELLS = {
    "before": "", "after": "/@axis", "lower": "/@range", "upper": "/@range", "effort": "/@actuatorfrcrange",
    "viscous": "/@damping", "coulomb": "/@frictionloss", "gear_ratio": "/@armature", "rotor_inertia": "/@armature",
}  # fmt: skip
"""Part of a joint -> its place in the element; an effort also comes from the motors."""


def _sources(file: str, arm: Arm) -> dict[str, tuple[Source, ...]]:
    """The element of the file for each number of the arm."""
    out = dict[str, tuple[Source, ...]]()
    for quantity in arm.sources:
        name, _, part = quantity.rpartition(".")
        body = f"body[@name='{name or arm.chain.links[-1].link}']"
        cell = f"joint[@name='{name}']{_CELLS[part]}" if part in _CELLS else body
        if part == "velocity":
            cell = "comment()"
        out[quantity] = (Source(f"//{cell}", file, "MJCF", "as in the file", "SI", "as MuJoCo compiles it"),)
    return out
