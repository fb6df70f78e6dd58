"""How results show themselves: a short text; HTML in a notebook and other files of a run by optional packages."""

import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.registry import Registry, Row

NOTEBOOK_FORMS: Registry[Callable[[Any], str]] = Registry(
    "notebook_form", {"html": Row("lwr_dyn.pages.notebook.forms:html_of", "a result as small HTML")}
)
"""How a notebook shows a result."""
RUN_FORMATS: Registry[Callable[[Any], bytes]] = Registry(
    "run_format",
    {
        ".csv": Row("lwr_dyn.pages.notebook.run_formats:csv_bytes", "text, every number to its last bit"),
        ".parquet": Row("lwr_dyn.pages.notebook.run_formats:parquet_bytes", "Parquet", extra="logs"),
        ".mat": Row("lwr_dyn.pages.notebook.run_formats:matlab_bytes", "MATLAB"),
    },
)
"""Ending of a file -> a run as its bytes; .npz is `Run.save`'s own."""
_WIDTH, _LINES = 110, 5


def format_of(path: str | Path) -> Callable[[Any], bytes] | None:
    """What makes a run the bytes of a file of this ending; None for .npz.

    Raises `FileAccessError` for an ending that no format has, `MissingPackageError` for a format that is not installed.
    """
    suffix = Path(path).suffix
    if suffix != ".npz" and suffix not in RUN_FORMATS.names:
        known = ", ".join((".npz", *RUN_FORMATS.names))
        raise FileAccessError(str(path), f"ends in {suffix or 'nothing'!r}", f"a path that ends in one of {known}")
    return None if suffix == ".npz" else RUN_FORMATS.load(suffix)


def short_repr(value: Any) -> str:
    """A record in at most five lines: arrays by their shape, rows by their number."""
    parts = [f"{f.name}={_shortly(getattr(value, f.name))}" for f in fields(value) if f.repr]
    text = f"{type(value).__name__}({', '.join(parts)})"
    return "\n".join(textwrap.wrap(text, _WIDTH, max_lines=_LINES, subsequent_indent="  ", placeholder=" ...)"))


def _shortly(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"array{value.shape}"
    if value is None or isinstance(value, str | int | float):
        return textwrap.shorten(repr(value), 60)
    if isinstance(value, Mapping | Sequence):
        return f"{len(value)} {'entry' if len(value) == 1 else 'entries'}"
    return type(value).__name__


def repr_html(value: Any) -> str | None:
    """What a notebook shows."""
    return NOTEBOOK_FORMS.load("html")(value)
