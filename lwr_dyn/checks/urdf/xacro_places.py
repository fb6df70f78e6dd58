"""xacro with places: each element of the expanded URDF knows the line of the macro file that it comes from."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.dom import expatbuilder
from xml.dom.minidom import Document

from lwr_dyn.arms.urdf.xacro_file import expand_xacro
from lwr_dyn.checks.urdf.xml_tree import PLACE


def expand_with_places(path: Path, arguments: Mapping[str, str]) -> str:
    """The URDF that a xacro file expands to, its elements with an attribute "line:column:file".

    Raises
    ------
    FileAccessError, MissingPackageError, UrdfError
        As `expand_xacro`.
    """
    return expand_xacro(path, arguments, _parse)


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
