"""One model file in every engine, as tables: how far each is from ours, what it loses, and what restores it."""

import os
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, NotRequired, TypedDict

import numpy as np

from lwr_dyn.arms.urdf.parse import parse_xml
from lwr_dyn.arms.urdf.reader import read_urdf
from lwr_dyn.checks.engines import engine as features
from lwr_dyn.checks.engines import losses
from lwr_dyn.checks.engines.child_process import SECONDS, Job, Loaded, load_all
from lwr_dyn.checks.engines.engine import ENGINES, Tree, is_installed, tolerance
from lwr_dyn.checks.engines.losses import Agreement, FileReference, Loss, Way
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.files import read_bytes, write_file
from lwr_dyn.foundation.tables import Heading, Table


@dataclass(frozen=True, slots=True, eq=False)
class EngineReport:
    """What one engine makes of the file."""

    engine: str
    agreement: Agreement | None
    losses: tuple[Loss, ...]
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
    """Load the file, and copies without one feature each, in every engine that is installed; raises as `read_urdf`."""
    reference = losses.reference_of(path, tip, lock or {})
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
        bare = features.without_meshes(root)
        stripped = sum(1 for _ in bare.iter()) != sum(1 for _ in root.iter())
        self.bare = self._write("bare", bare) if stripped else path
        variants = features.variants(bare, reference.scope)
        self.without = {name: self._write(name, tree) for name, tree in variants.items()}
        shapes = [x for tag in ("visual", "collision") for x in root.iter(tag)]
        self.shapeless = self._write(losses.SHAPES, features.without_shapes(root)) if shapes else None
        self.links = [link.get("name", "") for link in root.findall("link")]
        self.ours = {name: self._torques(file) for name, file in self.without.items()}

    def _write(self, name: str, tree: Tree) -> Path:
        path = self.folder / f"{name.replace(' ', '_')}.urdf"
        write_file(path, features.xml_of(tree))
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
    ways = losses.candidates(engine, copies.bare, reference, copies.folder / engine)
    files = [copies.path, copies.bare, *copies.without.values()]
    files += [copies.shapeless] if copies.shapeless is not None else []
    jobs = [Job(file, reference.scope) for file in files] + [way.job for way in ways]
    found = load_all(engine, jobs, reference.states, seconds)
    whole, bare = found[0], found[1] if isinstance(found[1], Loaded) else found[0]
    if not isinstance(bare, Loaded):
        return EngineReport(engine, None, (), str(whole))
    note = "" if isinstance(whole, Loaded) else f"in a copy without meshes and mimic tags, since as it stands: {whole}"
    judged = whole if isinstance(whole, Loaded) else bare
    lost = _losses(engine, copies, bare, found[2 : 2 + len(copies.without)])
    if copies.shapeless is not None and isinstance(whole, Loaded):
        shapeless = found[2 + len(copies.without)]
        lost += [losses.shapes_loss(engine, whole, shapeless, reference)] if isinstance(shapeless, Loaded) else []
    lost.append(losses.merged_loss(engine, judged, copies.links))
    tried = list(zip(ways, found[len(files) :], strict=True))
    lost += _drag(engine, bare, tried) if reference.has_dynamics else []
    rows = tuple(replace(x, restored_by=losses.restored_by(x, tried, reference, copies.links)) for x in lost)
    return EngineReport(engine, losses.agreement(engine, judged, reference), rows, note)


def _losses(engine: str, copies: _Copies, bare: Loaded, found: Sequence[Loaded | str]) -> list[Loss]:
    out = []
    for name, without in zip(copies.without, found, strict=True):
        if isinstance(without, Loaded):
            out.append(losses.feature_loss(engine, name, (bare, without), copies.ours[name], copies.reference))
        elif any(x.name == name and not x.held for x in features.FEATURES):
            out.append(Loss(engine, name, losses.KEPT, detail=f"refused without it: {without}"))
    return out


def _drag(engine: str, bare: Loaded, tried: Sequence[tuple[Way, Loaded | str]]) -> list[Loss]:
    """Torque of the engine's default damping, which no file asks for: it is gone with the option that turns it off."""
    for way, loaded in tried:
        if way.job.options.get("still") and isinstance(loaded, Loaded) and bare.has_dynamics:
            wrong, scale = float(np.abs(bare.torque - loaded.torque).max()), float(np.abs(loaded.torque).max())
            if wrong > tolerance(engine, "torque") * scale:
                return [Loss(engine, losses.DRAG, losses.MISREAD, wrong, wrong / scale, way.label)]
    return []


def agreement_table(report: ModelReport) -> Table:
    """Largest differences from our own dynamics of the file."""
    heads = [Heading("engine"), Heading("mass", "kg", ".6g")]
    heads += [Heading(x, "relative", ".1e") for x in ("B", "C dq", "g", "torque")]
    heads += [Heading("torque", "N m", ".2g", key="torque_nm"), Heading("flange", "m", ".1e")]
    rows = []
    for engine in report.engines:
        found = engine.agreement
        if found is not None:
            relative = [found.relative.get(x) for x in ("B", "C dq", "g", "torque")]
            rows.append((engine.engine, found.mass, *relative, found.absolute.get("torque"), found.absolute["flange"]))
    title = f"{report.file}: largest difference from ours over {losses.STATES} random states, as each engine loads it"
    note = "torque: B ddq + C dq + g with rotors and friction, as the engine's own motion needs it"
    return Table(title, heads, rows, note)


def loss_table(report: ModelReport) -> Table:
    """What is not as the file says, with the torque that is then wrong and what restores it."""
    rows = []
    for engine in report.engines:
        for loss in (x for x in engine.losses if x.is_loss):
            cells = (engine.engine, loss.feature, loss.verdict, loss.torque, loss.relative)
            rows.append((*cells, loss.restored_by or "nothing that was tried", loss.detail))
    heads = [Heading("engine"), Heading("feature"), Heading("verdict"), Heading("torque", "N m", ".2g")]
    heads += [Heading("share", "", ".1e"), Heading("restored by", key="restored_by"), Heading("detail")]
    return Table("What is lost, each by taking it out of the file and loading again", heads, rows)


def kept_lines(report: ModelReport) -> list[str]:
    """Engine by engine, what is as the file says."""
    out = []
    for engine in report.engines:
        if engine.losses:
            words: dict[str, list[str]] = {}
            for kept in (x for x in engine.losses if not x.is_loss and x.verdict != losses.NO_DYNAMICS):
                detail = f" ({kept.detail})" if kept.detail else ""
                words.setdefault(kept.verdict, []).append(kept.feature + detail)
            out.append(f"{engine.engine}: " + "; ".join(f"{k} {', '.join(v)}" for k, v in words.items()))
    return out


def notes(report: ModelReport) -> list[str]:
    """Engines that are missing, refuse the file, or take it only in part."""
    lines = [f"{engine.engine}: {engine.note}" for engine in report.engines if engine.note]
    return [*lines, f"all formats: {report.unwritten}"] if report.unwritten else lines


class FeatureRecord(TypedDict):
    """What an engine makes of a feature."""

    feature: str
    verdict: str
    torque: Annotated[float, "That is then wrong, N m (N)."]
    relative: Annotated[float, "Its share of ours."]
    detail: str
    restored_by: Annotated[str, "Empty where nothing that was tried does."]


class EngineRecord(TypedDict):
    """An engine; without the differences where it does not load the file."""

    engine: str
    note: Annotated[str, "Why it is missing, refuses the file, or takes it only in part; else empty."]
    mass: NotRequired[Annotated[float, "Of the links that it moves, kg."]]
    absolute: NotRequired[Annotated[dict[str, float], "Largest difference from ours, by quantity; kg m^2, N m, m."]]
    relative: NotRequired[Annotated[dict[str, float], "The same over our largest value."]]
    features: list[FeatureRecord]


class ModelRecord(TypedDict):
    """A model file."""

    file: str
    unwritten: Annotated[str, "What the arm has and no format holds."]
    engines: list[EngineRecord]


def document(reports: Sequence[ModelReport]) -> Document:
    """Everything on some models."""
    sections = [Section("", parts) for report in reports for parts in _parts(report)]
    models = [record(report) for report in reports]
    fact = Fact("models", models, "File by file, what each engine makes of it.", kind=list[ModelRecord])
    return Document("", "", sections, "lwr-dyn parity", "parity", [fact])


def _parts(report: ModelReport) -> list[list[Table | Note]]:
    agreed = any(x.agreement for x in report.engines)
    table = replace(agreement_table(report), when=agreed)
    return [[table], [loss_table(report)], [Note(kept_lines(report))], [Note(notes(report))]]


def record(report: ModelReport) -> dict[str, Any]:
    """A model for programs."""
    engines = [_engine_record(engine) for engine in report.engines]
    return {"file": report.file, "unwritten": report.unwritten, "engines": engines}


def _engine_record(engine: EngineReport) -> dict[str, Any]:
    found = engine.agreement
    out: dict[str, Any] = {"engine": engine.engine, "note": engine.note}
    if found is not None:
        out |= {"mass": found.mass, "absolute": found.absolute, "relative": found.relative}
    names = ("feature", "verdict", "torque", "relative", "detail", "restored_by")
    return out | {"features": [{name: getattr(loss, name) for name in names} for loss in engine.losses]}


def matrix(reports: Sequence[ModelReport]) -> Table:
    """Models and their features by rows, engines by columns."""
    engines = list(dict.fromkeys(engine.engine for report in reports for engine in report.engines))
    rows = []
    for report in reports:
        by_engine = {engine.engine: {loss.feature: loss for loss in engine.losses} for engine in report.engines}
        for feature in dict.fromkeys(name for found in by_engine.values() for name in found):
            cells = [_cell(by_engine.get(engine, {}).get(feature)) for engine in engines]
            rows.append((report.file, feature, *cells))
    return Table("What each engine makes of each file", [Heading("file"), Heading("feature"), *engines], rows)


def _cell(loss: Loss | None) -> str:
    if loss is None:
        return "-"
    size = f", {loss.torque:.2g} N m" if loss.torque else ""
    return f"{loss.verdict}{size}" + (f"; {loss.restored_by}" if loss.restored_by else "")


def markdown(table: Table) -> str:
    """A table as Markdown."""
    lines = [tuple(head.title for head in table.columns), ("---",) * len(table.columns), *table.cells]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
