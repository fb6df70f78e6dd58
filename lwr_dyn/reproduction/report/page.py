"""A report as one HTML file: what is told stands in it as HTML; the scripts add the 3D replay and the plots.

Nothing is loaded: the libraries (meshcat with three.js, plotly.js) and the numbers are in the page, compressed, and its
content security policy forbids requests and code made from text.
"""

from __future__ import annotations

import base64
import gzip
import json
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from lwr_dyn.errors import MissingDataError
from lwr_dyn.files import write_file
from lwr_dyn.reproduction.report.content import Page
from lwr_dyn.reproduction.report.layout import footer, header, navigation, parts_of
from lwr_dyn.reproduction.report.markup import Html, element, joined
from lwr_dyn.reproduction.report.payload import all_figures, payload
from lwr_dyn.viewer.page_parts import PLAYER, fill_template, meshcat_bundle, resource_text

_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "connect-src 'none'; base-uri 'none'; form-action 'none'"
)
_SCRIPTS = ("loader.js", "cells.js", "charts.js", "overlay.js", "report.js")
_WITHOUT_3D = PLAYER[:1]


def report_html(page: Page) -> str:
    """One self-contained page that shows a report; the same records give the same text.

    Parameters
    ----------
    page : Page
        Everything it shows.

    Raises
    ------
    OptionError
        A plot of a run or joint that is not on the page.
    ShapeError
        A run that is empty, not finite, or has other joints than its arm.
    MissingDataError
        The installed meshcat or plotly lacks its script.
    """
    data = json.dumps(payload(page), sort_keys=True, separators=(",", ":"), allow_nan=False)
    libraries = {"numbers": data}
    if page.replay is not None:
        libraries["player"] = "\n".join([meshcat_bundle(), *map(resource_text, PLAYER)])
    else:
        libraries["player"] = "\n".join(map(resource_text, _WITHOUT_3D))
    if all_figures(page):
        libraries["plotly"] = plotly_bundle()
    parts = {
        "title": element("title", page.title),
        "policy": _POLICY,
        "style": resource_text("player.css") + _resource_text("report.css"),
        "signs": _resource_text("signs.svg"),
        "navigation": navigation(page),
        "header": header(page),
        "main": joined(parts_of(page)),
        "footer": footer(page),
        "libraries": joined(_library(name, text) for name, text in libraries.items()),
        "scripts": "\n".join(map(_resource_text, _SCRIPTS)),
    }
    return fill_template(_resource_text("report.html"), parts)


def write_report(path: str | Path, page: Page) -> None:
    """Write `report_html(page)` to a file; raises as it does, and `FileAccessError`."""
    write_file(path, report_html(page))


def plotly_bundle() -> str:
    """The installed plotly.js; raises `MissingDataError` when it is not there."""
    spec = find_spec("plotly")
    script = Path(spec.origin or "").parent / "package_data" / "plotly.min.js" if spec else Path()
    if not script.is_file():
        raise MissingDataError("plotly", "package_data/plotly.min.js", "a report; install plotly again")
    return script.read_text(encoding="utf-8")


def _library(name: str, text: str) -> Html:
    """A text, compressed, as the loader unpacks it."""
    packed = base64.b64encode(gzip.compress(text.encode(), compresslevel=9, mtime=0)).decode("ascii")
    return Html(f'<script type="text/plain" id="packed-{name}">{packed}</script>\n')


def _resource_text(name: str) -> str:
    return files("lwr_dyn.reproduction.report").joinpath(name).read_text(encoding="utf-8")
