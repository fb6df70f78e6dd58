"""A report as one HTML file: text and tables are HTML; scripts add the 3D replay and the figures.

Nothing is loaded: the libraries (meshcat with three.js, plotly.js) and the numbers are in the page, compressed, and its
content security policy forbids requests and code made from text.
"""

import base64
import gzip
import json
from importlib.util import find_spec
from pathlib import Path

from lwr_dyn.errors import MissingDataError, MissingPackageError
from lwr_dyn.files import write_file
from lwr_dyn.reproduction.report.content import Page
from lwr_dyn.reproduction.report.layout import HERE, footer, header, main, navigation, parts_of
from lwr_dyn.reproduction.report.markup import Html, element, joined
from lwr_dyn.reproduction.report.script_data import all_figures, script_data
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
        Its content.

    Raises
    ------
    OptionError
        A figure of a run or joint that is not on the page.
    MissingPackageError
        plotly is not installed, and the page has figures.
    MissingDataError
        The installed meshcat or plotly lacks its script.
    """
    data = json.dumps(script_data(page), sort_keys=True, separators=(",", ":"), allow_nan=False)
    libraries = {"numbers": data}
    if page.replay is not None:
        libraries["player"] = "\n".join([meshcat_bundle(), *map(resource_text, PLAYER)])
    else:
        libraries["player"] = "\n".join(map(resource_text, _WITHOUT_3D))
    if all_figures(page):
        libraries["plotly"] = plotly_bundle()
    parts = parts_of(page)
    filling = {
        "title": element("title", page.title),
        "policy": _POLICY,
        "style": resource_text("look.css") + resource_text("player.css") + resource_text("report.css", HERE),
        "signs": resource_text("signs.svg", HERE),
        "navigation": navigation(parts),
        "header": header(page),
        "main": main(parts),
        "footer": footer(page),
        "libraries": joined(_library(name, text) for name, text in libraries.items()),
        "scripts": "\n".join(resource_text(name, HERE) for name in _SCRIPTS),
    }
    return fill_template(resource_text("report.html", HERE), filling)


def write_report(path: str | Path, page: Page) -> None:
    """Write `report_html(page)` to a file; raises as it does, and `FileAccessError`."""
    write_file(path, report_html(page))


def plotly_bundle() -> str:
    """The installed plotly.js; raises `MissingPackageError`, and `MissingDataError` when plotly lacks its script."""
    spec = find_spec("plotly")
    if spec is None:
        raise MissingPackageError("plotly", "report")
    script = Path(spec.origin or "").parent / "package_data" / "plotly.min.js"
    if not script.is_file():
        raise MissingDataError("plotly", "package_data/plotly.min.js", "a report; install plotly again")
    return script.read_text(encoding="utf-8")


def _library(name: str, text: str) -> Html:
    """A text, compressed; the loader unpacks it."""
    packed = base64.b64encode(gzip.compress(text.encode(), compresslevel=9, mtime=0)).decode("ascii")
    return Html(f'<script type="text/plain" id="packed-{name}">{packed}</script>\n')
