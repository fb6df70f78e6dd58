"""One model file in every engine: agreement, losses, and what restores them."""

import os
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lwr_dyn.arms.urdf.foreign_xml import parse_xml
from lwr_dyn.arms.urdf.reader import read_urdf
from lwr_dyn.checks.engines.agreement import Agreement, agreement
from lwr_dyn.checks.engines.candidates import DRAG, Way, candidates, restored_by
from lwr_dyn.checks.engines.child_process import SECONDS, Job, Loaded, load_all
from lwr_dyn.checks.engines.engine import ENGINES, is_installed, tolerance
from lwr_dyn.checks.engines.features import FEATURES, Tree, variants, without_meshes, without_shapes, xml_of
from lwr_dyn.checks.engines.losses import KEPT, MISREAD, SHAPES, Loss, feature_loss, merged_loss, shapes_loss
from lwr_dyn.checks.engines.reference import FileReference, reference_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.files import read_bytes, write_file


@dataclass(frozen=True, slots=True)
class Restored:
    """A loss and what restores it; empty where nothing that was tried does."""

    loss: Loss
    by: str


@dataclass(frozen=True, slots=True, eq=False)
class EngineReport:
    """What one engine makes of the file."""

    engine: str
    agreement: Agreement | None
    losses: tuple[Restored, ...]
    """All features that the file has, kept ones too."""
    note: str = ""
    """Why the engine is missing, or refuses the file as it stands."""


@dataclass(frozen=True, slots=True, eq=False)
class ModelReport:
    """What the engines make of a file."""

    file: str
    engines: tuple[EngineReport, ...]
    reference: FileReference
    unwritten: str = ""
    """What the arm has and no format holds."""


def survey(
    path: Path,
    tip: str | None = None,
    lock: Mapping[str, float] | None = None,
    engines: Sequence[str] = ENGINES.names,
    seconds: float = SECONDS,
) -> ModelReport:
    """Load the file, and copies of it without one feature each, in every engine that is installed.

    Raises
    ------
    FileAccessError, UrdfError, UnknownNameError
        As `read_urdf`.
    """
    reference = reference_of(path, tip, lock or {})
    root = parse_xml(read_bytes(path, "a readable .urdf file"), path.name)
    with tempfile.TemporaryDirectory() as folder:
        copies = _Copies(path, root, reference, Path(folder))
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            reports = tuple(pool.map(lambda engine: _in_engine(engine, copies, seconds), engines))
    return ModelReport(path.name, reports, reference)


class _Copies:
    """The file, the file without meshes, and one file without each feature."""

    def __init__(self, path: Path, root: Tree, reference: FileReference, folder: Path) -> None:
        self.path, self.root, self.reference, self.folder = path, root, reference, folder
        bare = without_meshes(root)
        stripped = sum(1 for _ in bare.iter()) != sum(1 for _ in root.iter())
        self.bare = self._write("bare", bare) if stripped else path
        self.without = {name: self._write(name, tree) for name, tree in variants(bare, reference.scope).items()}
        shapes = [x for tag in ("visual", "collision") for x in root.iter(tag)]
        self.shapeless = self._write(SHAPES, without_shapes(root)) if shapes else None
        self.links = [link.get("name", "") for link in root.findall("link")]
        self.ours = {name: self._torques(file) for name, file in self.without.items()}

    def _write(self, name: str, tree: Tree) -> Path:
        path = self.folder / f"{name.replace(' ', '_')}.urdf"
        write_file(path, xml_of(tree))
        return path

    def _torques(self, file: Path) -> tuple[Array, Array] | None:
        """Our torque of the file and of the copy without the feature."""
        if not self.reference.has_dynamics:
            return None
        try:
            arm = read_urdf(file, tip=self.reference.scope.tip, lock=self.reference.scope.held)
        except LwrDynError:
            return None
        if arm.chain.bodies is None:
            return None
        arm = replace(arm, chain=replace(arm.chain, gravity=self.reference.arm.chain.gravity))
        return self.reference.torque(), self.reference.torque(arm)


def _in_engine(engine: str, copies: _Copies, seconds: float) -> EngineReport:
    if not is_installed(engine):
        return EngineReport(engine, None, (), f"not installed: {ENGINES[engine].about}")
    reference = copies.reference
    ways = candidates(engine, copies.bare, reference, copies.folder / engine)
    files = [copies.path, copies.bare, *copies.without.values()]
    files += [copies.shapeless] if copies.shapeless is not None else []
    jobs = [Job(file, reference.scope) for file in files] + [way.job for way in ways]
    found = load_all(engine, jobs, reference.states, seconds)
    whole, bare = found[0], found[1]
    note = "" if isinstance(whole, Loaded) else whole
    if isinstance(whole, Loaded):
        bare = bare if isinstance(bare, Loaded) else whole
    if not isinstance(bare, Loaded):
        return EngineReport(engine, None, (), note)
    note = f"in a copy without meshes and mimic tags, since as it stands: {note}" if note else ""
    judged = whole if isinstance(whole, Loaded) else bare
    losses = _losses(engine, copies, bare, found[2 : 2 + len(copies.without)])
    if copies.shapeless is not None and isinstance(whole, Loaded):
        shapeless = found[2 + len(copies.without)]
        losses += [shapes_loss(engine, whole, shapeless, reference)] if isinstance(shapeless, Loaded) else []
    losses.append(merged_loss(engine, judged, dict.fromkeys(copies.links)))
    tried = list(zip(ways, found[len(files) :], strict=True))
    losses += _drag(engine, bare, tried) if reference.has_dynamics else []
    rows = [Restored(x, restored_by(x, tried, reference, copies.links) if x.is_loss else "") for x in losses]
    return EngineReport(engine, agreement(engine, copies.path.name, judged, reference), tuple(rows), note)


def _losses(engine: str, copies: _Copies, bare: Loaded, found: Sequence[Loaded | str]) -> list[Loss]:
    out = []
    for name, without in zip(copies.without, found, strict=True):
        if isinstance(without, Loaded):
            out.append(feature_loss(engine, name, (bare, without), copies.ours[name], copies.reference))
        elif any(x.name == name and not x.held for x in FEATURES):
            out.append(Loss(engine, name, KEPT, detail=f"refused without it: {without}"))
    return out


def _drag(engine: str, bare: Loaded, tried: Sequence[tuple[Way, Loaded | str]]) -> list[Loss]:
    """Torque of the engine's default damping, which no file asks for: it is gone with the option that turns it off."""
    for way, loaded in tried:
        if way.job.options.get("still") and isinstance(loaded, Loaded) and bare.has_dynamics:
            wrong, scale = float(np.abs(bare.torque - loaded.torque).max()), float(np.abs(loaded.torque).max())
            if wrong > tolerance(engine, "torque") * scale:
                return [Loss(engine, DRAG, MISREAD, wrong, wrong / scale, way.label)]
    return []
