"""Closed forms of entries of B, C and g for the page: short ones of the package's robots, and the command for others.

`closed_forms.toml` holds them; scripts/closed_forms.py writes it with `dynamics.symbolic.entry_text`, and a test puts
numbers for their letters.
"""

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from lwr_dyn.arms.papers.catalog import open_paper, robots
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.model.arm import Arm

_LETTER = re.compile(r"\b[A-Za-z]+\d+[xyz]*\b")
_AXES = "xyz"


def closed_forms(arm: Arm) -> dict[str, Any]:
    """`texts` by entry such as "B_23", `values` of their letters, and `command`, which prints an entry; "" has none.

    Letters are those of `dynamics.symbolic.arm_equations`: m, c and I of a link in its DH frame, I about its centre.
    """
    if arm.chain.bodies is None or arm.loaded_with or arm.installation is not None:
        return {"texts": {}, "values": {}, "command": ""}
    asked = [arm.file or arm.name, "ENTRY", *([arm.reading] if _has_readings(arm) else [])]
    command = f'python -c "from lwr_dyn.dynamics.symbolic.entry_text import entry_text as e; print(e{tuple(asked)!r})"'
    found = _read().get(arm.name, {}) if not arm.file and arm.name in robots() else {}
    found = found if arm.reading in found.get("readings", ()) else {}
    texts = found.get("texts", {})
    known = letter_values(arm) | length_values(arm, found.get("lengths", {}))
    letters = {letter for text in texts.values() for letter in _LETTER.findall(text)}
    values = {letter: float(f"{known[letter]:.6g}") for letter in sorted(letters & known.keys())}
    return {"texts": texts, "values": values, "command": command}


def _has_readings(arm: Arm) -> bool:
    return not arm.file or (ends_in(arm.file, ".toml") and not ends_in(arm.file, ".kuka.toml"))


def letter_values(arm: Arm) -> dict[str, float]:
    """Numbers of the letters of bodies, rotors and gravity along one axis."""
    values = {"g0": float(abs(arm.chain.gravity).max())}
    for k, link in enumerate(arm.chain.links, start=1):
        values |= {} if link.rotor is None else {f"Ia{k}": link.rotor.armature}
        if link.body is None:
            continue
        values |= {f"m{k}": link.body.mass}
        for i, a in enumerate(_AXES):
            values[f"c{k}{a}"] = float(link.body.com[i])
            values |= {f"I{k}{a}{b}": float(link.body.inertia_com[i, j]) for j, b in enumerate(_AXES) if j >= i}
    return values


def length_values(arm: Arm, places: Mapping[str, str]) -> dict[str, float]:
    """Numbers of letters [m] that stand for a column and row (from 1) of the arm's paper, such as "dh.d 7"."""
    columns = open_paper(arm.name, arm.reading).columns if places else {}
    split = {letter: place.split() for letter, place in places.items()}
    return {letter: float(columns[column].si()[int(row) - 1]) for letter, (column, row) in split.items()}


@cache
def _read() -> dict[str, Any]:
    return tomllib.loads(files("lwr_dyn.pages.explorer").joinpath("closed_forms.toml").read_text(encoding="utf-8"))
