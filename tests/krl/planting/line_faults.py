"""Faults in the words of one line: misspelt, left out, or of the wrong kind."""

from __future__ import annotations

import random

from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.lexer import Token
from tests.krl.planting.site import PlantedFault, PlantSite, changed

_TAKEN = {
    1: "SIN COS TAN ACOS SQRT ABS INV_POS STRLEN STRCLEAR STRDECLLEN EKI_INIT EKI_OPEN EKI_CLOSE EKI_CLEAR",
    2: "ATAN2 BAS STRADD STRCOPY EKI_CHECKBUFFER",
    3: "EKI_GETINT EKI_GETREAL EKI_GETBOOL EKI_GETSTRING EKI_SETINT EKI_SETREAL STRCOMP PULSE INVERSE",
}
_OPEN, _CLOSE = ("_LPAR", "_LSQB", "BRACE"), ("_RPAR", "_RSQB", "_RBRACE")
EXECUTABLE = (s.Assign, s.Invoke, s.Move, s.Wait, s.Condition, s.For, s.Return, s.CaseBranch)


def _one(site: PlantSite, rng: random.Random, tokens: list[Token]) -> Token | None:
    return rng.choice(tokens) if tokens and isinstance(site.statement, EXECUTABLE) else None


def _kinds(site: PlantSite, i: int) -> tuple[str, str]:
    """The kinds of the tokens before and after token `i`."""
    t = site.tokens
    return (t[i - 1].kind if i else ""), (t[i + 1].kind if i + 1 < len(t) else "")


def _misspelt(site: PlantSite, rng: random.Random, tokens: list[Token], skip: int = 0) -> PlantedFault | None:
    token = _one(site, rng, tokens)
    word = None if token is None else site.typo(token.text[skip:], rng)
    return None if token is None or word is None else changed(site, site.replaced(token, token.text[:skip] + word))


def variable_misspelt(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    if "{" in site.text:
        return None
    names = [
        t for i, t in enumerate(site.tokens)
        if t.kind == "NAME" and not t.text.startswith("$") and len(t.text) > 2
        and _kinds(site, i)[0] != "_DOT" and _kinds(site, i)[1] != "_LPAR"
    ]  # fmt: skip
    return _misspelt(site, rng, names)


def subprogram_misspelt(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    calls = [t for i, t in enumerate(site.tokens) if t.kind == "NAME" and _kinds(site, i)[1] == "_LPAR"]
    return _misspelt(site, rng, [t for t in calls if len(t.text) > 2])


def keyword_misspelt(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    first = [t for t in site.tokens[:1] if t.kind != "NAME" and t.text.isalpha()]
    return _misspelt(site, rng, first)


def component_misspelt(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    return _misspelt(site, rng, [t for i, t in enumerate(site.tokens) if _kinds(site, i)[0] == "_DOT"])


def constant_misspelt(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    return _misspelt(site, rng, [t for t in site.tokens if t.kind == "ENUMERATION" and len(t.text) > 3], skip=1)


def bracket_lost(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    token = _one(site, rng, [t for t in site.tokens if t.kind in ("_RPAR", "_RSQB", "_RBRACE")])
    return None if token is None else changed(site, site.replaced(token, ""))


def string_open(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    token = _one(site, rng, [t for t in site.tokens if t.kind == "STRING"][-1:])
    if token is None or '"' in site.text[token.column - 1 + len(token.text) :]:
        return None
    return changed(site, site.replaced(token, token.text[:-1]))


def _without(site: PlantSite, word: str) -> PlantedFault | None:
    token = next((t for t in site.tokens if t.text.upper() == word), None)
    return None if token is None else changed(site, site.replaced(token, ""))


def then_lost(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    x = site.statement
    return _without(site, "THEN") if isinstance(x, s.Condition) and x.keyword == "IF" else None


def sec_lost(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    x = site.statement
    return _without(site, "SEC") if isinstance(x, s.Wait) and x.kind == "SEC" else None


def assigned_for_compared(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    compared = [t for t in site.tokens if t.text == "=="]
    token = _one(site, rng, compared) if isinstance(site.statement, s.Condition | s.Wait) else None
    return None if token is None else changed(site, site.replaced(token, "="))


def truth_to_number(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    x = site.statement
    value = x.value if isinstance(x, s.Assign) else None
    while isinstance(value, e.Unary):
        value = value.operand
    token = next((t for t in site.tokens if t.kind == "_EQUALS"), None)
    if not isinstance(value, e.Integer | e.Real) or token is None:
        return None
    last = site.tokens[-1]
    end = last.column - 1 + len(last.text)
    return changed(site, f"{site.text[: token.column]} TRUE{site.text[end:]}")


def joint_blend_on_line(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    x = site.statement
    if not isinstance(x, s.Move) or x.kind not in ("LIN", "LIN_REL") or x.blends or x.settings:
        return None
    last = site.tokens[-1]
    return changed(site, site.replaced(last, f"{last.text} C_PTP"))


def decimal_comma(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    numbers = [t for t in site.tokens if t.kind == "DECIMAL" and t.text.replace(".", "").isdigit()]
    token = _one(site, rng, [t for t in numbers if not t.text.startswith(".") and not t.text.endswith(".")])
    return None if token is None else changed(site, site.replaced(token, token.text.replace(".", ",")))


def foreign_letter(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    token = _one(site, rng, [t for t in site.tokens if t.kind == "NAME" and len(t.text) > 2])
    if token is None:
        return None
    k = rng.randrange(1, len(token.text))
    return changed(site, site.replaced(token, token.text[:k] + rng.choice("äöüßéñ") + token.text[k + 1 :]))


def one_argument_more(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    """In a call that has all arguments its subprogram takes; an optional one would be no fault."""
    t = site.tokens
    calls = [i for i, x in enumerate(t) if x.kind == "NAME" and _kinds(site, i)[1] == "_LPAR"]
    calls = [i for i in calls if _taken(site, t[i].text) == _given(t, i + 1)[0]]
    if not calls or not isinstance(site.statement, EXECUTABLE):
        return None
    count, end = _given(t, rng.choice(calls) + 1)
    return changed(site, site.replaced(t[end], ", 1)" if count else "1)"))


def _taken(site: PlantSite, name: str) -> int:
    key = name.upper()
    return site.of.arguments.get(key, next((n for n, names in _TAKEN.items() if key in names.split()), -1))


def _given(t: tuple[Token, ...], at: int) -> tuple[int, int]:
    """How many arguments the brackets that open at `at` hold, and where they close; -2 if they do not."""
    depth, count = 0, 0
    for i in range(at, len(t)):
        depth += (t[i].kind in _OPEN) - (t[i].kind in _CLOSE)
        count += t[i].kind == "_COMMA" and depth == 1
        if depth == 0:
            return count + (i > at + 1), i
    return -2, -1


def operand_lost(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    operators = ("PLUSMINUS", "TIMES", "AND", "OR", "EXOR", "COMPARE")
    operands, ends = ("NAME", "INTEGER", "DECIMAL", "TRUTH"), ("", "_RPAR", "_RSQB", "THEN")
    found = [
        t for i, t in enumerate(site.tokens)
        if t.kind in operands and _kinds(site, i)[0] in operators and _kinds(site, i)[1] in ends
    ]  # fmt: skip
    token = _one(site, rng, found)
    return None if token is None else changed(site, site.replaced(token, ""))
