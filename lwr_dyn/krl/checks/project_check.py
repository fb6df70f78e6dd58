"""The check of a project: language, names and types of each of its files."""

from collections.abc import Sequence
from dataclasses import dataclass

from lwr_dyn.krl.checks.static_checks import static_diagnostics
from lwr_dyn.krl.diagnostics import SEVERITIES, Diagnostic, has_no_error, sorted_diagnostics
from lwr_dyn.krl.project.program import program_in
from lwr_dyn.krl.project.project import Project


@dataclass(frozen=True, slots=True, eq=False)
class CheckedFile:
    """A file of a project: its path within the folder, its number of lines, and its diagnostics."""

    name: str
    lines: int
    diagnostics: tuple[Diagnostic, ...]

    @property
    def counts(self) -> dict[str, int]:
        """The number of its errors, warnings and notes."""
        return {f"{x}s": sum(d.severity == x for d in self.diagnostics) for x in SEVERITIES}


def check_project(project: Project) -> tuple[CheckedFile, ...]:
    """Each file of a project with its diagnostics, module by module."""
    found: dict[str, list[Diagnostic]] = {x.file.name: [] for x in project.files}
    for diagnostic in project.twins():
        found[diagnostic.position.file].append(diagnostic)
    for module in project.modules:
        program = program_in(project, module)
        for diagnostic in (*program.diagnostics, *static_diagnostics(program)):
            found[diagnostic.position.file].append(diagnostic)
    files = {x.file.name: x.file for x in project.files}
    return tuple(CheckedFile(k, len(x.lines), sorted_diagnostics(found[k])) for k, x in files.items())


def totals(files: Sequence[CheckedFile]) -> dict[str, int]:
    """Files, lines, programs (`.src` and `.sub`), those of them without an error, and the diagnostics by severity."""
    programs = [x for x in files if not x.name.lower().endswith(".dat")]
    clean = sum(has_no_error(x.diagnostics) for x in programs)
    counts = {f"{x}s": sum(y.counts[f"{x}s"] for y in files) for x in SEVERITIES}
    lines = sum(x.lines for x in files)
    return {"files": len(files), "lines": lines, "programs": len(programs), "without_error": clean, **counts}
