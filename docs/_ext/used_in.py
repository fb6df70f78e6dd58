"""Where a name is used: found in pages, notebooks and examples, not written by hand."""

import re
from functools import cache
from pathlib import Path


@cache
def sources(root: Path) -> dict[str, str]:
    """Text of every page and example, by path from the project's root."""
    pages = [p for p in (root / "docs").rglob("*.md") if "_build" not in p.parts]
    examples = (root / "scripts" / "examples").glob("*.py")
    return {p.relative_to(root).as_posix(): p.read_text(encoding="utf-8") for p in sorted([*pages, *examples])}


def title(text: str) -> str:
    """The first heading of a page."""
    found = re.search(r"^# (.+)$", text, re.MULTILINE)
    return found[1].replace("`", "") if found else "page"


def used_in(pattern: str, root: Path, page: str) -> str:
    """Links to what matches a pattern, as they stand in a page of `docs/`; empty if nothing does."""
    links = []
    for name, text in sources(root).items():
        if not re.search(pattern, text) or name == page:
            continue
        if name.endswith(".py"):
            links.append(f"`{name}`")
        else:
            up = "../" * (Path(page).parts.__len__() - 2)
            links.append(f"[{title(text)}]({up}{name.removeprefix('docs/')})")
    return f"Used in: {', '.join(links)}." if links else ""
