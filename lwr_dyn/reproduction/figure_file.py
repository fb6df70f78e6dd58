"""`figures.json`: what the figures of a paper show, written once; PNG, SVG and page are drawn from what is read back.

A curve of numbers stands there with its numbers (null is a gap), a curve of a run with the run's place in the list of
run files, its quantity and joint.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.files import read_text, write_folder
from lwr_dyn.pages.replay.figures import Curve, Figure, Level, Panel, Series

FIGURES = "figures.json"
FigureFiles = Mapping[str, Sequence[Figure]]
"""Name of a drawn file -> its figures side by side."""


def written_figures(folder: Path, figures: FigureFiles, run_files: Sequence[str]) -> dict[str, tuple[Figure, ...]]:
    """Write `figures.json` and return what it says.

    Parameters
    ----------
    folder : Path
        Where; raises `FileAccessError`.
    figures : mapping
        Name of a drawn file -> its figures.
    run_files : sequence of str
        The files of the runs that series refer to by their place.
    """
    record = {
        "runs": list(run_files),
        "figures": {file: [_plain(figure) for figure in drawn] for file, drawn in figures.items()},
    }
    write_folder(folder, {FIGURES: json.dumps(record, allow_nan=False) + "\n"})
    return read_figures(folder / FIGURES)


def read_figures(path: Path) -> dict[str, tuple[Figure, ...]]:
    """The figures of a `figures.json`; raises `FileAccessError`."""
    record = json.loads(read_text(path, "figures of a reproduced paper"))
    return {file: tuple(map(_figure, drawn)) for file, drawn in record["figures"].items()}


def _plain(value: Any) -> Any:
    """A record of `viewer.figures` as JSON values; floats keep every digit."""
    if isinstance(value, np.ndarray):
        return [x if np.isfinite(x) else None for x in value.tolist()]
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    if isinstance(value, Figure | Panel | Curve | Series | Level):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    return value.item() if isinstance(value, np.generic) else value


def _figure(record: Mapping[str, Any]) -> Figure:
    return Figure(**{**record, "panels": tuple(map(_panel, record["panels"]))})


def _panel(record: Mapping[str, Any]) -> Panel:
    curves = tuple(
        Curve(**{**curve, **{axis: _source(curve[axis]) for axis in "xy"}, "text": tuple(curve["text"])})
        for curve in record["curves"]
    )
    return Panel(**{**record, "curves": curves, "levels": tuple(Level(**level) for level in record["levels"])})


def _source(value: Any) -> Array | Series | None:
    """Numbers with NaN for a gap, or a series."""
    if isinstance(value, list):
        return np.array([np.nan if x is None else x for x in value], dtype=np.float64)
    return None if value is None else Series(**value)
