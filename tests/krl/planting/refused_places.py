"""Faults of place that the pendant refuses: in SPLINE and SWITCH, jumps, GLOBAL twice, parameters without a type."""

from __future__ import annotations

import random
import re
from pathlib import PurePosixPath

from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import LOOPS, keyword_of
from lwr_dyn.krl.language.declarations import Declaration, Def
from lwr_dyn.krl.project.project import CONTROLLER_FILES, ModuleFile
from tests.krl.planting.site import PlantedFault, PlantSite, inserted, texts_of

_REALS = ("$VEL.CP", "$AXIS_ACT.A1", "$ACC.CP", "0.5")
_ASIDE = (s.Assign, s.Invoke, s.Wait)


def _rewritten(site: PlantSite, lines: list[str], told: int) -> PlantedFault:
    """A fault that must be told at the line with index `told`."""
    return PlantedFault(site.file.name, tuple(lines), frozenset({(site.file.name, told + 1)}))


def parameter_undeclared(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    """The declaration of a parameter is gone; or a subprogram without parameters gets one."""
    x, routine = site.statement, site.routine
    if not isinstance(x, Def) or routine is None or next(routine.lines(), None) is None:
        return None
    lines = texts_of(site.file)
    if not x.parameters:
        lines[site.at] = site.text.replace("(", "(NEW_NUMBER :IN", 1)
        return _rewritten(site, lines, site.at)
    names = {p.name.upper() for p in x.parameters}
    own = [
        i for i, y in routine.lines()
        if isinstance(y, Declaration) and len(y.names) == 1 and y.names[0].name.upper() in names
    ]  # fmt: skip
    if not own:
        return None
    del lines[rng.choice(own)]
    return _rewritten(site, lines, site.at)


def _in_spline(site: PlantSite, of_path: str, of_joints: str) -> PlantedFault | None:
    """A motion becomes a spline block of that motion and of a line that does not belong there."""
    x = site.statement
    if not isinstance(x, s.Move) or x.kind not in ("LIN", "PTP") or x.blends or x.settings or site.in_spline:
        return None
    last = site.tokens[-1]
    target = site.text[site.tokens[1].column - 1 : last.column - 1 + len(last.text)]
    kind, motion, fault = ("SPLINE", "SLIN", of_path) if x.kind == "LIN" else ("PTP_SPLINE", "SPTP", of_joints)
    lines = texts_of(site.file)
    lines[site.at : site.at + 1] = [kind, f"{motion} {target}", fault.format(target=target), "ENDSPLINE"]
    return _rewritten(site, lines, site.at + 2)


def output_in_spline(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    line = f"$OUT[{rng.randrange(1, 200)}] = TRUE"
    return _in_spline(site, line, line)


def pause_in_spline(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    line = rng.choice(["WAIT SEC 0.2", "WAIT FOR $IN[1]"])
    return _in_spline(site, line, line)


def motion_in_spline(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    return _in_spline(site, "PTP {target}", "LIN {target}")


def switch_on_real(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    x = site.statement
    if not isinstance(x, s.Condition) or x.keyword != "SWITCH":
        return None
    lines = texts_of(site.file)
    lines[site.at] = f"SWITCH {rng.choice(_REALS)}"
    return _rewritten(site, lines, site.at)


def before_first_case(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    """A line of the same routine, copied below SWITCH."""
    x, routine = site.statement, site.routine
    if not isinstance(x, s.Condition) or x.keyword != "SWITCH" or routine is None:
        return None
    lines = texts_of(site.file)
    copied = [lines[i] for i, y in routine.lines() if isinstance(y, _ASIDE)]
    return inserted(site, rng.choice(copied or ["WAIT SEC 0.1"]))


def case_after_default(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    routine = site.routine
    block = None if routine is None else routine.blocks.get(site.at)
    if block is None or block.kind != "SWITCH" or block.last != site.at:
        return None
    words = [keyword_of(site.file.lines[i].statement) for i in block.parts]
    if "DEFAULT" not in words or "CASE" not in words:
        return None
    lines = texts_of(site.file)
    lines[site.at : site.at] = [lines[block.parts[words.index("CASE")]], "HALT"]
    return _rewritten(site, lines, site.at)


def jump_into_loop(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    """A label in a loop, and a GOTO before the loop."""
    routine = site.routine
    if routine is None or not isinstance(site.statement, (*_ASIDE, s.Move)):
        return None
    loops = [b for b in routine.blocks.values() if b.kind in LOOPS and b.first < site.at < b.last]
    if not loops:
        return None
    block = max(loops, key=lambda b: b.first)
    inner = [b for b in routine.blocks.values() if b.first > block.first and b.first < site.at < b.last]
    if inner:
        return None
    lines = texts_of(site.file)
    lines.insert(site.at + 1, "NEW_PLACE:")
    lines.insert(block.first, "GOTO NEW_PLACE")
    return _rewritten(site, lines, block.first)


def global_twice(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    """A GLOBAL subprogram of another module once more; where that has none, a new one in both."""
    head = site.statement
    source = site.module.source
    if not isinstance(head, Def) or source is None or site.at != source.outline.routines[0].first - 1:
        return None
    others = [
        x for m in site.of.project.modules if m is not site.module and m.name != site.module.name
        for x in m.files if not x.file.is_data and x.outline.routines and m.path.parent == site.module.path.parent
        and not m.path.stem.lower().startswith(CONTROLLER_FILES)
    ]  # fmt: skip
    if not others:
        return None
    other = rng.choice(others)
    shared = [r.head.name for r in other.outline.routines if r.head.is_global]
    name = rng.choice(shared) if shared else "NEW_HELPER"
    new = [f"GLOBAL DEF {name}( )", "HALT", "END"]
    lines, theirs = texts_of(site.file), texts_of(other.file)
    more = () if shared else ((other.file.name, (*theirs, *new)),)
    return PlantedFault(site.file.name, (*lines, *new), frozenset({(site.file.name, len(lines) + 1)}), more)


def global_variable_twice(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    """A GLOBAL variable of another public `.dat` once more; where that has none, a new one in both."""
    data = next((x for x in site.module.files if x.file is site.file), None)
    if data is None or not data.file.is_data or keyword_of(site.statement) != "ENDDAT" or not _is_public(data):
        return None
    others = [
        x for m in site.of.project.modules if m is not site.module and m.name != site.module.name
        for x in m.files if x.file.is_data and m.path.parent == site.module.path.parent and _is_public(x)
    ]  # fmt: skip
    if not others:
        return None
    other = rng.choice(others)
    shared = [x.name for x in other.shared.variables.values()]
    line = f"DECL GLOBAL INT {rng.choice(shared) if shared else 'NEW_COUNT'}=0"
    lines, theirs = texts_of(site.file), texts_of(other.file)
    lines.insert(site.at, line)
    end = max(i for i, x in enumerate(other.file.lines) if keyword_of(x.statement) == "ENDDAT")
    more = () if shared else ((other.file.name, (*theirs[:end], line, *theirs[end:])),)
    return PlantedFault(site.file.name, tuple(lines), frozenset({(site.file.name, site.at + 1)}), more)


def _is_public(data: ModuleFile) -> bool:
    """Whether other modules see the GLOBAL names of a `.dat`; those of the controller's own files are left out."""
    if PurePosixPath(data.file.name).name.lower().startswith(CONTROLLER_FILES):
        return False
    return any(re.match(r"\s*DEFDAT\s+\w+\s+PUBLIC\b", text, re.IGNORECASE) for text in texts_of(data.file))
