"""The built-in names by kind: those of kernel.toml and options.toml, without the names of a user's file."""

from collections.abc import Mapping

from lwr_dyn.krl.names.known import Function
from lwr_dyn.krl.names.names_file import known_names
from lwr_dyn.krl.names.types import Type

_NAMES = known_names()
SYSTEM: Mapping[str, Type] = {name: kind for name, kind in _NAMES.variables.items() if name.startswith("$")}
"""System variables whose type is known here; any other name that begins with $ is one of unknown type."""
CONFIG: Mapping[str, Type] = {name: kind for name, kind in _NAMES.variables.items() if not name.startswith("$")}
"""Other variables: those of the standard `$config.dat` and of option packages."""
FUNCTIONS: Mapping[str, Function] = _NAMES.functions
"""Functions and subprograms, by name in capitals."""
STRUCTURES: Mapping[str, Mapping[str, Type]] = _NAMES.structures
"""Structures that need no declaration: name -> component -> its type."""
ENUMS: Mapping[str, frozenset[str]] = _NAMES.enums
"""Enumerations that need no declaration."""
