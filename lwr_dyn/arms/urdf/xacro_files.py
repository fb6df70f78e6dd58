"""A `.xacro` file is expanded to a URDF by the package `xacro`, which needs no ROS; its expressions by ours.

Folders of `$(find PACKAGE)` are sought beside the file and where ROS's environment points.
"""

import os
import re
from collections.abc import Callable, Mapping
from contextlib import ExitStack, redirect_stderr
from functools import partial
from pathlib import Path
from threading import RLock
from types import MappingProxyType
from typing import Any

from lwr_dyn.arms.urdf.xacro_bounds import stand_ins
from lwr_dyn.arms.urdf.xacro_expressions import ExpressionError
from lwr_dyn.foundation.errors import MissingPackageError, UrdfError
from lwr_dyn.foundation.files import read_bytes

_ALONE = RLock()
"""xacro keeps its state in its modules, and what stands in for its functions stands there for every thread."""
_LONGEST_MESSAGE = 600
_LONGEST_PACKAGE = 100_000
_NO_ARGUMENT = re.compile(r"Undefined substitution argument ([^\s)]+)")
"""What xacro says of an argument that has neither a value nor a default."""
UNTRUSTED = "numbers, names, operators, indices, listed functions; trust_xacro=True, --trust-xacro: all of Python"
"""What an expression of a file may hold that is not trusted."""


def expand_xacro(
    path: str | Path,
    arguments: Mapping[str, str] = MappingProxyType({}),
    parse: Callable[..., Any] | None = None,
    trust: bool = False,
) -> str:
    """The URDF that a xacro file expands to; its expressions are read by `Expressions`, with `trust` run as Python.

    `arguments` are values of its `<xacro:arg>`; `parse(inp, filename=None) -> xml.dom.minidom.Document` stands in for
    `xacro.parse`, for the file and all that it includes.

    Raises
    ------
    FileAccessError
        The file cannot be read.
    MissingPackageError
        xacro is not installed.
    UrdfError
        xacro refuses the file: what it says.
    """
    read_bytes(path, "a readable .xacro file")
    try:
        import xacro
        from xacro import substitution_args
    except ModuleNotFoundError:
        raise MissingPackageError("xacro", "urdf") from None
    try:
        with _ALONE, ExitStack() as stack, open(os.devnull, "w") as nowhere, redirect_stderr(nowhere):
            found = partial(_found, inside=Path(path), installed=substitution_args._eval_find)
            there: list[tuple[Any, str, Any]] = [(substitution_args, "_eval_find", found)]
            read = parse or xacro.parse
            there += [(xacro, "parse", read)] if trust else stand_ins(xacro, substitution_args, read)
            for module, name, stand_in in there:
                stack.callback(setattr, module, name, getattr(module, name))
                setattr(module, name, stand_in)
            return str(xacro.process_file(str(path), mappings=dict(arguments)).toxml())
    except Exception as fault:  # it evaluates the file's own expressions: anything can come out
        said = " ".join(str(fault).split()) or type(fault).__name__
        said = said if len(said) <= _LONGEST_MESSAGE else f"{said[:_LONGEST_MESSAGE]} ..."
        missing = _NO_ARGUMENT.search(said)
        if missing:
            allowed = f"--xacro-arg {missing[1]}:=VALUE, in Python xacro_args={{{missing[1]!r}: VALUE}}"
            raise UrdfError(str(path), "xacro", f"the argument {missing[1]} has no value", allowed) from None
        allowed = UNTRUSTED if isinstance(_cause(fault), ExpressionError) else "a file that `xacro` expands"
        raise UrdfError(str(path), "xacro", said, allowed) from None


def _cause(fault: BaseException) -> BaseException:
    """The error that xacro wrapped, if it did."""
    while isinstance(inner := getattr(fault, "exc", None), BaseException):
        fault = inner
    return fault


def _found(name: str, *, inside: Path, installed: Callable[[str], str]) -> str:
    """The folder of `$(find name)`."""
    try:
        return str(package_folder(name, inside) or installed(name))
    except ModuleNotFoundError:  # no ROS here
        where = "above or beside the file, or in a folder of ROS_PACKAGE_PATH"
        raise LookupError(f"the package {name} is not {where}") from None


def package_folder(name: str, inside: Path) -> Path | None:
    """The folder of a ROS package: above or beside a file, or where ROS's environment points; or None.

    Above the file a folder with another name counts too if its `package.xml` has this one.
    """
    listed = [Path(x) for x in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if x]
    listed += [Path(x) / "share" for x in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if x]
    above = Path(os.path.abspath(inside)).parents
    candidates = [found for folder in above for found in (folder, folder / name)]
    candidates += [folder / name for folder in listed]
    here = (found for found in candidates if found.name == name and found.is_dir())
    return next(here, None) or next((folder for folder in above if _package_name(folder) == name), None)


def _package_name(folder: Path) -> str:
    """The name in a folder's `package.xml`; empty where there is none."""
    file = folder / "package.xml"
    if not file.is_file():
        return ""
    with file.open(encoding="utf-8", errors="replace") as stream:
        text = stream.read(_LONGEST_PACKAGE)
    return text.partition("<name>")[2].partition("</name>")[0].strip()
