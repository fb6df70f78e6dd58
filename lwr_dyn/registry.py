"""Registries: what can be chosen by name. A row is imported when it is asked for; other packages can add rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import entry_points
from importlib.util import find_spec
from types import MappingProxyType
from typing import Any, Generic, TypeVar, cast

from lwr_dyn.errors import MissingPackageError, UnknownNameError

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Row:
    """One choice: "module:attribute", one line of help, the pip extra it needs, and facts that its users check."""

    target: str
    about: str
    extra: str = ""
    facts: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def module(self) -> str:
        """The module that holds the target."""
        return self.target.partition(":")[0]

    @property
    def is_installed(self) -> bool:
        """Whether the row's own module is there; the packages it imports may still be missing."""
        try:
            return find_spec(self.module) is not None
        except ModuleNotFoundError:  # its parent package is missing
            return False


@dataclass(frozen=True, slots=True)
class Registry(Generic[T]):
    """Choices of one kind by name: own rows, then entry points of the group "lwr_dyn.KIND".

    An own name cannot be replaced by an entry point.
    """

    kind: str
    rows: Mapping[str, Row]

    def __getitem__(self, name: str) -> Row:
        if name in self.rows:
            return self.rows[name]
        added = self._added()
        if name not in added:
            raise UnknownNameError(self.kind, name, (*self.rows, *added))
        return added[name]

    @property
    def names(self) -> tuple[str, ...]:
        """All names, this package's own first."""
        return (*self.rows, *self._added())

    def load(self, name: str) -> T:
        """The object that a row names.

        Raises
        ------
        UnknownNameError
            No row of that name.
        MissingPackageError
            Its module, or a package that the module needs, is not installed; names the extra.
        """
        row = self[name]
        try:
            return cast(T, getattr(import_module(row.module), row.target.partition(":")[2]))
        except ModuleNotFoundError as fault:
            raise MissingPackageError(fault.name or row.module, row.extra) from None

    def _added(self) -> dict[str, Row]:
        points = entry_points(group=f"lwr_dyn.{self.kind}")
        return {
            point.name: Row(point.value, f"from {point.dist.name if point.dist else point.module}")
            for point in points
            if point.name not in self.rows
        }
