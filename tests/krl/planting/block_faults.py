"""Faults of whole lines: declarations, labels, ends of blocks."""

from __future__ import annotations

import random
import re

from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.declarations import Declaration
from tests.krl.planting.site import PlantedFault, PlantSite, changed, inserted, texts_of, words_of

_ENDS = ("ENDIF", "ENDFOR", "ENDWHILE", "ENDLOOP", "ENDSWITCH")
_STEPS = (s.Assign, s.Invoke, s.Move, s.Wait)


def declared_twice(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    if not isinstance(site.statement, Declaration):
        return None
    fault = inserted(site, site.text)
    return PlantedFault(fault.file, fault.lines, fault.places | {(fault.file, site.at + 1)})


def late_declaration(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    return inserted(site, "INT NEW_COUNTER") if isinstance(site.statement, _STEPS) and not site.file.is_data else None


def jump_to_nowhere(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    return (
        inserted(site, "GOTO NO_SUCH_PLACE") if isinstance(site.statement, _STEPS) and not site.file.is_data else None
    )


def _opener(site: PlantSite) -> int | None:
    """The line (from 1) that opens the block which the line of the site closes."""
    for of in site.module.files:
        for routine in of.outline.routines:
            block = routine.blocks.get(site.at)
            if of.file is site.file and block is not None and block.last == site.at:
                return block.first + 1
    return None


def wrong_end(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    x, opener = site.statement, _opener(site)
    if not isinstance(x, s.Plain) or x.keyword not in _ENDS or opener is None:
        return None
    new = rng.choice([end for end in _ENDS if end != x.keyword])
    return changed(site, site.replaced(site.tokens[0], new), opener)


def end_lost(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    """The ENDIF is gone: it must be told where its IF stands."""
    x, opener = site.statement, _opener(site)
    if not isinstance(x, s.Plain) or x.keyword != "ENDIF" or opener is None:
        return None
    lines = texts_of(site.file)
    del lines[site.at]
    return PlantedFault(site.file.name, tuple(lines), frozenset({(site.file.name, opener)}))


def declaration_lost(site: PlantSite, rng: random.Random) -> PlantedFault | None:
    """A declaration of the `.dat` is gone: it must be told where the `.src` uses the name first."""
    x, source = site.statement, site.module.source
    if not isinstance(x, Declaration) or not site.file.is_data or source is None or len(x.names) > 1:
        return None
    name = x.names[0].name.upper()
    if _declared_elsewhere(site, name):
        return None
    for i, text in enumerate(texts_of(source.file)):
        if any(t.kind == "NAME" and t.text.upper() == name for t in words_of(text)):
            lines = texts_of(site.file)
            del lines[site.at]
            return PlantedFault(site.file.name, tuple(lines), frozenset({(source.file.name, i + 1)}))
    return None


def _declared_elsewhere(site: PlantSite, name: str) -> bool:
    """Whether another line of the project declares the name: GLOBAL, in the controller's files, or in the `.src`."""
    pattern = re.compile(
        rf"(DECL|GLOBAL|INT|REAL|BOOL|CHAR|SIGNAL)\b.*(?<![\w$]){re.escape(name)}(?![\w$])", re.IGNORECASE
    )
    return any(
        pattern.search(text.split(";")[0])
        for of in site.of.project.files
        for i, text in enumerate(texts_of(of.file))
        if name in text.upper() and (of.file is not site.file or i != site.at)
    )
