"""HTML from records: an element or a table at a time; text is escaped unless it is `Html` already."""

import re
from collections.abc import Iterable, Sequence
from html import escape

from lwr_dyn.foundation.number_text import raised


class Html(str):
    """Text that is HTML; every other text is escaped when it goes into an element."""

    __slots__ = ()


Child = str | Html | None

Attribute = str | int | float | bool | None


def element(tag: str, *children: Child | Iterable[Child], **attributes: Attribute) -> Html:
    """An element; `class_` and `for_` lose their underscore, others get hyphens; None and False are left out.

    >>> element("a", "1 < 2", href="#x", data_note='say "hi"', class_="y", hidden=False, tabindex=0)
    '<a href="#x" data-note="say &quot;hi&quot;" class="y" tabindex="0">1 &lt; 2</a>'
    """
    shown = "".join(
        _attribute(name, value) for name, value in attributes.items() if value is not None and value is not False
    )
    return Html(f"<{tag}{shown}>{joined(children)}</{tag}>")


def grid(
    name: str, head: Iterable[str], rows: Iterable[Sequence[Child]], class_: str = "plain", **attributes: Attribute
) -> Html:
    """A table that scrolls sideways by itself where the window is narrow.

    The first cell of a row is its heading. Other cells are text, or `Html` elements of their own.
    """
    top = element("tr", [element("th", raised(text), scope="col") for text in head])
    lines = [
        element(
            "tr",
            element("th", first, scope="row"),
            [cell if isinstance(cell, Html) else element("td", cell) for cell in cells],
        )
        for first, *cells in rows
    ]
    table = element("table", element("thead", top), element("tbody", lines), class_=class_, **attributes)
    return element("div", table, class_="scroll", role="region", tabindex=0, aria_label=f"{name}, scrolls sideways")


def joined(children: Iterable[Child | Iterable[Child]]) -> Html:
    """Children one after the other.

    >>> joined(["a & b", [element("b", "c"), None]])
    'a &amp; b<b>c</b>'
    """
    return Html("".join(_text(child) for child in children))


def anchor(kind: str, name: str) -> str:
    """The id of something on the page, safe in an attribute and after #.

    >>> anchor("erratum", "lwr4plus/5 <z>")
    'erratum-lwr4plus-5-z-'
    """
    return f"{kind}-{re.sub(r'[^A-Za-z0-9_.]+', '-', name)}"


def _text(child: Child | Iterable[Child]) -> str:
    if child is None:
        return ""
    if isinstance(child, Html):
        return child
    return escape(child) if isinstance(child, str) else joined(child)


def _attribute(name: str, value: Attribute) -> str:
    written = name.rstrip("_").replace("_", "-")
    return f" {written}" if value is True else f' {written}="{escape(str(value))}"'
