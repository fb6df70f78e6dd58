"""How many public KRL programs the checker takes as they are: verdicts on its errors, by program and by repository.

    python scripts/studies/krl_programs.py FOLDER [--manifest scripts/studies/krl_programs.toml] [--list] [--rates FILE]

FOLDER holds one folder a repository, named `owner+name`; its `.commit` says which state. The programs are not ours and
are not part of this project: only counts and verdicts stay, in the manifest. Each `.src` counts once, whatever its
spaces, comments of the header and capitals, and is checked twice: alone with its `.dat`, and in its folder with all
other files (`lwr-dyn krl check FOLDER`). `krl_verdicts` says what counts as false. `--list` shows every error that is
false or unclear, `--rates` writes the counts by repository as TOML.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from lwr_dyn.krl.diagnostics import Diagnostic  # noqa: E402
from lwr_dyn.krl.project.program import load_program, load_project, program_in  # noqa: E402
from lwr_dyn.krl.project.project import Module, Project  # noqa: E402
from lwr_dyn.krl.running.program_run import check_program  # noqa: E402
from scripts.studies.krl_verdicts import (  # noqa: E402
    SYNTAX_CODES,
    VERDICTS,
    Judge,
    Judgement,
    Verdict,
    corpus_names,
    judgements,
)

MANIFEST = Path(__file__).with_suffix(".toml")
RATES = ("no false syntax", "no false alarm", "neither false nor unclear", "no error")


@dataclass(frozen=True, slots=True)
class JudgedError:
    """An error and its verdict."""

    file: str
    diagnosis: Diagnostic
    verdict: Verdict


@dataclass(frozen=True, slots=True)
class CheckedProgram:
    """A program and what was said of it."""

    repository: str
    file: str
    errors: tuple[JudgedError, ...]

    def passes(self) -> tuple[bool, ...]:
        """One answer for each of `RATES`."""
        verdicts = [x.verdict for x in self.errors]
        syntax = any(x.verdict == "false" and x.diagnosis.code in SYNTAX_CODES for x in self.errors)
        return (not syntax, "false" not in verdicts, not {"false", "unclear"} & set(verdicts), not verdicts)


def program_paths(folder: Path) -> list[Path]:
    """Each `.src` once, the first of those that differ in spaces, capitals or header lines only."""
    seen: set[bytes] = set()
    out = []
    for path in sorted(x for x in folder.rglob("*") if x.suffix.lower() == ".src" and x.is_file()):
        lines = (line.strip() for line in path.read_bytes().lower().splitlines())
        text = b"\n".join(line for line in lines if line and not line.startswith(b"&"))
        digest = hashlib.sha1(text, usedforsecurity=False).digest()
        if digest not in seen:
            seen.add(digest)
            out.append(path)
    return out


def check_alone(folder: Path, judge: Judge, paths: Sequence[Path]) -> Iterator[CheckedProgram]:
    """Each program with its `.dat` only."""
    for path in paths:
        parts = path.relative_to(folder).parts
        place = "/".join(parts[1:-1])
        found = check_program(load_program(path), None)
        yield _judged(judge, parts[0], "/".join(parts[1:]), ((_joined(place, d), d) for d in found), alone=True)


def check_together(folder: Path, judge: Judge, paths: Sequence[Path]) -> Iterator[CheckedProgram]:
    """Each program in its folder, with all files of it."""
    for repository in sorted({path.relative_to(folder).parts[0] for path in paths}):
        project = load_project(folder / repository)
        wanted = {path.relative_to(folder / repository).as_posix() for path in paths if repository in path.parts}
        for module in project.modules:
            if module.source is not None and module.source.file.name in wanted:
                yield check_module(judge, repository, project, module)


def check_module(judge: Judge, repository: str, project: Project, module: Module) -> CheckedProgram:
    """One program of a project."""
    found = check_program(program_in(project, module), None)
    return _judged(judge, repository, str(module.path), ((d.position.file, d) for d in found), alone=False)


def _joined(place: str, diagnosis: Diagnostic) -> str:
    return f"{place}/{diagnosis.position.file}" if place else diagnosis.position.file


def _judged(judge: Judge, repository: str, file: str, found: Iterable[tuple[str, Diagnostic]], *, alone: bool
            ) -> CheckedProgram:  # fmt: skip
    errors = [
        JudgedError(where, d, judge.verdict(repository, where, d, alone=alone))
        for where, d in found
        if d.severity == "error"
    ]
    return CheckedProgram(repository, file, tuple(errors))


def rates(programs: Sequence[CheckedProgram]) -> list[float]:
    """Per cent of programs that pass, for each of `RATES`."""
    passed = [x.passes() for x in programs]
    return [100.0 * sum(column) / len(programs) for column in zip(*passed, strict=True)]


def by_repository(programs: Iterable[CheckedProgram]) -> dict[str, list[CheckedProgram]]:
    """The programs of each repository."""
    out: dict[str, list[CheckedProgram]] = {}
    for program in programs:
        out.setdefault(program.repository, []).append(program)
    return out


def table(programs: Sequence[CheckedProgram], title: str) -> str:
    """The rates over programs and over repositories."""
    parts = [rates(x) for x in by_repository(programs).values()]
    mean = [sum(column) / len(parts) for column in zip(*parts, strict=True)]
    verdicts = Counter(error.verdict for x in programs for error in x.errors)
    rows = [f"{title}: {len(programs)} programs, {len(parts)} repositories"]
    rows += [
        f"  {name:28s}{a:6.1f} %{b:8.1f} % by repository"
        for name, a, b in zip(RATES, rates(programs), mean, strict=True)
    ]
    return "\n".join([*rows, "  errors: " + ", ".join(f"{verdicts[x]} {x}" for x in VERDICTS)])


def listed(programs: Iterable[CheckedProgram]) -> Iterator[str]:
    """A line for every false or unclear error."""
    for program in programs:
        for x in program.errors:
            if x.verdict in ("false", "unclear"):
                d = x.diagnosis
                yield f"{x.verdict}\t{program.repository}\t{x.file}:{d.position.line}\t{d.code}\t{d.message}"


def counts(folder: Path, alone: Sequence[CheckedProgram], together: Sequence[CheckedProgram]) -> str:
    """The counts by repository as TOML, without a word of a program."""
    inside = by_repository(together)
    out = []
    for name, programs in by_repository(alone).items():
        files = [x for x in (folder / name).rglob("*") if x.is_file() and x.name != ".commit"]
        lines = sum(len(x.read_bytes().splitlines()) for x in files)
        commit = folder / name / ".commit"
        out += ["[[repository]]", f'name = "{name.replace("+", "/")}"']
        out += [f'commit = "{commit.read_text().strip() if commit.exists() else ""}"']
        out += [f"files = {len(files)}", f"lines = {lines}", f"programs = {len(programs)}"]
        for key, group in (("alone", programs), ("together", inside[name])):
            passed = [sum(column) for column in zip(*(x.passes() for x in group), strict=True)]
            out.append(f"{key} = {passed}")
        out.append("")
    return "\n".join(out)


def study(folder: Path, rows: list[Judgement], *more: Path) -> tuple[list[CheckedProgram], list[CheckedProgram], Judge]:
    """All programs alone, all in their folders, and the judge with what was left undecided; `more` gives names only."""
    judge = Judge(corpus_names(folder, *more), rows)
    paths = program_paths(folder)
    return list(check_alone(folder, judge, paths)), list(check_together(folder, judge, paths)), judge


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--manifest", type=Path, default=MANIFEST)
    parser.add_argument("--names", type=Path, action="append", default=[], help="a folder whose names are known too")
    parser.add_argument("--list", action="store_true", help="every false and unclear error")
    parser.add_argument("--rates", type=Path, help="write the counts by repository")
    given = parser.parse_args()
    rows = judgements(tomllib.loads(given.manifest.read_text(encoding="utf-8")).get("judgement", []))
    alone, together, judge = study(given.folder, rows, *given.names)
    if given.list:
        print("\n".join(["alone", *listed(alone), "together", *listed(together)]))
    print(table(alone, "alone"), table(together, "in their folders"), sep="\n")
    print(f"{len(judge.undecided)} errors that no rule and no row decides count as false")
    if given.rates is not None:
        given.rates.write_text(counts(given.folder, alone, together), encoding="utf-8")


if __name__ == "__main__":
    main()
