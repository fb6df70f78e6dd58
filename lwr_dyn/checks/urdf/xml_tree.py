"""XML text as elements that know their place: by expat, without namespaces, as urdfdom and Drake read a URDF.

Of xacro, each element of the expanded URDF knows the line of the macro file that it comes from. Of numbers in
attributes, what cannot be used is None, what is too small to matter 0.
"""

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.dom import expatbuilder
from xml.dom.minidom import Document
from xml.parsers import expat

import numpy as np

from lwr_dyn.arms.urdf.xacro_files import expand_xacro
from lwr_dyn.foundation.arrays import Array, number_of
from lwr_dyn.foundation.errors import LwrDynError

PLACE = "at."
"""The attribute that carries an element's place through xacro: "line:column:file"."""
_IGNORE = re.compile(r"lwr-dyn:\s*ignore\s+([\w\s,.-]+)", re.IGNORECASE)
_AROUND = b" \t\r\n\0"


@dataclass(frozen=True, slots=True, order=True)
class Place:
    """Where something stands: file, line and column, both from 1; columns count code points."""

    file: str
    line: int
    column: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True, slots=True, eq=False)
class XmlElement:
    """One element: its tag with the prefix as written, attributes but for `xmlns...`, place, children."""

    tag: str
    attributes: Mapping[str, str]
    place: Place
    ignored: frozenset[str]
    """Codes that comments before it, or before what it stands in, ask to ignore."""
    children: list["XmlElement"] = field(default_factory=list)

    def child(self, tag: str) -> "XmlElement | None":
        """The first child of this tag."""
        return next((x for x in self.children if x.tag == tag), None)

    def all(self, tag: str) -> "list[XmlElement]":
        """All children of this tag."""
        return [x for x in self.children if x.tag == tag]


class XmlFaultError(LwrDynError, ValueError):
    """Text that is no XML: what expat says, and where."""

    def __init__(self, said: str, place: Place) -> None:
        super().__init__(f"{place}: {said}")
        self.said, self.place = said, place


@dataclass(slots=True, eq=False)
class _Reader:
    """What expat calls: a stack of open elements."""

    parser: Any
    file: str
    carried: bool
    skipped: int
    root: XmlElement | None = None
    open: list[XmlElement] = field(default_factory=list)
    pending: set[str] = field(default_factory=set)

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        """An opening tag."""
        inherited = self.open[-1].ignored if self.open else frozenset[str]()
        place = self.place(attributes.pop(PLACE, "") if self.carried else "")
        kept = {k: v for k, v in attributes.items() if k != "xmlns" and not k.startswith("xmlns:")}
        element = XmlElement(tag, kept, place, inherited | self.pending)
        self.pending = set()
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def end(self, tag: str) -> None:
        """A closing tag."""
        self.open.pop()
        self.pending = set()

    def comment(self, text: str) -> None:
        """A comment, which may ask to ignore codes in the next element."""
        for words in _IGNORE.findall(text):
            self.pending |= {word.lower() for word in re.split(r"[\s,]+", words) if word}

    def place(self, carried: str = "") -> Place:
        """The place that xacro carried along, or where the parser stands."""
        line, _, rest = carried.partition(":")
        column, _, source = rest.partition(":")
        if source and line.isdecimal() and column.isdecimal():
            return Place(source, int(line), int(column))
        return Place(self.file, self.parser.CurrentLineNumber + self.skipped, self.parser.CurrentColumnNumber + 1)


def read_tree(content: bytes | str, file: str, carried: bool = False) -> XmlElement:
    """The root element; with `carried`, attributes `at.` hold the places, as `expand_with_places` writes them.

    Raises `XmlFaultError` for what is no XML, with its place.

    >>> read_tree("<robot>\\n  <link/></robot>", "a.urdf").children[0].place
    Place(file='a.urdf', line=2, column=3)
    """
    content = content.encode() if isinstance(content, str) else content
    text = content.lstrip(_AROUND)  # engines pass over blank lines before the XML declaration, expat does not
    reader = _Reader(expat.ParserCreate(), file, carried, content[: len(content) - len(text)].count(b"\n"))
    parser = reader.parser
    parser.StartElementHandler, parser.EndElementHandler = reader.start, reader.end
    parser.CommentHandler = reader.comment
    try:
        parser.Parse(text.rstrip(_AROUND), True)
    except expat.ExpatError as fault:
        said = expat.errors.messages[fault.code]
        raise XmlFaultError(said, Place(file, fault.lineno + reader.skipped, fault.offset + 1)) from None
    except (ValueError, LookupError) as fault:  # an encoding that expat does not know
        raise XmlFaultError(str(fault), Place(file, 1, 1)) from None
    assert reader.root is not None  # expat raises "no element found"
    return reader.root


def expand_with_places(path: Path, arguments: Mapping[str, str], trust: bool = False) -> str:
    """What a xacro file expands to, its elements with an attribute "line:column:file"; raises as `expand_xacro`."""
    return expand_xacro(path, arguments, _parse, trust)


def _parse(text: Any, filename: str | None = None) -> Any:
    """In place of `xacro.parse`: a document already parsed, a text, an open file, or a file by name."""
    if isinstance(text, Document):
        return text
    if text is None:
        text = _read(str(filename))
    elif hasattr(text, "read"):
        text = text.read()
    return _builder(os.path.relpath(str(filename))).parseString(text)


def _read(filename: str) -> bytes:
    """A file's bytes; as xacro, a fault that an optional `<xacro:include>` passes over."""
    import xacro

    try:
        return Path(filename).read_bytes()
    except OSError as fault:
        xacro.filestack.pop()
        raise xacro.XacroException(f"{fault.strerror}: {filename}", exc=fault) from None


def _builder(file: str) -> Any:
    """A builder of minidom that adds the place to elements outside the namespace of xacro."""
    builder: Any = expatbuilder.ExpatBuilderNS()
    inner = builder.start_element_handler

    def start(name: str, attributes: list[str]) -> None:
        parser = builder.getParser()
        if "xacro" not in name.partition(" ")[0]:
            column = parser.CurrentColumnNumber + 1
            attributes = [*attributes, PLACE, f"{parser.CurrentLineNumber}:{column}:{file}"]
        inner(name, attributes)

    builder.start_element_handler = start
    return builder


LARGEST = 1e15
"""Magnitude beyond which a number is not used: no robot has it, and its square may overflow."""
SMALLEST = 1e-30
"""Magnitude below which a number is used as 0."""


def numbers(text: str | None) -> tuple[float, ...] | None:
    """The numbers of an attribute; None where one is no number, not finite, or too large to be meant.

    >>> numbers("1 -2e-3"), numbers("1,5"), numbers("nan")
    ((1.0, -0.002), None, None)
    """
    try:
        values = [number_of(word) for word in (text or "").split()]
    except ValueError:
        return None
    if not all(math.isfinite(v) and abs(v) < LARGEST for v in values):
        return None
    return tuple(v if abs(v) > SMALLEST else 0.0 for v in values)


def scalar(element: XmlElement | None, name: str) -> float | None:
    """An attribute that is one number."""
    values = numbers(element.attributes.get(name)) if element is not None else None
    return values[0] if values is not None and len(values) == 1 else None


def vector(element: XmlElement | None, name: str, default: tuple[float, float, float]) -> Array | None:
    """An attribute that is three numbers; the default where it is not written."""
    if element is None or name not in element.attributes:
        return np.array(default)
    values = numbers(element.attributes[name])
    return np.array(values) if values is not None and len(values) == 3 else None
