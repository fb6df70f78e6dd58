"""The tables of docs/robots_against_reality.md: sets on logs of real robots, and whose numbers shipped models have.

python scripts/robots_against_reality.py                   what the logs of the package and docs/shipped_sets.toml show
python scripts/robots_against_reality.py --logs FOLDER     fetched logs too, each recognised by its digest
python scripts/robots_against_reality.py --urdf FILE...    further models, traced and printed
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import numpy as np

from lwr_dyn.checks.origin.link_numbers import KnownSet, LinkNumbers, known_sets, numbers_of_file
from lwr_dyn.checks.origin.tracing import Trace, trace_origin
from lwr_dyn.foundation.errors import LogError
from lwr_dyn.foundation.fields import parse_toml
from lwr_dyn.identification.ranking.rank import rank

ROOT = Path(__file__).resolve().parents[1]
PAGE, SHIPPED = ROOT / "docs" / "robots_against_reality.md", ROOT / "docs" / "shipped_sets.toml"
PLACE = re.compile(r"<!-- reality: (?P<what>[\w-]+) -->\n.*?<!-- reality: end -->", re.DOTALL)
PANDA = ("gaz", "gaz_code", "fr3", "fr3v2", "fer", "rtb_matlab", "rtb_python", "identified")
TEN_E = ("maker", "mamedov", "ur10:maker", "identified")
RANKINGS = {
    "panda-b": ("panda", "panda_salerno", None, PANDA, ("load",)),
    "panda-a": ("panda", "panda_gaz", None, PANDA, ("load",)),
    "ur10": ("ur10", "ur10_salerno", None, ("maker", "ur10e:maker", "identified"), ("rotor", "gain")),
    "ur10e-ptp": (
        "ur10e",
        "ur10e_30s",
        "ur10e_ptp",
        TEN_E,
        ("rotor", "gain"),
    ),
    "ur10e-40s": (
        "ur10e",
        "ur10e_30s",
        "ur10e_40s",
        TEN_E,
        ("rotor", "gain"),
    ),
    "tx40": ("tx40", "tx40_figaroh", None, ("urdf", "frame_axes", "identified"), ("rotor", "coupling")),
}
"""Place of the page -> robot, log, log that tests, sets, what is freed."""
HERE = ("panda-b", "ur10", "shipped", "copies")
"""Tables that need no log from elsewhere."""


def ranked(what: str, folder: Path | None = None) -> str:
    """The table of a ranking as Markdown; raises `LogError` where its log is not at hand."""
    robot, log, test, sets, free = RANKINGS[what]
    found = rank(robot, log, sets, free=free, test=test, folder=None if what in HERE else folder or ROOT / "docs")
    heads = ["set", "as published", *(f"+ {name}" for name in free), "95 %", "a body"]
    rows = [
        [f"`{one.name}`", *(f"{fit.total:.3f}" for fit in one.fits),
         "" if np.isnan(one.intervals[0][0]) else "{:.3f} to {:.3f}".format(*one.intervals[0]),
         "; ".join(one.not_bodies) or "yes"]
        for one in found.scores
    ]  # fmt: skip
    floors = [f"{found.floor(i):.3f}" for i in range(len(free) + 1)]
    return markdown(heads, [*rows, ["least squares", *floors, "", "no set of bodies"]])


def shipped() -> str:
    """Whose numbers the models of docs/shipped_sets.toml have."""
    rows = []
    for model in parse_toml(SHIPPED.read_text("utf-8"), SHIPPED.name)["model"]:
        links = []
        for i, (mass, x, y, z, xx, yy, zz, xy, xz, yz) in enumerate(model["links"]):
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=float)
            links.append((f"link {i + 1}", float(mass), np.array([x, y, z], dtype=float), tensor))
        named = "; the same numbers: ".join(filter(None, (model["name"], model.get("same"))))
        rows.append([named, *words_of(trace_origin(LinkNumbers.of(links)))])
    return markdown(["model", "numbers of", "masses, centres, tensors that agree", "cells that differ"], rows)


def copies() -> str:
    """Sets of the package that share numbers with another robot's."""
    rows = []
    known = known_sets()
    for one in known:
        found = trace_origin(one.native, [one, *(other for other in known if other.robot != one.robot)])
        for kind in () if found is None else found.kinds:
            if kind.elsewhere:
                rows.append([f"`{one.name}`", kind.kind, ", ".join(f"`{name}`" for name in kind.elsewhere)])
    return markdown(["set", "numbers", "the same stand in"], rows)


def words_of(found: Trace | None) -> list[str]:
    """The set, links that agree, and how many cells differ."""
    if found is None or not found.is_copy:
        return ["none of the sets here", "", ""]
    agree = ", ".join(f"{kind.agree} of {len(found.pairs)}" for kind in found.kinds)
    known: KnownSet = found.known
    return [f"`{known.name}`", agree, str(len(found.differences))]


def markdown(heads: list[str], rows: list[list[str]]) -> str:
    """A table."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def tables(folder: Path | None = None) -> dict[str, str]:
    """Place -> table, of what is at hand."""
    out = {"shipped": shipped(), "copies": copies()}
    for what in RANKINGS:
        try:
            out[what] = ranked(what, folder)
        except LogError as missing:
            print(f"{what}: left as it is: {missing.found}")
    return out


def with_tables(page: str, found: dict[str, str]) -> str:
    """The page with these tables in their places; others stay."""

    def put(place: re.Match[str]) -> str:
        what = place["what"]
        return f"<!-- reality: {what} -->\n{found[what]}\n<!-- reality: end -->" if what in found else place[0]

    return PLACE.sub(put, page)


def main() -> None:
    """Write the tables into the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--logs", type=Path)
    parser.add_argument("--urdf", nargs="*", default=[])
    given = parser.parse_args()
    for path in given.urdf:
        print(Path(path).name, *words_of(trace_origin(numbers_of_file(path))), sep=" | ")
    PAGE.write_text(with_tables(PAGE.read_text("utf-8"), tables(given.logs)), encoding="utf-8")


if __name__ == "__main__":
    main()
