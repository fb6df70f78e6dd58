"""A report as one HTML file: text, tables and figures are HTML and SVG; scripts add the 3D replay, cursors and zoom.

Nothing is loaded: the library of the 3D view (meshcat with three.js) and the numbers are in the page, compressed, and
its content security policy forbids requests and code made from text.
"""

import base64
import gzip
import json
from pathlib import Path

from lwr_dyn.foundation.files import write_file
from lwr_dyn.pages.replay.look import font_faces, look_css
from lwr_dyn.pages.replay.page_parts import PLAYER, fill_template, meshcat_bundle, resource_text
from lwr_dyn.reproduction.report.content import Page
from lwr_dyn.reproduction.report.layout import HERE, footer, header, main, parts_of
from lwr_dyn.reproduction.report.markup import Html, element, joined
from lwr_dyn.reproduction.report.script_data import script_data

_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; font-src data:; "
    "connect-src 'none'; base-uri 'none'; form-action 'none'"
)
_SCRIPTS = ("loader.js", "series.js", "charts.js", "report.js")


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
    MissingDataError
        The installed meshcat lacks its script.
    """
    data = json.dumps(script_data(page), sort_keys=True, separators=(",", ":"), allow_nan=False)
    libraries = {"numbers": data}
    if page.replay is not None:
        libraries["player"] = "\n".join([meshcat_bundle(), *map(resource_text, PLAYER[1:])])
    parts = parts_of(page)
    filling = {
        "title": element("title", page.title),
        "policy": _POLICY,
        "style": "\n".join((font_faces(), look_css(), resource_text("player.css"), resource_text("report.css", HERE))),
        "header": header(page, parts),
        "main": main(parts),
        "footer": footer(),
        "libraries": joined(_library(name, text) for name, text in libraries.items()),
        "scripts": "\n".join([resource_text(PLAYER[0]), *(resource_text(name, HERE) for name in _SCRIPTS)]),
    }
    return fill_template(resource_text("report.html", HERE), filling)


def write_report(path: str | Path, page: Page) -> None:
    """Write `report_html(page)` to a file; raises as it does, and `FileAccessError`."""
    write_file(path, report_html(page))


def _library(name: str, text: str) -> Html:
    """A text, compressed; the loader unpacks it."""
    packed = base64.b64encode(gzip.compress(text.encode(), compresslevel=9, mtime=0)).decode("ascii")
    return Html(f'<script type="text/plain" id="packed-{name}">{packed}</script>\n')
