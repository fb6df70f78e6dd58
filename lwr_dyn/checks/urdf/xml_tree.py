"""XML text as elements that know their place: by expat, without namespaces, as urdfdom and Drake read a URDF."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any
from xml.parsers import expat

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
    """One element: its tag with the prefix as written, attributes, place, children."""

    tag: str
    attributes: Mapping[str, str]
    place: Place
    ignored: frozenset[str]
    """Codes that comments before it, or before what it stands in, ask to ignore."""
    children: list["XmlElement"] = field(default_factory=list)
    declared: Mapping[str, str] = field(default_factory=dict)
    """Attributes `xmlns...`."""

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
        declared = {k: attributes.pop(k) for k in list(attributes) if k == "xmlns" or k.startswith("xmlns:")}
        element = XmlElement(tag, attributes, place, inherited | self.pending, [], declared)
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
    """The root element.

    Parameters
    ----------
    content : bytes or str
    file : str
        Its name in places.
    carried : bool
        Whether attributes `at.` hold the places, as `xacro_places` writes them.

    Raises
    ------
    XmlFaultError
        What is no XML, with its place.

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
