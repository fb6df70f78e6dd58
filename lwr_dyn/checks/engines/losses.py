"""What an engine loses of a file: each feature is taken out of the file, and the engine's result must change as ours.

    loss = max |(tau(file) - tau(file without it)) of the engine - the same of ours|

Ours is the recursion on the arm that the file describes, over the states it is tried at; mass, B, C dq, g, torque and
flange of a loaded file are compared with it too. Where no torque depends on a feature (limits), the engine's own record
of it decides. Files and options that may restore what is lost are loaded as well.
"""

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.arms.urdf.parse import parse_urdf, parse_xml
from lwr_dyn.arms.urdf.reader import read_urdf
from lwr_dyn.arms.urdf.tree import KINDS, build_tree, with_held_joints
from lwr_dyn.arms.urdf.xacro_files import expand_xacro
from lwr_dyn.checks.arm.model_laws import random_states
from lwr_dyn.checks.engines.child_process import Job, Loaded, TriedStates
from lwr_dyn.checks.engines.engine import FEATURES, ArmInFile, tolerance, without_meshes, xml_of
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.files import ends_in, make_folder, write_file
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm

STATES, SEED = 20, 7


@dataclass(frozen=True, slots=True, eq=False)
class FileReference:
    """An arm as its file says; without masses every torque is empty."""

    arm: Arm
    scope: ArmInFile
    states: TriedStates

    @property
    def has_dynamics(self) -> bool:
        """Whether every moving link has a body."""
        return self.arm.chain.bodies is not None

    def torque(self, arm: Arm | None = None) -> Array:
        """B ddq + C dq + g with armature, and the friction of the joints, (k, n), of this arm or of a changed file."""
        arm, x = self.arm if arm is None else arm, self.states
        tau = newton_euler_dynamics(arm.chain).inverse_dynamics(x.q, x.dq, x.ddq)
        return np.asarray(tau + self.friction(arm))

    def friction(self, arm: Arm) -> Array:
        """Friction torque (k, n), 0 where it is not known."""
        rows = [
            np.zeros(len(self.states.dq)) if model is None else model.torque(self.states.dq[:, k])
            for k, model in enumerate(arm.friction_models())
        ]
        return np.array(rows).T

    def flange(self) -> Array:
        """Poses (k, 4, 4)."""
        return flange_pose(self.arm.chain, self.states.q)

    def held(self) -> dict[str, Array]:
        """The numbers beside the dynamics, infinite where a limit is not known."""
        arm = self.arm
        pairs = {name: [getattr(x, name) or 0.0 for x in arm.limits] for name in ("viscous", "coulomb")}
        limits = {"lower": arm.lower, "upper": arm.upper, "velocity": arm.velocity, "effort": arm.effort}
        return limits | {name: np.array(values) for name, values in pairs.items()}


@contextmanager
def as_urdf(path: Path, loaded_with: Mapping[str, Any]) -> Iterator[Path]:
    """The file itself, or what a `.xacro` expands to, as a file for a while; raises as `expand_xacro`.

    `loaded_with` are the options of `lwr_dyn.load`, xacro's among them.
    """
    if not ends_in(path, ".xacro"):
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        expanded = Path(folder) / f"{path.name.partition('.')[0]}.urdf"
        trust = loaded_with.get("trust_xacro", False)
        write_file(expanded, expand_xacro(path, loaded_with.get("xacro_args", {}), trust=trust))
        yield expanded


def reference_of(path: Path, tip: str | None, lock: Mapping[str, float], count: int = STATES) -> FileReference:
    """The arm in a file at random states; raises as `read_urdf`."""
    arm = read_urdf(path, tip=tip, lock=lock)
    urdf, end = parse_urdf(path), arm.layout.tip if arm.layout is not None else tip or ""
    locked = with_held_joints(build_tree(urdf, lock), end)[0].locked
    held = {name: value for name, value in locked.items() if urdf.joints[name].type in KINDS}
    scope = ArmInFile(arm.joint_names, end, tuple(float(x) for x in arm.chain.gravity), held)
    x = random_states(arm, count, SEED)
    return FileReference(arm, scope, TriedStates(x.q, x.dq, x.ddq))


@dataclass(frozen=True, slots=True, eq=False)
class Agreement:
    """Largest differences of an engine from ours: absolute [kg m^2, N m, m], and relative to our largest value."""

    engine: str
    mass: float | None
    """What the engine weighs the links that it moves [kg], with those that it fixes to the ground."""
    absolute: dict[str, float]
    relative: dict[str, float]

    def beyond(self) -> list[str]:
        """The quantities above the engine's tolerance."""
        allowed = {"B": "inertia", "C dq": "inertia", "torque": "torque"}
        out = [x for x, value in self.relative.items() if not value <= tolerance(self.engine, allowed.get(x, "g"))]
        return out + [x for x in ("flange",) if not self.absolute[x] <= tolerance(self.engine, "pose")]


def agreement(engine: str, loaded: Loaded, reference: FileReference, rotors: bool = True) -> Agreement:
    """The differences; without `rotors`, the file's rotor inertia is not expected."""
    absolute = {"flange": _largest(loaded.flange - reference.flange())}
    relative: dict[str, float] = {}
    if loaded.has_dynamics and reference.has_dynamics:
        for name, (theirs, ours) in _pairs(loaded, reference, rotors).items():
            absolute[name] = _largest(theirs - ours)
            scale = _largest(ours)
            relative[name] = absolute[name] / scale if scale > 0.0 else absolute[name]
    return Agreement(engine, loaded.mass, absolute, relative)


def _pairs(loaded: Loaded, reference: FileReference, rotors: bool) -> dict[str, tuple[Array, Array]]:
    x, arm = reference.states, reference.arm
    ours = newton_euler_dynamics(arm.chain, rotors="armature" if rotors else "none")
    gravity = ours.gravity_vector(x.q)
    return {
        "B": (loaded.mass_matrix, ours.mass_matrix(x.q)),
        "C dq": (loaded.velocity_torque, ours.bias_torque(x.q, x.dq) - gravity),
        "g": (loaded.gravity_torque, gravity),
        "torque": (loaded.torque, ours.inverse_dynamics(x.q, x.dq, x.ddq) + reference.friction(arm)),
    }


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))


KEPT, RECORDED, IGNORED, ASIDE, MISREAD, MERGED = (
    "kept", "recorded", "ignored", "recorded, not in its torque", "misread", "merged"
)  # fmt: skip

NO_DYNAMICS = "no dynamics"
"""Verdicts."""
SHAPES, BEHIND_FIXED, ZEROS, CONTINUOUS = "shapes", "links behind fixed joints", "zero inertials", "continuous joints"
MOMENTS = "moments without mass"


@dataclass(frozen=True, slots=True)
class Loss:
    """What an engine makes of one feature of a file; the torque that is then wrong [N m or N], and its share."""

    engine: str
    feature: str
    verdict: str
    torque: float | None = None
    relative: float | None = None
    detail: str = ""
    restored_by: str = ""
    """What restores it; empty where nothing that was tried does."""

    @property
    def is_loss(self) -> bool:
        """Whether something is not as the file says."""
        return self.verdict not in (KEPT, RECORDED, NO_DYNAMICS)


def feature_loss(
    engine: str, feature: str, loaded: tuple[Loaded, Loaded], ours: tuple[Array, Array] | None, reference: FileReference
) -> Loss:
    """One feature: the engine's and our results with it and without it."""
    held = next(x.held for x in FEATURES if x.name == feature)
    whole, without = loaded
    by_record = _by_record(engine, feature, held, whole, reference)
    if ours is None or not whole.has_dynamics:
        return by_record if held else Loss(engine, feature, NO_DYNAMICS)
    theirs = whole.torque - without.torque
    expected = ours[0] - ours[1]
    scale, wrong = _largest(ours[0]), _largest(theirs - expected)
    allowed = tolerance(engine, "torque") * scale
    if wrong <= allowed:
        only_recorded = held and _largest(expected) == 0.0
        return by_record if only_recorded else Loss(engine, feature, KEPT)
    if feature == ZEROS:  # it is their absence that is misread, and the file has them
        return Loss(engine, feature, KEPT, detail=f"without them {wrong:.2g} N m: {_weight(without, whole, 'without')}")
    silent = _largest(theirs) <= allowed
    verdict = (ASIDE if by_record.verdict == RECORDED else IGNORED) if silent else MISREAD
    return Loss(engine, feature, verdict, wrong, wrong / scale, _weight(whole, without))


def _by_record(engine: str, feature: str, held: tuple[str, ...], whole: Loaded, reference: FileReference) -> Loss:
    """The verdict where only the engine's own numbers can show a feature."""
    recorded = [x for x in held if x in whole.held]
    wrong = [words for x in recorded if (words := wrong_record(whole, reference, x, feature == CONTINUOUS))]
    if not recorded or (all(np.isinf(whole.held[x]).all() for x in recorded) and feature != CONTINUOUS):
        return Loss(engine, feature, IGNORED)
    return Loss(engine, feature, MISREAD, detail=wrong[0]) if wrong else Loss(engine, feature, RECORDED)


def wrong_record(loaded: Loaded, reference: FileReference, name: str, endless: bool = False) -> str:
    """The first joint of which an engine's number is not the file's; empty if there is none.

    With `endless`, only of joints without such a limit: an engine may have 0 or a very large number there.
    """
    ours, theirs = reference.held()[name], loaded.held[name]
    if endless:
        bad = np.isinf(ours) & (theirs != 0.0) & (np.abs(theirs) < _NO_LIMIT)
    else:
        bad = np.isfinite(ours) & ~np.isclose(theirs, ours, rtol=1e-6, atol=1e-12)
    found = np.flatnonzero(bad)
    if not found.size:
        return ""
    k = int(found[0])
    more = f" and {found.size - 1} more" if found.size > 1 else ""
    return f"{name} of {reference.arm.joint_names[k]}: {theirs[k]:g} for {ours[k]:g}{more}"


_NO_LIMIT = 1e6
"""Above this a limit is none."""


def _weight(one: Loaded, other: Loaded, words: str = "with it") -> str:
    more = one.mass - other.mass
    return f"{more:+.6g} kg {words}" if abs(more) > 1e-9 * max(one.mass, 1.0) else ""


def shapes_loss(engine: str, whole: Loaded, bare: Loaded, reference: FileReference) -> Loss:
    """The file as it stands against the file without shapes: no torque should depend on them."""
    if not (whole.has_dynamics and reference.has_dynamics):
        return Loss(engine, SHAPES, NO_DYNAMICS)
    wrong, scale = _largest(whole.torque - bare.torque), _largest(reference.torque())
    if wrong <= tolerance(engine, "torque") * scale:
        return Loss(engine, SHAPES, KEPT)
    return Loss(engine, SHAPES, MISREAD, wrong, wrong / scale, f"shapes weigh {whole.mass - bare.mass:.6g} kg")


def merged_loss(engine: str, loaded: Loaded, links: Sequence[str]) -> Loss:
    """Links of the file that the engine no longer knows by name."""
    gone = [name for name in dict.fromkeys(links) if name not in loaded.links]
    if not gone:
        return Loss(engine, BEHIND_FIXED, KEPT)
    some = ", ".join(gone[:3]) + (f" and {len(gone) - 3} more" if len(gone) > 3 else "")
    return Loss(engine, BEHIND_FIXED, MERGED, 0.0, 0.0, f"{some}: no longer there by name")


WRITTEN, XML = "the .urdf that lwr-dyn urdf writes", ".xml (MJCF)"
DRAG = "drag of its own"
"""A torque that no file asks for."""

OPTIONS = {
    "mujoco": (('compiler option fusestatic="false"', {"whole": True}),),
    "pybullet": (("changeDynamics(linearDamping=0, angularDamping=0)", {"still": True}),),
}
"""Engine -> options that may restore something, as a user sets them and as its loader takes them."""

_STAND_IN = 1e-9
"""Share of the torque that may come from what stands for a link without mass in our MJCF (`mjcf.TINY`)."""
_COEFFICIENT = 1e-3
"""How far from 1 the share of a feature's torque may be that a model has."""


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """A way to load the model that may restore something."""

    label: str
    job: Job


def candidates(engine: str, path: Path, reference: FileReference, folder: Path) -> list[Way]:
    """What there is for an engine: its options, our sidecars, our own URDF of a foreign file (without meshes)."""
    out = [Way(label, Job(path, reference.scope, options)) for label, options in OPTIONS.get(engine, ())]
    files = _written(reference, make_folder(folder))
    held, plain = replace(reference.scope, held={}), {"still": True} if engine == "pybullet" else {}
    if engine == "pinocchio" and ".srdf" in files:
        out.append(Way(".srdf by loadRotorParameters", Job(path, reference.scope, {"rotors": str(files[".srdf"])})))
    if ".urdf" in files and engine != "yourdfpy":
        out.append(Way(WRITTEN, Job(files[".urdf"], held, plain)))
    if engine in ("mujoco", "drake") and ".xml" in files:
        out.append(Way(XML, Job(files[".xml"], replace(held, tip="flange"))))
    return out


def _written(reference: FileReference, folder: Path) -> dict[str, Path]:
    """Our files of the arm by ending."""
    out = {}
    try:
        texts = model_files(reference.arm, "written")
    except LwrDynError:
        return {}
    for name, text in texts.items():
        path = folder / name
        if path.suffix == ".urdf":
            text = xml_of(without_meshes(parse_xml(text.encode(), name)))
        write_file(path, text)
        out[path.suffix] = path
    return out


def restored_by(
    loss: Loss, found: Sequence[tuple[Way, Loaded | str]], reference: FileReference, links: Sequence[str]
) -> str:
    """The first candidate that has what is lost; empty where none has, and where nothing is lost."""
    if not loss.is_loss:
        return ""
    if loss.feature == DRAG:
        return loss.detail
    for candidate, loaded in found:
        if isinstance(loaded, Loaded) and _has(loss, loaded, reference, links):
            return candidate.label
    return ""


def _has(loss: Loss, loaded: Loaded, reference: FileReference, links: Sequence[str]) -> bool:
    if loss.feature == BEHIND_FIXED:
        return set(links) <= set(loaded.links)
    wanted = next((x.held for x in FEATURES if x.name == loss.feature), ())
    if loss.torque is None and wanted:
        endless = loss.feature == CONTINUOUS
        return all(x in loaded.held and not wrong_record(loaded, reference, x, endless) for x in wanted)
    if not (loaded.has_dynamics and reference.has_dynamics):
        return False
    shares, rest = shares_of(loaded.torque, reference)
    if loss.feature in shares:
        return abs(shares[loss.feature] - 1.0) <= _COEFFICIENT
    near = _STAND_IN if loss.feature == MOMENTS else tolerance(loss.engine, "torque")
    return rest <= near * _largest(reference.torque())


def shares_of(torque: Array, reference: FileReference) -> tuple[dict[str, float], float]:
    """The share of rotor and friction torque in a torque (least squares), and the largest rest [N m]."""
    x, arm = reference.states, reference.arm
    rigid = newton_euler_dynamics(arm.chain, rotors="none").inverse_dynamics(x.q, x.dq, x.ddq)
    held = reference.held()
    parts = {
        "rotor inertia": arm.armature * x.ddq,
        "viscous friction": held["viscous"] * x.dq,
        "Coulomb friction": held["coulomb"] * np.sign(x.dq),
    }
    parts = {name: part for name, part in parts.items() if part.any()}
    left = (torque - rigid).ravel()
    if not parts:
        return {}, _largest(left)
    columns = np.array([part.ravel() for part in parts.values()]).T
    shares = np.linalg.lstsq(columns, left, rcond=None)[0]
    return dict(zip(parts, map(float, shares), strict=True)), _largest(left - columns @ shares)
