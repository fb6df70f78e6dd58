"""Write closed_forms.toml of pages.explorer: closed forms of entries of B, C and g that fit on the page.

python scripts/closed_forms.py lwr4plus kr30ha wam7        # half an hour; entries of the other robots stay
"""

import argparse
import json
import signal
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.arms.papers.catalog import readings
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.dynamics.symbolic.equation_forms import SymbolicEntries, named_entries, symbolic_entries
from lwr_dyn.dynamics.symbolic.link_motion import SymbolicLink, length_letters
from lwr_dyn.foundation.files import write_file
from lwr_dyn.model.chain import Chain

TARGET = Path(__file__).parents[1] / "lwr_dyn" / "pages" / "explorer" / "closed_forms.toml"
LONGEST = 260
"""[characters]"""
PATIENCE = 60
"""[s] for one entry."""
LAST = 4
"""Joints from the flange whose entries are tried, with g_1; of C the diagonal."""


def short_texts(robot: str) -> dict[str, Any]:
    """The texts of a robot, its readings that have them, and where its paper has their lengths: column and row."""
    chain, paper = _model(robot)
    entries, texts = symbolic_entries(chain, paper), {}
    for name, (letter, i, j) in named_entries(chain.n).items():
        if (letter, i) != ("g", 0) and (i < chain.n - LAST or (letter == "C" and i != j) or (letter == "B" and i > j)):
            continue
        signal.alarm(PATIENCE)
        try:
            text = entries.text(letter, i, j)
        except TimeoutError:
            continue
        finally:
            signal.alarm(0)
        if len(text) <= LONGEST:
            texts[name] = text
            print(f"{robot} {name} = {text}", flush=True)
    lengths = {
        letter.name: f"dh.{x} {row + 1}"
        for x, letters in length_letters(paper).items()
        for row, letter in enumerate(letters)
        if letter != 0
    }
    return {"readings": _alike(robot, entries), "lengths": lengths, "texts": texts}


def _alike(robot: str, entries: SymbolicEntries) -> list[str]:
    """Readings whose links are the same but for the numbers of their letters."""

    def matrices(links: Sequence[SymbolicLink]) -> list[Any]:
        bodies = [link.body for link in links if link.body is not None]
        return [*(link.pose for link in links), *((body.com, body.inertia_com) for body in bodies)]

    own = matrices(entries.links)
    return [name for name in readings(robot) if matrices(symbolic_entries(*_model(robot, name)).links) == own]


def _model(robot: str, reading: str | None = None) -> tuple[Chain, Paper]:
    arm, paper = load_with_paper(robot, reading)
    assert paper is not None  # a robot of the package
    return arm.require_dynamics(), paper


def written(found: dict[str, Any]) -> str:
    """The file's text."""
    lines = ["# Closed forms of entries of B, C and g; made by scripts/closed_forms.py."]
    for robot, parts in sorted(found.items()):
        lines += ["", f"[{robot}]", f"readings = {json.dumps(parts['readings'])}"]
        for part in ("lengths", "texts"):
            lines += ["", f"[{robot}.{part}]", *(f"{name} = {json.dumps(x)}" for name, x in parts[part].items())]
    return "\n".join(lines) + "\n"


def _late(*_: Any) -> None:
    raise TimeoutError


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robots", nargs="+")
    signal.signal(signal.SIGALRM, _late)
    found = tomllib.loads(TARGET.read_text(encoding="utf-8")) if TARGET.exists() else {}
    for robot in parser.parse_args(arguments).robots:
        found[robot] = short_texts(robot)
        write_file(TARGET, written(found))


if __name__ == "__main__":
    main()
