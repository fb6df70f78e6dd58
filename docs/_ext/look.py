"""The look of the project on the site: tokens and fonts of the pages, and names for the landmarks of the theme."""

import re
from pathlib import Path

from sphinx.application import Sphinx

from lwr_dyn.pages.replay.look import font_faces, look_css

LANDMARKS = {
    '<aside class="sidebar-drawer">': '<aside class="sidebar-drawer" aria-label="Pages">',
    '<aside class="toc-drawer">': '<aside class="toc-drawer" aria-label="This page">',
    '<aside class="toc-drawer no-toc">': '<aside class="toc-drawer no-toc" aria-label="This page">',
}


def write_tokens(app: Sphinx) -> None:
    """Tokens and fonts as a style sheet of the site."""
    if app.builder.format == "html":
        folder = Path(app.outdir) / "_static"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "look.css").write_text(f"{look_css()}\n{font_faces()}\n", encoding="utf-8")


def mend_page(text: str) -> str:
    """A page whose landmarks have names, whose wide tables and code can be scrolled by keyboard."""
    for old, new in LANDMARKS.items():
        text = text.replace(old, new)
    text = re.sub(r'<div class="table-wrapper([^"]*)">', r'<div class="table-wrapper\1" tabindex="0">', text)
    if "<h1" not in text:  # the theme's page of search results
        text = text.replace('<div id="search-results">', '<h1>Search</h1>\n<div id="search-results">')
    return text.replace("<pre>", '<pre tabindex="0">')


def mend_pages(app: Sphinx, error: Exception | None) -> None:
    """Mend each page that was written."""
    if error is None and app.builder.format == "html":
        for path in Path(app.outdir).glob("**/*.html"):
            if "gallery_pages" not in path.parts:
                before = path.read_text(encoding="utf-8")
                after = mend_page(before)
                if after != before:
                    path.write_text(after, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the steps."""
    app.connect("builder-inited", write_tokens)
    app.connect("build-finished", mend_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
