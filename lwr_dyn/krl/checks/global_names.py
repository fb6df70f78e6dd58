"""GLOBAL names that two modules declare: the controller takes neither of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import PurePosixPath

from lwr_dyn.krl.diagnostics import Diagnostic, Severity, SourcePosition
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.project.project import CONTROLLER_FILES, Module, ModuleFile, Project

_Places = Mapping[tuple[tuple[str, ...], str], tuple[tuple[Module, SourcePosition], ...]]


def repeated_globals(program: Program) -> Iterator[Diagnostic]:
    """Each GLOBAL subprogram and each GLOBAL name of a PUBLIC `.dat` of the module that another module declares too.

    Modules of one name are copies, which are reported as such. A warning where the files lie in different folders of no
    robot, which may be programs of different robots.
    """
    project, module = program.project, program.module
    places = _places(project)
    for file in module.files:
        for name, position in _globals_of(file):
            others = places[project.parts[module], name.upper()]
            other = next(((m, at) for m, at in others if m.name != module.name), None)
            if other is not None:
                together = project.parts[module] or module.path.parent == other[0].path.parent
                severity: Severity = "error" if together else "warning"
                message = f"{name} is GLOBAL here and in {other[1].file}, line {other[1].line}"
                hint = "rename one of them, or leave out GLOBAL in one"
                yield Diagnostic(position, severity, "global-twice", message, hint)


@lru_cache(maxsize=4)
def _places(project: Project) -> _Places:
    """Where each GLOBAL name is declared, by the robot and the name in capitals."""
    out: dict[tuple[tuple[str, ...], str], tuple[tuple[Module, SourcePosition], ...]] = {}
    for module in project.modules:
        for file in module.files:
            for name, position in _globals_of(file):
                key = (project.parts[module], name.upper())
                out[key] = (*out.get(key, ()), (module, position))
    return out


def _globals_of(file: ModuleFile) -> Iterator[tuple[str, SourcePosition]]:
    """The GLOBAL names of a file that other modules see; those of the controller's own files are left out."""
    if PurePosixPath(file.file.name).stem.lower().startswith(CONTROLLER_FILES):
        return
    for routine in file.outline.routines:
        if routine.head.is_global:
            yield routine.head.name, routine.file.position(routine.first - 1, routine.head.column)
    for declared in (*file.shared.variables.values(), *file.shared.types.values()):
        yield declared.name, declared.position
