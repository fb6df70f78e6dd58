"""XML of foreign files: undeclared prefixes are read as the engines read them; a xacro is named.

Engines parse a URDF without namespaces (urdfdom and Drake with tinyxml2), so files with `<drake:gear_ratio>` or
`<gazebo xlink:href="...">` and no declaration of the prefix are about. A strict parser refuses them.
"""

import re
from xml.etree import ElementTree
from xml.parsers.expat import errors

from lwr_dyn.foundation.errors import UrdfError

DRAKE = "http://drake.mit.edu"
"""Drake's namespace, which an undeclared prefix `drake` stands for."""
_UNBOUND = errors.codes[errors.XML_ERROR_UNBOUND_PREFIX]
_PREFIX = re.compile(rb"[<\s/]([A-Za-z_][\w.-]*):[A-Za-z_]")
_DECLARED = re.compile(rb"xmlns:([A-Za-z_][\w.-]*)\s*=")
_ROOT = re.compile(rb"<!--.*?-->|(<robot\b[^>]*>)", re.DOTALL)
_AROUND = b" \t\r\n\0"
"""Before and after the document, where the engines pass over it."""
_XACRO = "xacro"
_DEEPEST = 100
"""Levels of nested elements: far above any URDF, far below what Python's recursion bears."""


def parse_xml(content: bytes, file: str) -> ElementTree.Element:
    """The root element of a URDF.

    Raises
    ------
    UrdfError
        Broken XML; elements nested too deep; a file of xacro macros, with the command that expands it.
    """
    try:
        root = _tree(content.strip(_AROUND))
    except (ElementTree.ParseError, ValueError, LookupError) as fault:
        raise UrdfError(file, "XML", str(fault), "a well-formed URDF") from None
    if _depth(root) > _DEEPEST:
        raise UrdfError(file, "XML", f"elements nested {_depth(root)} deep", f"at most {_DEEPEST} levels")
    for element in root.iter():
        space, _, tag = str(element.tag).rpartition("}")
        if _XACRO in space.lower() and space:
            allowed = f"the URDF that it expands to, or a name that ends in .xacro: xacro {file} > expanded.urdf"
            raise UrdfError(file, f"<xacro:{tag}>", "a file of xacro macros", allowed)
    return root


def _depth(root: ElementTree.Element) -> int:
    level, depth = [root], 0
    while level:
        level, depth = [child for element in level for child in element], depth + 1
    return depth


def _tree(content: bytes) -> ElementTree.Element:
    try:
        return ElementTree.fromstring(content)
    except ElementTree.ParseError as fault:
        if fault.code != _UNBOUND:
            raise
    return ElementTree.fromstring(_with_declarations(content))


def _with_declarations(content: bytes) -> bytes:
    """The text with its undeclared prefixes declared in <robot>, on the same line, so that lines keep their numbers."""
    start = next((found for found in _ROOT.finditer(content) if found[1]), None)
    if start is None:
        return content
    known = {*_DECLARED.findall(start[1]), b"xml", b"xmlns"}
    unknown = sorted({*_PREFIX.findall(content)} - known)
    spaces = [b' xmlns:%s="%s"' % (x, DRAKE.encode() if x == b"drake" else b"undeclared:" + x) for x in unknown]
    at = start.start(1) + len(b"<robot")
    return content[:at] + b"".join(spaces) + content[at:]
