"""What the pendant refuses: names of the controller, what is only read, interrupts, texts, OUT, and faults of place."""

from __future__ import annotations

import re
from pathlib import PurePosixPath
from random import Random

from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import LOOPS, keyword_of
from lwr_dyn.krl.language.declarations import Declaration, Def
from lwr_dyn.krl.language.lexer import Token
from lwr_dyn.krl.names.known_names import known_names
from lwr_dyn.krl.project.project import CONTROLLER_FILES, ModuleFile
from tests.krl.planting.site import (
    EXECUTABLE,
    STEPS,
    PlantedFault,
    PlantSite,
    changed,
    inserted,
    kind_of,
    texts_of,
    told_at,
)  # fmt: skip

_READ_ONLY = (
    ("$POS_ACT", "{X 0,Y 0,Z 0,A 0,B 0,C 0}"), ("$AXIS_ACT", "{A1 0,A2 0,A3 0,A4 0,A5 0,A6 0}"), ("$ROBRUNTIME", "0"),
    ("$PERI_RDY", "TRUE"), ("$STOPMESS", "FALSE"), ("$MODE_OP", "#EX"), ("$VEL_ACT", "0.1"), ("$ON_PATH", "TRUE"),
)  # fmt: skip
_OF_OPTIONS = {"EKI_GETINT": "INT", "EKI_GETREAL": "REAL", "EKI_GETBOOL": "BOOL", "EKI_GETFRAME": "FRAME"}
"""Functions of an option that write their third argument, with its type."""
_CONSTANTS = {"INT": "7", "REAL": "2.5", "BOOL": "TRUE", "FRAME": "{X 0,Y 0,Z 0,A 0,B 0,C 0}"}


def system_name_slip(site: PlantSite, rng: Random) -> PlantedFault | None:
    """`$TOLL`: two letters of a name swapped, one left out or doubled."""
    names = [t for t in site.tokens if t.kind == "NAME" and t.text.startswith("$") and len(t.text) > 2]
    if not names or not isinstance(site.statement, EXECUTABLE):
        return None
    token = rng.choice(names)
    word = site.typo(token.text[1:], rng)
    if word is None or f"${word}".upper() in known_names().variables:
        return None
    return changed(site, site.replaced(token, f"${word}"))


def _output(site: PlantSite) -> Token | None:
    """The first token of a line that writes an output by its number."""
    x = site.statement
    root = e.root_name(x.target) if isinstance(x, s.Assign) else ""
    return site.tokens[0] if root in ("$OUT", "$ANOUT") and site.tokens else None


def input_written(site: PlantSite, rng: Random) -> PlantedFault | None:
    token = _output(site)
    if token is None:
        return None
    return changed(site, site.replaced(token, {"$OUT": "$IN", "$ANOUT": "$ANIN"}[token.text.upper()]))


def input_signal_written(site: PlantSite, rng: Random) -> PlantedFault | None:
    """A SIGNAL on an input, written in place of an output."""
    token, routine, x = _output(site), site.routine, site.statement
    if token is None or routine is None or token.text.upper() != "$OUT" or not isinstance(x, s.Assign):
        return None
    lines = texts_of(site.file)
    value = site.text[site.text.index("=") :]
    lines[site.at] = f"NEW_SENSOR {value}"
    lines.insert(routine.first, f"SIGNAL NEW_SENSOR $IN[{rng.randrange(1, 400)}]")
    return told_at(site.file, lines, (site.file.name, site.at + 2))


def read_only_written(site: PlantSite, rng: Random) -> PlantedFault | None:
    if not isinstance(site.statement, STEPS) or site.file.is_data or site.in_spline:
        return None
    name, value = rng.choice(_READ_ONLY)
    return inserted(site, f"{name} = {value}")


def interrupt_undeclared(site: PlantSite, rng: Random) -> PlantedFault | None:
    """INTERRUPT ON of a number that the project declares nowhere: in place of another, or as a new line."""
    x = site.statement
    if site.file.is_data or site.in_spline or not isinstance(x, (*STEPS, s.InterruptSwitch)):
        return None
    number = rng.choice([n for n in range(4, 40) if n not in _declared_numbers(site)])
    token = next((t for t in site.tokens if t.kind == "INTEGER"), None)
    if isinstance(x, s.InterruptSwitch):
        replace = x.mode == "ON" and token is not None
        return changed(site, site.replaced(token, str(number))) if replace and token is not None else None
    return inserted(site, f"INTERRUPT ON {number}")


def _declared_numbers(site: PlantSite) -> set[int]:
    found = (
        re.match(r"\s*(?:GLOBAL\s+)?INTERRUPT\s+(?:WITH\s+BRAKE\s+)?DECL\s+(\d+)", text, re.IGNORECASE)
        for of in site.of.project.files
        for text in texts_of(of.file)
    )
    return {int(m[1]) for m in found if m}


def forbidden_priority(site: PlantSite, rng: Random) -> PlantedFault | None:
    token = next((t for t in site.tokens if t.kind == "INTEGER"), None)
    if token is None or not isinstance(site.statement, s.InterruptDeclaration):
        return None
    if not isinstance(site.statement.priority, e.Integer):
        return None
    return changed(site, site.replaced(token, str(rng.choice([0, 129, 200, 255, rng.randrange(40, 81)]))))


def text_without_brackets(site: PlantSite, rng: Random) -> PlantedFault | None:
    """`T[] = "abc"` without `[]`, or a new line that gives a text to an array of CHAR of the routine or its `.dat`."""
    t = site.tokens
    kinds = [x.kind for x in t]
    if kinds[-4:] == ["_LSQB", "_RSQB", "_EQUALS", "STRING"] and len(t[-1].text) > 3:
        return changed(site, site.text[: t[-4].column - 1] + site.text[t[-2].column - 1 :])
    if not isinstance(site.statement, STEPS) or site.routine is None or site.in_spline:
        return None
    data = [texts_of(of.file) for of in site.module.files if of.file.is_data]
    seen = [*(line for lines in data for line in lines), *texts_of(site.file)[site.routine.first : site.at]]
    arrays = [m[1] for line in seen if (m := re.match(r"\s*(?:DECL\s+)?CHAR\s+(\w+)\s*\[\d+\]", line, re.IGNORECASE))]
    return inserted(site, f'{rng.choice(arrays)} = "ready"') if arrays else None


def constant_for_out(site: PlantSite, rng: Random) -> PlantedFault | None:
    """A constant of the right type in place of the variable that a subprogram writes."""
    t = site.tokens
    if not isinstance(site.statement, EXECUTABLE):
        return None
    places = []
    for i in range(len(t) - 1):
        if t[i].kind == "NAME" and t[i + 1].kind == "_LPAR":
            arguments, written = _arguments(t, i + 1), _written_by(site, t[i].text.upper())
            places += [(*arguments[k], constant) for k, constant in written.items() if k < len(arguments)]
    variables = [x for x in places if t[x[0]].kind == "NAME"]
    if not variables:
        return None
    first, last, constant = rng.choice(variables)
    end = t[last].column - 1 + len(t[last].text)
    return changed(site, site.text[: t[first].column - 1] + constant + site.text[end:])


def _written_by(site: PlantSite, name: str) -> dict[int, str]:
    """Which arguments of a subprogram are OUT and no arrays, with a constant of each type; of one defined once."""
    routines = [r for of in site.of.project.files for r in of.outline.routines if r.name == name]
    if not routines and name in _OF_OPTIONS:
        return {2: _CONSTANTS[_OF_OPTIONS[name]]}
    if len(routines) != 1:
        return {}
    lines = [x for _, x in routines[0].lines() if isinstance(x, Declaration) and x.type is not None]
    declared = {y.name.upper(): x.type.upper() for x in lines if x.type for y in x.names if y.sizes is None}
    types = {key: _CONSTANTS.get(kind, "") for key, kind in declared.items()}
    found = {
        i: types.get(p.name.upper(), "")
        for i, p in enumerate(routines[0].head.parameters)
        if p.mode == "OUT" and not p.dimensions
    }
    return {i: constant for i, constant in found.items() if constant}


def _arguments(t: tuple[Token, ...], at: int) -> list[tuple[int, int]]:
    """First and last token of each argument in the brackets that open at `at`; none if they do not close."""
    depth, begin, out = 0, at + 1, []
    for i in range(at, len(t)):
        depth += t[i].kind in ("_LPAR", "_LSQB", "BRACE")
        depth -= t[i].kind in ("_RPAR", "_RSQB", "_RBRACE")
        if depth == 0 or (depth == 1 and t[i].kind == "_COMMA"):
            out.append((begin, i - 1))
            begin = i + 1
        if depth == 0:
            return [(a, b) for a, b in out if a <= b]
    return []


_REALS = ("$VEL.CP", "$AXIS_ACT.A1", "$ACC.CP", "0.5")
_ASIDE = (s.Assign, s.Invoke, s.Wait)


def parameter_undeclared(site: PlantSite, rng: Random) -> PlantedFault | None:
    """The declaration of a parameter is gone; or a subprogram without parameters gets one."""
    x, routine = site.statement, site.routine
    if not isinstance(x, Def) or routine is None or next(routine.lines(), None) is None:
        return None
    lines = texts_of(site.file)
    if not x.parameters:
        lines[site.at] = site.text.replace("(", "(NEW_NUMBER :IN", 1)
        return told_at(site.file, lines, (site.file.name, site.at + 1))
    names = {p.name.upper() for p in x.parameters}
    own = [
        i for i, y in routine.lines()
        if isinstance(y, Declaration) and len(y.names) == 1 and y.names[0].name.upper() in names
    ]  # fmt: skip
    if not own:
        return None
    del lines[rng.choice(own)]
    return told_at(site.file, lines, (site.file.name, site.at + 1))


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
    return told_at(site.file, lines, (site.file.name, site.at + 3))


def output_in_spline(site: PlantSite, rng: Random) -> PlantedFault | None:
    return _in_spline(site, *[f"$OUT[{rng.randrange(1, 200)}] = TRUE"] * 2)


def pause_in_spline(site: PlantSite, rng: Random) -> PlantedFault | None:
    return _in_spline(site, *[rng.choice(["WAIT SEC 0.2", "WAIT FOR $IN[1]"])] * 2)


def motion_in_spline(site: PlantSite, rng: Random) -> PlantedFault | None:
    return _in_spline(site, "PTP {target}", "LIN {target}")


def switch_on_real(site: PlantSite, rng: Random) -> PlantedFault | None:
    x = site.statement
    if not isinstance(x, s.Condition) or x.keyword != "SWITCH":
        return None
    lines = texts_of(site.file)
    lines[site.at] = f"SWITCH {rng.choice(_REALS)}"
    return told_at(site.file, lines, (site.file.name, site.at + 1))


def before_first_case(site: PlantSite, rng: Random) -> PlantedFault | None:
    """A line of the same routine, copied below SWITCH."""
    x, routine = site.statement, site.routine
    if not isinstance(x, s.Condition) or x.keyword != "SWITCH" or routine is None:
        return None
    lines = texts_of(site.file)
    copied = [lines[i] for i, y in routine.lines() if isinstance(y, _ASIDE)]
    return inserted(site, rng.choice(copied or ["WAIT SEC 0.1"]))


def case_after_default(site: PlantSite, rng: Random) -> PlantedFault | None:
    routine = site.routine
    block = None if routine is None else routine.blocks.get(site.at)
    if block is None or block.kind != "SWITCH" or block.last != site.at:
        return None
    words = [keyword_of(site.file.lines[i].statement) for i in block.parts]
    if "DEFAULT" not in words or "CASE" not in words:
        return None
    lines = texts_of(site.file)
    lines[site.at : site.at] = [lines[block.parts[words.index("CASE")]], "HALT"]
    return told_at(site.file, lines, (site.file.name, site.at + 1))


def jump_into_loop(site: PlantSite, rng: Random) -> PlantedFault | None:
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
    return told_at(site.file, lines, (site.file.name, block.first + 1))


def global_twice(site: PlantSite, rng: Random) -> PlantedFault | None:
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


def global_variable_twice(site: PlantSite, rng: Random) -> PlantedFault | None:
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


REFUSED = tuple(
    kind_of(plant, codes)
    for codes, plants in {
        "system-name": (system_name_slip,), "parameter-type undeclared": (parameter_undeclared,),
        "read-only": (input_written, read_only_written, input_signal_written),
        "interrupt": (interrupt_undeclared, forbidden_priority), "global-twice": (global_twice, global_variable_twice),
        "in-spline": (output_in_spline, pause_in_spline, motion_in_spline), "switch type": (switch_on_real,),
        "switch": (before_first_case, case_after_default), "goto": (jump_into_loop,),
        "text-brackets": (text_without_brackets,), "arguments": (constant_for_out,),
    }.items()
    for plant in plants
)  # fmt: skip
