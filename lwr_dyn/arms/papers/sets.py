"""Published sets of one robot's numbers in one data file: `[[set]]`, whose tables take the place of those of the file.

A reading names a set, and errata on top of it. A set states its frames; an erratum about a set's cells names the set.
"""

from collections.abc import Iterable, Mapping
from typing import Any

from lwr_dyn.arms.papers.schema import FRAMES, ORIGINS, TABLES_OF_A_SET, Erratum, PublishedSet
from lwr_dyn.foundation.fields import Fields


def read_sets(top: Fields) -> dict[str, PublishedSet]:
    """The sets of a data file by name; raises `PaperError` for one that is not of the schema, or named twice."""
    out: dict[str, PublishedSet] = {}
    for fields in top.tables("set", default=[]):
        name, about, where = (fields.text(key) for key in ("name", "about", "where"))
        frames = fields.choice("frames", FRAMES)
        tables = {key: fields.take(key, dict) for key in TABLES_OF_A_SET if key in fields.unread()}
        fields.refuse_unknown()
        if name in out:
            raise fields.refuse("name", f"{name!r} twice", "each name once")
        if (frames == "urdf") != (ORIGINS in tables):
            found = "with origins" if ORIGINS in tables else "without origins"
            raise fields.refuse("frames", f"{frames!r} {found}", "dh, or urdf with a table origins of its joints")
        if not tables:
            raise fields.refuse("", "no table", f"one or more of {', '.join(TABLES_OF_A_SET)}")
        out[name] = PublishedSet(name, about, where, frames, tables)
    return out


def tables_under(own: Mapping[str, Any], published: PublishedSet | None) -> dict[str, Any]:
    """The file's own tables, with those of a set in place of the same tables of the file."""
    return {**own, **(published.tables if published else {})}


def check_errata_of_set(fields: Fields, errata: Iterable[Erratum], published: PublishedSet | None) -> None:
    """Raise `PaperError` where a reading applies an erratum about tables that it does not use."""
    for erratum in errata:
        if erratum.set_name and (published is None or erratum.set_name != published.name):
            used = published.name if published else "the file's own tables"
            raise fields.refuse("errata", f"{erratum.id!r}, of set {erratum.set_name}", f"errata of {used}")
        taken = [] if erratum.set_name or published is None else sorted(erratum.tables() & published.tables.keys())
        if published and taken:
            where = f"{erratum.id!r}, of the file's own {taken[0]}"
            raise fields.refuse("errata", where, f"errata of set {published.name}, which brings that table")
