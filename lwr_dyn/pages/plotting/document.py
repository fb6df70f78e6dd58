"""A document as one HTML file: its head, its look and its frame; what stands in it comes from the caller.

Nothing is loaded; light and dark follow the reader's system.
"""

from html import escape

from lwr_dyn.foundation.version import VERSION
from lwr_dyn.pages.replay.look import font_faces, look_css
from lwr_dyn.pages.replay.page_parts import fill_template, resource_text

POLICY = "default-src 'none'; style-src 'unsafe-inline'; font-src data:; img-src data:; base-uri 'none'"
"""What a document without scripts may load: what stands in it."""
_PACKAGE = "lwr_dyn.pages.plotting"


def document_html(
    title: str, kind: str, main: str, command: str, *, style: str = "", scripts: str = "", policy: str = POLICY
) -> str:
    """One HTML file; the same parts give the same text.

    Parameters
    ----------
    title : str
        Plain text.
    kind : str
        What sort of document it is, in a word.
    main : str
        HTML, with a heading of the first level.
    command : str
        What made it, as "lwr-dyn compare".
    style, scripts : str, optional
        Rules of its own; script elements, which `policy` must allow.
    """
    parts = {
        "policy": policy,
        "title": escape(title),
        "kind": escape(kind),
        "style": "\n".join((look_css(), font_faces(), resource_text("document.css", _PACKAGE), style)),
        "main": main,
        "scripts": scripts,
        "footer": f"Made by lwr_dyn {VERSION}, {escape(command)}.",
    }
    return fill_template(resource_text("document.html", _PACKAGE), parts)
