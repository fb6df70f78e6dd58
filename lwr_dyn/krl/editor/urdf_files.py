"""URDF and xacro files in an editor: where the findings of the linter stand, and what they would write instead.

The linter itself is handed in (`UrdfJudge`): it needs numerics, this package does not.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

ENDINGS = (".urdf", ".xacro")
_TAG = re.compile(r"<(/?[\w:.-]+)(?:[^<>\"']|\"[^\"]*\"|'[^']*')*>")


@dataclass(frozen=True, slots=True)
class UrdfRemark:
    """A finding of the linter: absolute path, line and column from 1, and `instead`, a tag to write or nothing."""

    file: str
    line: int
    column: int
    severity: Literal["error", "warning", "note"]
    code: str
    message: str
    instead: str = ""


UrdfJudge: TypeAlias = Callable[[Path, str | None], Sequence[UrdfRemark]]
"""The findings of a file, in the file itself and in those that it includes; a text stands in the place of the file.

It raises `LwrDynError` where the file cannot be read. It is called in a thread, for one file at a time.
"""


def is_urdf(path: Path) -> bool:
    """Whether the linter of URDFs reads a file of this name."""
    return path.suffix.lower() in ENDINGS


def tag_at(text: str, line: int, column: int) -> re.Match[str] | None:
    r"""The tag that begins at a line and column (from 1) of a text; its group is the tag's name.

    >>> tag_at('<robot>\n  <mass value="1"\n  />', 2, 3).span()
    (10, 30)
    """
    lines = text.splitlines(keepends=True)
    return None if line > len(lines) else _TAG.match(text, sum(map(len, lines[: line - 1])) + column - 1)


def quick_fix(text: str, remark: UrdfRemark) -> list[tuple[int, int, str]]:
    """First and last index of each piece of the text that is replaced, with the new piece.

    Empty where the finding does not say the whole tag, or where the tag stands in a macro with an expression: what it
    would be for one robot is not what the file says.
    """
    found, new = tag_at(text, remark.line, remark.column), _TAG.fullmatch(remark.instead)
    if found is None or new is None or "..." in remark.instead or re.search(r"\$[{(]", found[0]):
        return []
    closed = found[0].endswith("/>")
    if new[1] == found[1]:
        written = remark.instead if closed else remark.instead.removesuffix("/>") + ">"
        return [(*found.span(), written)]
    if remark.instead != f"<{new[1]}>":
        return []
    ends = [] if closed else [m for m in re.finditer(rf"</({re.escape(found[1])})\s*>", text[found.end() :])][:1]
    return [(*found.span(1), new[1]), *((found.end() + m.start(1), found.end() + m.end(1), new[1]) for m in ends)]
