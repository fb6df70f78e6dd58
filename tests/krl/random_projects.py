"""Random projects, and a second way to say which file's name a module sees: by going through all files."""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from pathlib import PurePosixPath

from lwr_dyn.krl.language.source import parse_text
from lwr_dyn.krl.project.program import program_in
from lwr_dyn.krl.project.project import ModuleFile, Project, module_file, project_of

FOLDERS = ("R1/Program", "R1/Program/a", "R1/Program/b", "R1/System", "STEU", "STEU/a", "R1", "r1/program/a", "loose")
VARIABLES = [f"v{i}" for i in range(6)]
ROUTINES = [f"p{i}" for i in range(6)]


@dataclass(frozen=True)
class WrittenModule:
    """A module as it is written: where it stands, and what it declares as global or for itself."""

    folder: str
    name: str
    public: bool
    variables: dict[str, bool] = field(default_factory=dict)
    """Name -> whether it is GLOBAL."""
    routines: dict[str, bool] = field(default_factory=dict)
    """The first one is seen from outside."""

    @property
    def texts(self) -> dict[str, str]:
        """Path -> text."""
        path, lines = f"{self.folder}/{self.name}", [f"DEFDAT {self.name}{' PUBLIC' * self.public}"]
        lines += [f"{'GLOBAL ' * shared}INT {v}" for v, shared in self.variables.items()]
        out = {f"{path}.dat": "\n".join([*lines, "ENDDAT", ""])}
        if not self.name.startswith("$"):
            heads = (f"{'GLOBAL ' * shared}DEF {r}( )\nEND\n" for r, shared in self.routines.items())
            out[f"{path}.src"] = "".join(heads)
        return out

    @property
    def part(self) -> str:
        """STEU or R1; what stands loose belongs to the one robot."""
        return "STEU" if self.folder.startswith("STEU") else "R1"

    def shares(self, name: str) -> bool:
        """Whether another module sees this name of it."""
        if name in self.variables:
            return self.name.startswith("$") or (self.public and self.variables[name])
        return name in self.routines and (self.routines[name] or name == next(iter(self.routines)))


def random_modules(rng: random.Random) -> list[WrittenModule]:
    """Up to a dozen modules; no two files have one path."""
    out: dict[tuple[str, str], WrittenModule] = {}
    for _ in range(rng.randint(2, 12)):
        folder, name = rng.choice(FOLDERS), rng.choice(["m1", "m2", "m3", "m4", "$config"])
        variables = {v: rng.random() < 0.5 for v in rng.sample(VARIABLES, rng.randint(0, 4))}
        routines = {r: rng.random() < 0.3 for r in rng.sample(ROUTINES, rng.randint(1, 3))}
        if name.startswith("$"):
            routines = {}
        module = WrittenModule(folder, name, rng.random() < 0.6, variables, routines)
        out.setdefault((folder.lower(), name), module)
    modules = list(out.values())
    return modules if any(m.folder.lower().startswith("r1") for m in modules) else random_modules(rng)


def files_of(modules: list[WrittenModule]) -> list[ModuleFile]:
    """All files of modules, read."""
    texts = {path: text for m in modules for path, text in m.texts.items()}
    return [module_file(*parse_text(text, path)) for path, text in texts.items()]


def seen_file(modules: list[WrittenModule], module: WrittenModule, name: str) -> str | None:
    """The file whose name a module means, by the rule as it is written down; None for a name that it does not see."""
    ending = "dat" if name in VARIABLES else "src"
    if name in (*module.variables, *module.routines):
        return f"{module.folder}/{module.name}.{ending}"
    others = [m for m in modules if m is not module and m.part == module.part and m.shares(name)]
    if not others:
        return None
    nearest = min(others, key=lambda m: (steps(module.folder, m.folder), f"{m.folder}/{m.name}".upper()))
    return f"{nearest.folder}/{nearest.name}.{ending}"


def steps(a: str, b: str) -> int:
    """Folders up from a to one that holds b, and down to b."""
    up = [str(x).lower() for x in (PurePosixPath(a), *PurePosixPath(a).parents)]
    down = [str(x).lower() for x in (PurePosixPath(b), *PurePosixPath(b).parents)]
    return min(i + down.index(x) for i, x in enumerate(up) if x in down)


def disagreement(rng: random.Random) -> str | None:
    """A name of a random project that a module takes from another file than the rule says; None for none."""
    modules = random_modules(rng)
    files = files_of(modules)
    rng.shuffle(files)
    project: Project = project_of(files)
    for m in modules:
        own = next(iter(m.texts))
        names = program_in(project, project.homes[own]).names
        for name in (*VARIABLES, *ROUTINES):
            variable, routine = names.variables.get(name.upper()), names.routines.get(name.upper())
            found = variable.position.file if variable else routine.file.name if routine else None
            if found != seen_file(modules, m, name):
                return f"{name} in {own} is of {found}, not of {seen_file(modules, m, name)}: {modules}"
    return None
