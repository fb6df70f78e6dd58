"""Slips of any language: words misspelt or left out, numbers out of bounds, lines lost or doubled."""

from __future__ import annotations

import re
from collections.abc import Callable
from random import Random

from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.declarations import Declaration, StructType
from lwr_dyn.krl.language.lexer import Token
from tests.krl.planting.site import (
    EXECUTABLE,
    STEPS,
    FaultKind,
    PlantedFault,
    PlantSite,
    changed,
    inserted,
    kind_of,
    told_at,
    words_of,
)  # fmt: skip

Plant = Callable[[PlantSite, Random], PlantedFault | None]
Select = Callable[[PlantSite], list[Token]]

_TAKEN = {
    1: "SIN COS TAN ACOS SQRT ABS INV_POS STRLEN STRCLEAR STRDECLLEN EKI_INIT EKI_OPEN EKI_CLOSE EKI_CLEAR",
    2: "ATAN2 BAS STRADD STRCOPY EKI_CHECKBUFFER",
    3: "EKI_GETINT EKI_GETREAL EKI_GETBOOL EKI_GETSTRING EKI_SETINT EKI_SETREAL STRCOMP PULSE INVERSE",
}
_OPEN, _CLOSE = ("_LPAR", "_LSQB", "BRACE"), ("_RPAR", "_RSQB", "_RBRACE")
_SIGNALS = frozenset({"$IN", "$OUT", "$FLAG", "$CYCFLAG", "$TIMER", "$TIMER_STOP", "$ANIN", "$ANOUT"})
_PERCENTS = frozenset({"$VEL_AXIS", "$ACC_AXIS", "$OV_PRO"})
_ENDS = ("ENDIF", "ENDFOR", "ENDWHILE", "ENDLOOP", "ENDSWITCH")
KINDS: list[FaultKind] = []


def kind(codes: str) -> Callable[[Plant], object]:
    """The function plants a kind of fault, which these codes name rightly."""
    return lambda plant: KINDS.append(kind_of(plant, codes))


def word(name: str, codes: str, select: Select, new: Callable[[PlantSite, Token, Random], str | None]) -> None:
    """A kind that changes one of the words that `select` gives to what `new` says."""

    def plant(site: PlantSite, rng: Random) -> PlantedFault | None:
        tokens = select(site)
        token = rng.choice(tokens) if tokens and isinstance(site.statement, EXECUTABLE) else None
        text = None if token is None else new(site, token, rng)
        return None if token is None or text is None else changed(site, site.replaced(token, text))

    KINDS.append(kind_of(plant, codes, name))


def _between(site: PlantSite) -> list[tuple[str, Token, str]]:
    """The words of a line, with the kinds of those before and after each."""
    kinds = ["", *(x.kind for x in site.tokens), ""]
    return list(zip(kinds, site.tokens, kinds[2:], strict=False))


def _of(kind: str, site: PlantSite) -> list[Token]:
    return [t for t in site.tokens if t.kind == kind]


def _variables(site: PlantSite) -> list[Token]:
    named = [] if "{" in site.text else [t for a, t, b in _between(site) if a != "_DOT" and b != "_LPAR"]
    return [t for t in named if t.kind == "NAME" and not t.text.startswith("$") and len(t.text) > 2]


def _calls(site: PlantSite) -> list[Token]:
    return [t for _, t, b in _between(site) if t.kind == "NAME" and b == "_LPAR" and len(t.text) > 2]


def _decimals(site: PlantSite) -> list[Token]:
    numbers = [t for t in site.tokens if t.kind == "DECIMAL" and t.text.replace(".", "").isdigit()]
    return [t for t in numbers if not t.text.startswith(".") and not t.text.endswith(".")]


def _operands(site: PlantSite) -> list[Token]:
    operators = ("PLUSMINUS", "TIMES", "AND", "OR", "EXOR", "COMPARE")
    operands, ends = ("NAME", "INTEGER", "DECIMAL", "TRUTH"), ("", "_RPAR", "_RSQB", "THEN")
    return [t for a, t, b in _between(site) if t.kind in operands and a in operators and b in ends]


def _typo(site: PlantSite, token: Token, rng: Random) -> str | None:
    return site.typo(token.text, rng)


def _typo_after_sign(site: PlantSite, token: Token, rng: Random) -> str | None:
    slip = site.typo(token.text[1:], rng)
    return None if slip is None else token.text[:1] + slip


def _unclosed(site: PlantSite, token: Token, _: Random) -> str | None:
    return None if '"' in site.text[token.column - 1 + len(token.text) :] else token.text[:-1]


def _with_foreign_letter(_: PlantSite, token: Token, rng: Random) -> str:
    k = rng.randrange(1, len(token.text))
    return token.text[:k] + rng.choice("äöüßéñ") + token.text[k + 1 :]


def _compared(site: PlantSite) -> list[Token]:
    return [t for t in site.tokens if t.text == "=="] if isinstance(site.statement, s.Condition | s.Wait) else []


word("variable misspelt", "undeclared", _variables, _typo)
word("subprogram misspelt", "unknown-call undeclared", _calls, _typo)
# PTP misspelt reads as a declaration: "PPT P1: neither a statement nor a type"
word("keyword misspelt", "unknown-keyword syntax unknown-type",
     lambda site: [t for t in site.tokens[:1] if t.kind != "NAME" and t.text.isalpha()], _typo)  # fmt: skip
word("component misspelt", "no-component", lambda site: [t for a, t, _ in _between(site) if a == "_DOT"], _typo)
word("constant misspelt", "no-constant", lambda site: [t for t in _of("ENUMERATION", site) if len(t.text) > 3],
     _typo_after_sign)  # fmt: skip
word("bracket lost", "open-bracket syntax", lambda site: [t for t in site.tokens if t.kind in _CLOSE], lambda *_: "")
word("string open", "open-string", lambda site: _of("STRING", site)[-1:], _unclosed)
word("assigned for compared", "syntax", _compared, lambda *_: "=")
# in a call or between square brackets a comma makes two of one
word("decimal comma", "syntax arguments no-array", _decimals, lambda _, t, __: t.text.replace(".", ","))
word("foreign letter", "bad-character", lambda site: [t for t in _of("NAME", site) if len(t.text) > 2],
     _with_foreign_letter)  # fmt: skip
word("operand lost", "syntax open-bracket", _operands, lambda *_: "")


def _without(site: PlantSite, word: str) -> PlantedFault | None:
    token = next((t for t in site.tokens if t.text.upper() == word), None)
    return None if token is None else changed(site, site.replaced(token, ""))


@kind("syntax")
def then_lost(site: PlantSite, _: Random) -> PlantedFault | None:
    x = site.statement
    return _without(site, "THEN") if isinstance(x, s.Condition) and x.keyword == "IF" else None


@kind("syntax")
def sec_lost(site: PlantSite, _: Random) -> PlantedFault | None:
    x = site.statement
    return _without(site, "SEC") if isinstance(x, s.Wait) and x.kind == "SEC" else None


@kind("type")
def truth_to_number(site: PlantSite, _: Random) -> PlantedFault | None:
    value = site.statement.value if isinstance(site.statement, s.Assign) else None
    while isinstance(value, e.Unary):
        value = value.operand
    token = next((t for t in site.tokens if t.kind == "_EQUALS"), None)
    if not isinstance(value, e.Integer | e.Real) or token is None:
        return None
    return changed(site, f"{site.text[: token.column]} TRUE{site.text[site.end :]}")


@kind("blend")
def joint_blend_on_line(site: PlantSite, _: Random) -> PlantedFault | None:
    x = site.statement
    if not isinstance(x, s.Move) or x.kind not in ("LIN", "LIN_REL") or x.blends or x.settings:
        return None
    return changed(site, site.replaced(site.tokens[-1], f"{site.tokens[-1].text} C_PTP"))


@kind("arguments")
def one_argument_more(site: PlantSite, rng: Random) -> PlantedFault | None:
    """In a call that has all arguments its subprogram takes; an optional one would be no fault."""
    t = site.tokens
    calls = [i for i, x in enumerate(t[:-1]) if x.kind == "NAME" and t[i + 1].kind == "_LPAR"]
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


def _indices(site: PlantSite) -> list[tuple[Token, Token]]:
    """Each `NAME[number]`: the tokens of the name and of the number; no component."""
    t = site.tokens
    return [
        (t[i], t[i + 2]) for i in range(len(t) - 3)
        if [x.kind for x in t[i : i + 4]] == ["NAME", "_LSQB", "INTEGER", "_RSQB"]
        and (i == 0 or t[i - 1].kind != "_DOT")
    ]  # fmt: skip


@kind("index-range")
def index_past_array(site: PlantSite, rng: Random) -> PlantedFault | None:
    sizes = site.of.sizes
    known = [(name, i) for name, i in _indices(site) if sizes.get(name.text.upper()) and _is_code(site)]
    if not known:
        return None
    name, index = rng.choice(known)
    return changed(site, site.replaced(index, str(sizes[name.text.upper()] + rng.randint(1, 3))))


@kind("index-range")
def signal_zero(site: PlantSite, rng: Random) -> PlantedFault | None:
    known = [i for name, i in _indices(site) if name.text.upper() in _SIGNALS and _is_code(site)]
    return changed(site, site.replaced(rng.choice(known), "0")) if known else None


def _is_code(site: PlantSite) -> bool:
    return not isinstance(site.statement, Declaration | StructType)


@kind("speed-unit")
def speed_in_millimetres(site: PlantSite, _: Random) -> PlantedFault | None:
    token = _after(site, "$VEL.CP=", "BAS(#VEL_CP,", "LDAT")
    if token is None or not 0.004 <= float(token.text) <= 3.0:
        return None
    return changed(site, site.replaced(token, f"{1e3 * float(token.text):g}"))


@kind("percent-range")
def over_hundred(site: PlantSite, _: Random) -> PlantedFault | None:
    token, x = _after(site, "BAS(#VEL_PTP,", "BAS(#ACC_PTP,", "BAS(#PTP_PARAMS,"), site.statement
    named = [name for name, _ in _indices(site)] or list(site.tokens[:1])
    number = isinstance(x, s.Assign) and isinstance(x.value, e.Integer | e.Real)
    if token is None and number and named[0].text.upper() in _PERCENTS:
        token = site.tokens[-1]
    if token is None or token.kind not in ("INTEGER", "DECIMAL") or float(token.text) > 100.0:
        return None
    return changed(site, site.replaced(token, "150"))


def _after(site: PlantSite, *begins: str) -> Token | None:
    """The number after one of these beginnings of a statement, or after VEL in a structure LDAT."""
    t = site.tokens
    for i in (i for i, x in enumerate(t) if x.kind in ("INTEGER", "DECIMAL")):
        text = "".join(x.text for x in t[:i]).upper()
        if text in begins or (text.endswith("{VEL") and "LDAT" in begins and text.startswith(("DECLLDAT", "LDAT"))):
            return t[i]
    return None


@kind("duplicate-name")
def declared_twice(site: PlantSite, _: Random) -> PlantedFault | None:
    if not isinstance(site.statement, Declaration):
        return None
    fault = inserted(site, site.text)
    return PlantedFault(fault.file, fault.lines, fault.places | {(fault.file, site.at + 1)})


@kind("late-declaration")
def late_declaration(site: PlantSite, _: Random) -> PlantedFault | None:
    return inserted(site, "INT NEW_COUNTER") if isinstance(site.statement, STEPS) and not site.file.is_data else None


@kind("undeclared")
def jump_to_nowhere(site: PlantSite, _: Random) -> PlantedFault | None:
    return inserted(site, "GOTO NO_SUCH_PLACE") if isinstance(site.statement, STEPS) and not site.file.is_data else None


def _opener(site: PlantSite, ends: tuple[str, ...]) -> int | None:
    """The line (from 1) that opens the block which the line of the site closes by one of such words."""
    x, block = site.statement, None if site.routine is None else site.routine.blocks.get(site.at)
    closes = isinstance(x, s.Plain) and x.keyword in ends and block is not None and block.last == site.at
    return block.first + 1 if closes and block is not None else None


@kind("stray-end missing-end")
def wrong_end(site: PlantSite, rng: Random) -> PlantedFault | None:
    opener = _opener(site, _ENDS)
    if opener is None:
        return None
    new = rng.choice([end for end in _ENDS if end != site.tokens[0].text.upper()])
    return changed(site, site.replaced(site.tokens[0], new), opener)


@kind("missing-end")
def end_lost(site: PlantSite, _: Random) -> PlantedFault | None:
    """The ENDIF is gone: it must be told where its IF stands."""
    opener = _opener(site, ("ENDIF",))
    return None if opener is None else told_at(site.file, site.without_line(), (site.file.name, opener))


@kind("undeclared")
def declaration_lost(site: PlantSite, _: Random) -> PlantedFault | None:
    """A declaration of the `.dat` is gone: it must be told where the `.src` uses the name first."""
    x, source = site.statement, site.module.source
    if not isinstance(x, Declaration) or not site.file.is_data or source is None or len(x.names) > 1:
        return None
    name = x.names[0].name.upper()
    if _declared_elsewhere(site, name):
        return None
    for i, line in enumerate(source.file.lines):
        if any(t.kind == "NAME" and t.text.upper() == name for t in words_of(line.layout or "")):
            return told_at(site.file, site.without_line(), (source.file.name, i + 1))
    return None


def _declared_elsewhere(site: PlantSite, name: str) -> bool:
    """Whether another line of the project declares the name: GLOBAL, in the controller's files, or in the `.src`."""
    types = "DECL|GLOBAL|INT|REAL|BOOL|CHAR|SIGNAL"
    pattern = re.compile(rf"({types})\b.*(?<![\w$]){re.escape(name)}(?![\w$])", re.IGNORECASE)
    return any(
        pattern.search((line.layout or "").split(";")[0])
        for of in site.of.project.files
        for i, line in enumerate(of.file.lines)
        if name in (line.layout or "").upper() and (of.file is not site.file or i != site.at)
    )
