"""Faults of one line that the pendant refuses: names of the controller, what is only read, interrupts, texts, OUT."""

from __future__ import annotations

import random
import re

from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.declarations import Declaration
from lwr_dyn.krl.language.lexer import Token
from lwr_dyn.krl.names.known_names import known_names
from tests.krl.planting.line_faults import EXECUTABLE
from tests.krl.planting.site import PlantedFault, PlantSite, changed, inserted, texts_of

_READ_ONLY = (
    ("$POS_ACT", "{X 0,Y 0,Z 0,A 0,B 0,C 0}"), ("$AXIS_ACT", "{A1 0,A2 0,A3 0,A4 0,A5 0,A6 0}"), ("$ROBRUNTIME", "0"),
    ("$PERI_RDY", "TRUE"), ("$STOPMESS", "FALSE"), ("$MODE_OP", "#EX"), ("$VEL_ACT", "0.1"), ("$ON_PATH", "TRUE"),
)  # fmt: skip
_OF_OPTIONS = {"EKI_GETINT": "INT", "EKI_GETREAL": "REAL", "EKI_GETBOOL": "BOOL", "EKI_GETFRAME": "FRAME"}
"""Functions of an option that write their third argument, with its type."""
_CONSTANTS = {"INT": "7", "REAL": "2.5", "BOOL": "TRUE", "FRAME": "{X 0,Y 0,Z 0,A 0,B 0,C 0}"}
_STEPS = (s.Assign, s.Invoke, s.Move, s.Wait)


def system_name_slip(site: PlantSite, rng: random.Random) -> PlantedFault | None:
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


def input_written(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    token = _output(site)
    if token is None:
        return None
    return changed(site, site.replaced(token, {"$OUT": "$IN", "$ANOUT": "$ANIN"}[token.text.upper()]))


def input_signal_written(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    """A SIGNAL on an input, written in place of an output."""
    token, routine, x = _output(site), site.routine, site.statement
    if token is None or routine is None or token.text.upper() != "$OUT" or not isinstance(x, s.Assign):
        return None
    lines = texts_of(site.file)
    value = site.text[site.text.index("=") :]
    lines[site.at] = f"NEW_SENSOR {value}"
    lines.insert(routine.first, f"SIGNAL NEW_SENSOR $IN[{rng.randrange(1, 400)}]")
    return PlantedFault(site.file.name, tuple(lines), frozenset({(site.file.name, site.at + 2)}))


def read_only_written(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    if not isinstance(site.statement, _STEPS) or site.file.is_data or site.in_spline:
        return None
    name, value = rng.choice(_READ_ONLY)
    return inserted(site, f"{name} = {value}")


def interrupt_undeclared(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    """INTERRUPT ON of a number that the project declares nowhere: in place of another, or as a new line."""
    x = site.statement
    if site.file.is_data or site.in_spline or not isinstance(x, (*_STEPS, s.InterruptSwitch)):
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


def forbidden_priority(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    token = next((t for t in site.tokens if t.kind == "INTEGER"), None)
    if token is None or not isinstance(site.statement, s.InterruptDeclaration):
        return None
    if not isinstance(site.statement.priority, e.Integer):
        return None
    return changed(site, site.replaced(token, str(rng.choice([0, 129, 200, 255, rng.randrange(40, 81)]))))


def text_without_brackets(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    """`T[] = "abc"` without `[]`, or a new line that gives a text to an array of CHAR of the routine or its `.dat`."""
    t = site.tokens
    kinds = [x.kind for x in t]
    if kinds[-4:] == ["_LSQB", "_RSQB", "_EQUALS", "STRING"] and len(t[-1].text) > 3:
        return changed(site, site.text[: t[-4].column - 1] + site.text[t[-2].column - 1 :])
    if not isinstance(site.statement, _STEPS) or site.routine is None or site.in_spline:
        return None
    data = [texts_of(of.file) for of in site.module.files if of.file.is_data]
    seen = [*(line for lines in data for line in lines), *texts_of(site.file)[site.routine.first : site.at]]
    arrays = [m[1] for line in seen if (m := re.match(r"\s*(?:DECL\s+)?CHAR\s+(\w+)\s*\[\d+\]", line, re.IGNORECASE))]
    return inserted(site, f'{rng.choice(arrays)} = "ready"') if arrays else None


def constant_for_out(site: PlantSite, rng: random.Random) -> PlantedFault | None:
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
