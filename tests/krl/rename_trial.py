"""Names of a project drawn by a seed and renamed: what the checks say must stay the same, but for the name."""

from __future__ import annotations

import random
import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.referents import name_column
from lwr_dyn.krl.editor.renaming import KeptNameError, renamable, renamed
from tests.krl.random_projects import ROUTINES, VARIABLES, random_modules
from tests.krl.recall_trial import words_in_code


@dataclass
class RenameTrial:
    """What became of the renames; `changed` are those after which the checks said something else."""

    renamed: int = 0
    places: int = 0
    kinds: Counter[str] = field(default_factory=Counter)
    kept: Counter[str] = field(default_factory=Counter)
    changed: list[str] = field(default_factory=list)


def random_backup(rng: random.Random, folder: Path) -> EditedProject:
    """Modules of the same few names in folders that see each other in part; their routines use names at random."""
    texts = {path: text for m in random_modules(rng) for path, text in m.texts.items()}

    def body(head: re.Match[str]) -> str:
        lines = [f"{rng.choice(VARIABLES)} = {rng.choice(VARIABLES)} + 1" for _ in range(3)]
        return "\n".join([head[0].rstrip(), *lines, f"{rng.choice(ROUTINES)}( )", ""])

    filled = {path: re.sub(r"(GLOBAL )?DEF \w+\( \)\n", body, text) for path, text in texts.items()}
    return EditedProject(folder, texts=filled)


def rename_trial(project: EditedProject, rng: random.Random, wanted: int, tries: int = 100_000) -> RenameTrial:
    """Rename names drawn by the seed, each in the project as it was, until so many were renamed."""
    words = words_in_code(project)
    out, names = RenameTrial(), [(file, i, name_column(tokens[k])) for file, i, _, tokens, k in words]
    rng.shuffle(names)
    for file, line, column in names[:tries]:
        if out.renamed == wanted:
            break
        new = rng.choice(["zz_new", "q", "v", "p", "A_LONGER_NAME_THAN_MOST"]) + str(rng.randrange(9))
        try:
            found = renamable(project, file, line, column)
            uses = renamed(project, found, new)
        except KeptNameError as why:
            out.kept[str(why).partition(" ")[2][:32]] += 1
            continue
        referent = found.referent
        out.renamed += 1
        out.places += len(uses)
        out.kinds[referent.meaning] += 1
        after = project.with_texts(written(project, uses, len(referent.name), new))
        if said(project, referent.name, new) != said(after, referent.name, new):
            out.changed.append(f"{file}:{line + 1} {referent.name} -> {new}")
    return out


def written(project, uses, length, new):
    """The texts of the changed files; written anew here, to hold the one of `renaming` against it."""
    texts = {name: "".join(x.shown + x.end for x in project.project.file(name).file.lines) for name in
             {x.file for x in uses}}  # fmt: skip
    for name in texts:
        starts, at = [], 0
        for x in project.project.file(name).file.lines:
            starts.append(at)
            at += len(x.shown) + len(x.end)
        for use in sorted((x for x in uses if x.file == name), key=lambda x: (-x.line, -x.column)):
            first = starts[use.line - 1] + use.column - 1
            texts[name] = texts[name][:first] + new + texts[name][first + length :]
    return texts


def said(project: EditedProject, old: str, new: str) -> Counter[tuple[str, int, str, str]]:
    """File, line, severity and code of all diagnoses of the modules in whose text one of two names stands."""
    out: Counter[tuple[str, int, str, str]] = Counter()
    for module in project.project.modules:
        text = "".join(x.shown for f in module.files for x in f.file.lines).upper()
        if old.upper() in text or new.upper() in text:
            name = module.files[0].file.name
            found = (d for each in project.diagnostics(name).values() for d in each)
            out.update((d.position.file, d.position.line, d.severity, d.code) for d in found)
    return out
