"""`lwr_dyn.show`: an arm or a run as a page, opened in the browser, or shown in a cell of a notebook."""

import base64
import hashlib
import os
import re
import sys
import webbrowser
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from lwr_dyn.arms.loading import arm_of
from lwr_dyn.arms.urdf.model_files import model_stem
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import check_writable, make_folder, write_file
from lwr_dyn.foundation.progress import in_notebook
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.explorer.page import explorer_html
from lwr_dyn.pages.explorer.page_data import start_pose
from lwr_dyn.pages.replay.replay_page import replay_html
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.pages.still import arm_still

FOLDER = "lwr_dyn_pages"
"""Pages without a name of their own. Not hidden: Jupyter answers 404 for files in folders that begin with a dot."""

_HEIGHT = 640
"""Of the page in a cell [px]."""


@dataclass(frozen=True, slots=True, eq=False)
class ShownPage:
    """A page that was written, or with `embed` one that only the notebook holds; it shows itself in a notebook."""

    title: str
    path: Path | None
    page: str
    still: bytes | None
    """A picture for readers that show no page, PNG; None outside notebooks."""

    def __repr__(self) -> str:
        return f"ShownPage({self.title!r}, in this cell only)" if self.path is None else how_to_open(self.path)

    def _repr_mimebundle_(self, **_: Any) -> dict[str, str]:
        """The page as an iframe, the still, and words: a notebook takes the best that it can show."""
        source = f'srcdoc="{escape(self.page)}"'
        if self.path is not None:
            source = f'src="{escape(Path(os.path.relpath(self.path)).as_posix())}"'
        frame = (
            f'<iframe {source} title="{escape(self.title)}" width="100%" height="{_HEIGHT}" style="border:0"></iframe>'
        )
        bundle = {"text/html": frame, "text/plain": repr(self)}
        still = {} if self.still is None else {"image/png": base64.b64encode(self.still).decode("ascii")}
        return bundle | still


def show(
    shown: Arm | Run,
    path: str | Path | None = None,
    *,
    q: ArrayLike | None = None,
    beside: Arm | None = None,
    embed: bool = False,
    browser: bool | None = None,
) -> ShownPage:
    """An arm in the browser, with sliders, frames, inertia and the source of each number; of a run its replay.

    Parameters
    ----------
    shown : Arm or Run
    path : str or path, optional
        The page's file; in the folder `lwr_dyn_pages` if not given.
    q : (n,) array_like, optional
        Positions of an arm at the start [rad or m]; zero if not given, moved into the limits where they exclude it.
    beside : Arm, optional
        A second arm beside the first one, also one with another number of joints.
    embed : bool
        Whether a notebook holds the page itself, about 1 MB, and no file is written.
    browser : bool, optional
        Whether the page is opened; if not given, on a terminal with a display.

    Returns
    -------
    ShownPage
        Says how to open the file; in a notebook it is the page, with a picture for readers that show no page.

    Raises
    ------
    OptionError
        Neither an arm nor a run; q of a run, or outside the limits; a run beside an arm, or the other way round; a path
        with `embed`; no browser.
    ShapeError
        q of another shape.
    UnknownNameError, FileAccessError
        A run of an unknown robot; a file that cannot be written.
    """
    if not isinstance(shown, Arm | Run):
        raise OptionError("shown", repr(shown), "an arm or a run, such as load, simulate or Run.load give")
    if isinstance(shown, Run) and q is not None:
        raise OptionError("q", "given for a run", "only with an arm")
    _check_beside(shown, beside)
    if embed and (path is not None or browser):
        raise OptionError("embed", "with a path or a browser", "alone: no file is written")
    if path is not None:
        check_writable(path)
    arm = arm_of(shown) if isinstance(shown, Run) else shown
    run = shown if isinstance(shown, Run) else None
    page = explorer_html(arm, q, beside=beside) if run is None else replay_html([run], arm)
    place = run.q[-1] if run is not None else start_pose(arm, q)
    still = arm_still(arm, place, run) if in_notebook() else None
    title = arm.title if beside is None else f"{arm.title} beside {beside.title}"
    if embed:
        return ShownPage(title, None, page, still)
    is_plain = run is None and q is None and beside is None
    target = Path(path) if path is not None else _own_path(arm, run, page, is_plain)
    write_file(target, page)
    if browser or (browser is None and has_display()):
        open_in_browser(target.resolve().as_uri(), required=bool(browser))
    return ShownPage(title, target, page, still)


def _check_beside(shown: Arm | Run, beside: Arm | None) -> None:
    if beside is not None and not isinstance(beside, Arm):
        raise OptionError("beside", repr(beside), "an arm, such as load gives")
    if beside is not None and isinstance(shown, Run):
        raise OptionError("beside", "given for a run", "only with an arm")


def _own_path(arm: Arm, run: Run | None, page: str, is_plain: bool) -> Path:
    """NAME.html of a plain arm, else NAME_DIGEST.html: cells that show other things have other files."""
    label = "" if run is None else f"_{replayed_runs([run], arm)[0].label}"
    name = re.sub(r"[^\w.-]+", "_", f"{model_stem(arm)}{label}")
    if not (is_plain and not arm.loaded_with and not arm.file):
        name += f"_{hashlib.sha256(page.encode()).hexdigest()[:8]}"
    return make_folder(FOLDER) / f"{name}.html"


def how_to_open(path: Path) -> str:
    """What was written, and the line that opens it."""
    opener = {"darwin": "open", "win32": "start"}.get(sys.platform, "xdg-open")
    return f"wrote {path} ({path.stat().st_size / 1e6:.1f} MB, needs no network); open it: {opener} {path}"


def has_display() -> bool:
    """Whether a browser can be opened for who reads the terminal; not in notebooks, pipes, and over plain ssh."""
    if in_notebook() or not sys.stdout.isatty():
        return False
    return sys.platform in ("darwin", "win32") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def open_in_browser(address: str, required: bool) -> None:
    """Open a page; raises `OptionError` when none can be opened and it is required."""
    if not webbrowser.open(address) and required:
        raise OptionError("browser", "no browser found", f"a browser; or without it, open {address}")
