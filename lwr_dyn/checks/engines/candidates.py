"""Files and options that may restore what an engine loses of a URDF, and whether they do, by loading them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lwr_dyn.arms.urdf.foreign_xml import parse_xml
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.checks.engines.child_process import Job, Loaded
from lwr_dyn.checks.engines.engine import tolerance
from lwr_dyn.checks.engines.features import FEATURES, without_meshes, xml_of
from lwr_dyn.checks.engines.losses import BEHIND_FIXED, CONTINUOUS, Loss, wrong_record
from lwr_dyn.checks.engines.reference import FileReference
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.files import make_folder, write_file

WRITTEN, XML = "the .urdf that lwr-dyn urdf writes", ".xml (MJCF)"
DRAG = "drag of its own"
"""A torque that no file asks for."""
OPTIONS = {
    "mujoco": (('compiler option fusestatic="false"', {"whole": True}),),
    "pybullet": (("changeDynamics(linearDamping=0, angularDamping=0)", {"still": True}),),
}
"""Engine -> options that may restore something, as a user sets them and as its loader takes them."""
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
    """The first candidate that has what is lost; empty where none has."""
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
    return rest <= tolerance(loss.engine, "torque") * float(np.abs(reference.torque()).max())


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
        return {}, float(np.abs(left).max())
    columns = np.array([part.ravel() for part in parts.values()]).T
    shares = np.linalg.lstsq(columns, left, rcond=None)[0]
    return dict(zip(parts, map(float, shares), strict=True)), float(np.abs(left - columns @ shares).max())
