"""Plants faults in programs without errors, a seeded choice, and judges what the check says of each.

Only the static check is asked, the whole project in view. A fault counts as told if an error or a warning that was not
there before stands at one of its places; as rightly named if its code is one of those of its kind (`kinds`).
Sites: lines of programs whose own files have no error, without a diagnostic of their own; the projects take turns, so
that one large project does not count for all.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass

from lwr_dyn.krl.checks.static_checks import static_diagnostics
from lwr_dyn.krl.diagnostics import Diagnostic, has_no_error, sorted_diagnostics
from lwr_dyn.krl.language.source import parse_text
from lwr_dyn.krl.project.program import program_in
from lwr_dyn.krl.project.project import Module, Project, module_file, project_of
from tests.krl.planting.kinds import KINDS, FaultKind
from tests.krl.planting.site import PlantedFault, PlantSite, SeededProject

LONGEST = 3000
"""Lines of a program; longer ones are points only."""


@dataclass(frozen=True, slots=True)
class PlantVerdict:
    """What the check said of one planted fault."""

    kind: str
    project: str
    file: str
    line: int
    """Of the site, from 1."""
    text: str
    """The line with the fault."""
    told: bool
    named: bool
    said: tuple[str, ...]
    """Codes at its places."""


@dataclass(frozen=True, slots=True, eq=False)
class CleanModule:
    """A module without errors of its own, and the lines (file, line from 1) at which something is said."""

    of: SeededProject
    module: Module
    lines: frozenset[tuple[str, int]]


MISSING = frozenset({"undeclared", "unknown-call", "unknown-type"})
"""Codes of names that a file which is not there may declare."""


def clean_modules(projects: Sequence[SeededProject], passed: frozenset[str] = frozenset()) -> list[CleanModule]:
    """The modules in which faults are planted: with a `.src`, of at most `LONGEST` lines, and without any error.

    Errors of the codes `passed` do not count; no fault is planted in their lines.
    """
    out = []
    for of in projects:
        for module in of.project.modules:
            if module.source is None or not 5 <= len(module.source.file.lines) <= LONGEST:
                continue
            found = diagnostics_of(of.project, module)
            if has_no_error([d for d in found if d.code not in passed]):
                out.append(CleanModule(of, module, frozenset((d.position.file, d.position.line) for d in found)))
    return out


def diagnostics_of(project: Project, module: Module) -> tuple[Diagnostic, ...]:
    """What the static check says of a module's own files."""
    program = program_in(project, module)
    own = {x.file.name for x in module.files}
    found = [*program.diagnostics, *static_diagnostics(program)]
    return sorted_diagnostics(d for d in found if d.position.file in own)


def verdicts(
    modules: Sequence[CleanModule], seed: int, count: int, kinds: Sequence[FaultKind] = KINDS
) -> list[PlantVerdict]:
    """`count` faults of each kind, fewer where fewer sites are found."""
    return [x for kind in kinds for x in _verdicts_of(kind, modules, random.Random(f"{seed} {kind.name}"), count)]


def _verdicts_of(kind: FaultKind, modules: Sequence[CleanModule], rng: random.Random, count: int) -> list[PlantVerdict]:
    by_project: dict[str, list[CleanModule]] = {}
    for x in modules:
        by_project.setdefault(x.of.name, []).append(x)
    queues = [rng.sample(group, len(group)) for _, group in sorted(by_project.items())]
    out: list[PlantVerdict] = []
    while queues and len(out) < count:
        rng.shuffle(queues)
        for queue in queues:
            verdict = _first(kind, queue, rng)
            if verdict is not None and len(out) < count:
                out.append(verdict)
        queues = [queue for queue in queues if queue]
    return out


def _first(kind: FaultKind, queue: list[CleanModule], rng: random.Random) -> PlantVerdict | None:
    """The verdict at a site of the next module of a project that has one; modules without one leave the queue."""
    while queue:
        clean = queue.pop()
        sites = [
            PlantSite(clean.of, clean.module, x.file, i) for x in clean.module.files for i in range(len(x.file.lines))
        ]
        for site in rng.sample(sites, len(sites)):
            if site.statement is None or (site.file.name, site.at + 1) in clean.lines:
                continue
            fault = kind.plant(site, rng)
            if fault is not None and not fault.places & clean.lines:
                return _judged(kind, clean, site, fault)
    return None


def _judged(kind: FaultKind, clean: CleanModule, site: PlantSite, fault: PlantedFault) -> PlantVerdict:
    texts = {fault.file: fault.lines, **dict(fault.others)}
    new = [module_file(*parse_text("\n".join(lines) + "\n", name)) for name, lines in texts.items()]
    whole = clean.of.project
    project = project_of([*(x for x in whole.files if x.file.name not in texts), *new], whole.folder)
    found = diagnostics_of(project, project.homes[fault.file])
    at = [d for d in found if (d.position.file, d.position.line) in fault.places and d.severity != "note"]
    codes = tuple(d.code for d in at)
    line = min((line for file, line in fault.places if file == fault.file), default=site.at + 1)
    text = fault.lines[min(line, len(fault.lines)) - 1].strip()
    named = any(code in kind.codes for code in codes)
    return PlantVerdict(kind.name, clean.of.name, site.file.name, site.at + 1, text, bool(codes), named, codes)
