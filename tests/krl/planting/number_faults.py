"""Faults in numbers: an index outside of its array, a speed in mm/s, more than 100 per cent."""

from __future__ import annotations

import random

from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.declarations import Declaration, StructType
from lwr_dyn.krl.language.lexer import Token
from tests.krl.planting.site import PlantedFault, PlantSite, changed

_SIGNALS = frozenset({"$IN", "$OUT", "$FLAG", "$CYCFLAG", "$TIMER", "$TIMER_STOP", "$ANIN", "$ANOUT"})
_PERCENTS = frozenset({"$VEL_AXIS", "$ACC_AXIS", "$OV_PRO"})


def _indices(site: PlantSite) -> list[tuple[Token, Token]]:
    """Each `NAME[number]`: the tokens of the name and of the number; no component."""
    t = site.tokens
    return [
        (t[i], t[i + 2]) for i in range(len(t) - 3)
        if t[i].kind == "NAME" and t[i + 1].kind == "_LSQB" and t[i + 2].kind == "INTEGER"
        and t[i + 3].kind == "_RSQB" and (i == 0 or t[i - 1].kind != "_DOT")
    ]  # fmt: skip


def _code(site: PlantSite) -> bool:
    return not isinstance(site.statement, Declaration | StructType)


def index_past_array(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    known = [(name, i) for name, i in _indices(site) if site.of.sizes.get(name.text.upper()) and _code(site)]
    if not known:
        return None
    name, index = rng.choice(known)
    return changed(site, site.replaced(index, str(site.of.sizes[name.text.upper()] + rng.randint(1, 3))))


def signal_zero(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    known = [i for name, i in _indices(site) if name.text.upper() in _SIGNALS and _code(site)]
    return changed(site, site.replaced(rng.choice(known), "0")) if known else None


def speed_in_millimetres(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    token = _after(site, "$VEL.CP=", "BAS(#VEL_CP,", "LDAT")
    if token is None or not 0.004 <= float(token.text) <= 3.0:
        return None
    return changed(site, site.replaced(token, f"{1e3 * float(token.text):g}"))


def over_hundred(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    token = _after(site, "BAS(#VEL_PTP,", "BAS(#ACC_PTP,", "BAS(#PTP_PARAMS,")
    named = [name for name, _ in _indices(site)] or list(site.tokens[:1])
    x = site.statement
    if (
        token is None
        and isinstance(x, s.Assign)
        and isinstance(x.value, e.Integer | e.Real)
        and named[0].text.upper() in _PERCENTS
    ):
        token = site.tokens[-1]
    if token is None or token.kind not in ("INTEGER", "DECIMAL") or float(token.text) > 100.0:
        return None
    return changed(site, site.replaced(token, "150"))


def _after(site: PlantSite, *begins: str) -> Token | None:
    """The number after one of these beginnings of a statement, or after VEL in a structure LDAT."""
    t = site.tokens
    numbers = [i for i, x in enumerate(t) if x.kind in ("INTEGER", "DECIMAL")]
    for i in numbers:
        text = "".join(x.text for x in t[:i]).upper()
        if text in begins or (text.endswith("{VEL") and "LDAT" in begins and text.startswith(("DECLLDAT", "LDAT"))):
            return t[i]
    return None
