"""The runs behind scripts/robustness.py: the study's own, each parameter alone, and runs again with true stick."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.codegen.rollouts.law_forms import law_form
from lwr_dyn.codegen.rollouts.loop_setup import arm_of_run
from lwr_dyn.model.friction import symmetric
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.studies.sweep.outwards import FirstBreak, Span, outward_search
from lwr_dyn.studies.sweep.read_study import read_study
from lwr_dyn.studies.sweep.rollout_arguments import rollout_arguments
from lwr_dyn.studies.sweep.running.sweep_folder import SweepResults
from lwr_dyn.studies.sweep.running.workshop import SweepWorkshop
from lwr_dyn.studies.sweep.summary import spans
from lwr_dyn.studies.sweep.sweep_study import SweepStudy
from lwr_dyn.studies.sweep.vocabulary import metric_words

STICKING = 12
"""Runs of each controller that are simulated with friction that sticks."""
METRICS = ("tip_max", "tip_rms", "saturated_s", "limit_margin", "peak_speed")
WORDS = {
    "arm.mass": ("masses", 1.0, "times"), "arm.inertia": ("tensors", 1.0, "times"),
    "arm.com": ("centres of mass", 1e3, "mm"), "payload.mass": ("unknown load", 1.0, "kg"),
    "friction.coulomb": ("friction", 100.0, "%"), "loop.delay": ("delay", 1.0, "samples"),
}  # fmt: skip
"""Path -> words, and how many of the unit for people are one."""


@dataclass(frozen=True, eq=False)
class StudyRuns:
    """A study, what makes its runs, and the columns of each controller's."""

    study: SweepStudy
    workshop: SweepWorkshop
    columns: Mapping[str, Mapping[str, Any]]

    @property
    def velocity(self) -> np.ndarray:
        """(n,) [rad/s]."""
        return self.workshop.arm.velocity


def made(file: Path, folder: Path, threads: int) -> StudyRuns:
    """The study's runs, computed where they are not in the folder yet."""
    study = read_study(file)
    command = [sys.executable, "-m", "lwr_dyn", "sweep", str(file), "--out", str(folder), "--jobs", str(threads)]
    if not folder.is_dir() or not SweepResults.load(folder).is_complete:
        subprocess.run(command, check=True)
    found = SweepResults.load(folder)
    if found.manifest.digest != study.digest:
        raise SystemExit(f"{folder}: of another study; {file} has the digest {study.digest[:8]}")
    columns = {name: columns_of(found.controllers[name]) for name in study.controllers}
    return StudyRuns(study, SweepWorkshop(study, threads), columns)


def columns_of(one: Any) -> dict[str, Any]:
    """The columns of the runs of one controller that `robustness.figures` reads."""
    paths = ("payload.known", "loop.delay")
    own = {"run": one.run, "flags": one.flags}
    return {**own, **{path: one.values[path] for path in paths}, **{name: one.metrics[name] for name in METRICS}}


def alone(made: StudyRuns, name: str) -> dict[str, Any]:
    """Where each parameter alone breaks the tolerance; `first` does after the least share of its way."""
    limit = {metric_words("tip_max"): made.study.tolerance}
    ranges = [_as_modelled(made.study, name, one) for one in spans(made.study)]
    found = outward_search(ranges, limit, lambda values: made.workshop.evaluate(name, values))
    if found.at_nominal:
        rows = [{"path": path, "words": words, "text": "-"} for path, (words, _, _) in WORDS.items()]
        return {"alone": rows, "first": "broken as modelled"}
    rows = [_row(path, [line for line in found.lines if line.path == path]) for path in WORDS]
    broken = [row for row in rows if row["share"] is not None]
    return {"alone": rows, "first": min(broken, key=lambda row: row["share"])["words"] if broken else "none"}


def _as_modelled(study: SweepStudy, name: str, one: Span) -> Span:
    """From what the law knows: its friction or none, the load in the middle of the set of `robust`."""
    if one.path == "friction.coulomb":
        return replace(one, nominal=study.assumed_friction if "+friction" in name else 0.0)
    if one.path == "payload.mass" and name == "robust":
        return replace(one, nominal=0.5 * (one.lowest + one.highest))
    return one


def _row(path: str, lines: list[FirstBreak]) -> dict[str, Any]:
    words, factor, unit = WORDS[path]
    hits = sorted((line for line in lines if line.share is not None), key=lambda line: line.share or 0.0)
    if not hits:
        return {"path": path, "words": words, "share": None, "text": "never"}
    first = hits[0]
    value = f"{factor * (first.broken or 0.0):.3g} {unit}"
    return {"path": path, "words": words, "share": first.share, "text": f"{value} ({100 * (first.share or 0.0):.0f} %)"}


def stick(made: StudyRuns, name: str) -> dict[str, Any]:
    """The first runs again with friction that sticks: the largest error over that of the rollout, less 1."""
    shop = made.workshop
    arguments = rollout_arguments(made.study, name, made.study.values(0, STICKING))
    form, loop = law_form(shop.controller(name), shop.arm), made.study.loop
    ratios = []
    for i in range(STICKING):
        row = {key: x[i] for key, x in arguments["parameters"].items()}
        values = {key: row.get(key, x) for key, x in form.values().items()}
        joints = tuple(symmetric(float(coulomb), 0.0) for coulomb in row["friction"].reshape(5, -1)[0])
        plant = replace(arm_of_run(shop.arm, row), friction=joints)
        run = simulate(
            shop.arm, form.controller(arm_of_run(shop.arm, row, "model_"), values), shop.references[0], plant=plant,
            rate=loop["rate"], delay=int(row["delay"]), progress=lambda _: None,
        )  # fmt: skip
        ratios.append(metrics(run, shop.arm).tip_max_mm / (1e3 * float(made.columns[name]["tip_max"][i])) - 1.0)
    return {
        "runs": STICKING,
        **{
            key: float(f"{x:.4g}")
            for key, x in zip(("median", "least", "most"), (np.median(ratios), min(ratios), max(ratios)), strict=True)
        },
    }


def tuned(file: Path, words: Sequence[str]) -> dict[str, Any]:
    """The record of `lwr-dyn tune`."""
    command = [sys.executable, "-m", "lwr_dyn", "tune", str(file), *words, "--json"]
    record: dict[str, Any] = json.loads(subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False).stdout)
    return {key: record[key] for key in ("controller", "aim", "torque_share", "search", "given", "found", "check")}


def repeated(shop: SweepWorkshop, name: str, numbers: Sequence[int]) -> dict[str, np.ndarray]:
    """Errors of the tip [mm] of runs of the study by their numbers, computed now."""
    each = [shop.study.values(i, i + 1) for i in numbers]
    values = {path: np.concatenate([one[path] for one in each]) for path in each[0]}
    found = shop.evaluate(name, values)
    return {key: 1e3 * found[key] for key in ("tip_max", "tip_rms")}
