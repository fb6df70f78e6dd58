"""Parts of one-file pages: templates, the player's scripts, meshcat's bundle, and numbers packed for JavaScript.

The replay page and the reports of `lwr_dyn.reproduction` are put together from these.
"""

import base64
from collections.abc import Mapping
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.foundation.version import VERSION

PLAYER = ("numbers.js", "drawing.js", "stage.js", "strip.js", "player.js")
"""The scripts of the player, in their order."""
SMALLEST = 1e-290
"""Numbers below this are drawn as zero: their step would not be a normal float."""
_LARGEST_INT32 = 2**31 - 1


def fill_template(template: str, parts: Mapping[str, str]) -> str:
    """Replaces each @@name@@ in a template; inserted text is not expanded.

    >>> fill_template("<p>@@a@@</p>", {"a": "@@b@@"})
    '<p>@@b@@</p>'
    """
    pieces = template.split("@@")  # text, name, text, name, ..., text
    return "".join(parts[piece] if i % 2 else piece for i, piece in enumerate(pieces))


def pack_int32(values: Array) -> dict[str, Any]:
    """Numbers as 32-bit integers times a step, in base64: half the size of float64, error <= 2.4e-10 of the largest.

    >>> pack_int32(np.array([0.5, -0.25]))["shape"]
    [2]
    """
    largest = float(np.abs(values).max(initial=0.0))
    step = largest / _LARGEST_INT32 if largest > SMALLEST else 1.0
    integers = np.rint(values / step).astype("<i4")
    return {"shape": list(values.shape), "step": step, "data": base64.b64encode(integers.tobytes()).decode("ascii")}


def subsample(size: int, stride: int) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Indices 0, stride, 2 stride ... and the last one.

    >>> subsample(6, 2).tolist()
    [0, 2, 4, 5]
    """
    return np.union1d(np.arange(0, size, max(1, stride)), [size - 1])


def generator_line() -> str:
    """What generated the page, for its footer."""
    return f"lwr_dyn {VERSION}, drawn by meshcat and three.js"


def meshcat_folder() -> Path:
    """The folder of the viewer that the installed meshcat serves; raises `MissingDataError` when it is missing."""
    spec = find_spec("meshcat")
    folder = Path(spec.origin).parent / "viewer" / "dist" if spec and spec.origin else Path()
    if not (folder / "main.min.js").is_file():
        raise MissingDataError("meshcat", "viewer/dist/main.min.js", "a replay; install meshcat again")
    return folder


def meshcat_bundle() -> str:
    """The viewer of the installed meshcat (with three.js) as a script."""
    source = (meshcat_folder() / "main.min.js").read_text(encoding="utf-8")
    return "\n".join(line for line in source.splitlines() if not line.startswith("//# sourceMappingURL"))


def script_safe(text: str) -> str:
    """JSON text that cannot close the script element around it."""
    return text.replace("<", "\\u003c")


def resource_text(name: str, package: str = "lwr_dyn.pages.replay") -> str:
    """A file of a package, as text."""
    return files(package).joinpath(name).read_text(encoding="utf-8")
