"""Registries: what can be chosen by name. A row is imported when it is used; other packages can add rows.

A row names a factory. Keywords of the factory that are annotated with an `Option` can be set by users, in Python and on
the command line; their defaults stand in the factory's signature and nowhere else.
"""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import lru_cache
from importlib import import_module
from inspect import Parameter, signature
from types import MappingProxyType
from typing import Any, Generic, TypeVar, cast, get_type_hints

from lwr_dyn.foundation.errors import MissingPackageError, OptionError, UnknownNameError, needs_extra

T = TypeVar("T")
REQUIRED = Parameter.empty
"""The default of an option that must be given."""


class Quantity(Enum):
    """Kinds of values that Python takes in rad and m, and the command line in degrees (m for sliding joints)."""

    ANGLE = "an angle"
    JOINT_POSITIONS = "joint positions"
    ANGLES = "roll, pitch, yaw"
    POINT = "a point or a shift in space"


@dataclass(frozen=True, slots=True)
class Option:
    """Marks a keyword of a factory that users can set.

    def pid(arm: Arm, dynamics: Dynamics, *, xi: Annotated[float, Option(float, "Damping ratio.")] = 1.0) -> PID:
    """

    kind: Any  # bool, int, float or str, a `Quantity`, or the registry whose names are allowed
    help: str  # one line, with the unit
    flag: str = ""  # name on the command line; derived from the keyword if not given
    unless: str = ""  # keyword of the same factory that leaves this one without effect
    keyword: str = ""  # this and the default are read from the factory's signature
    default: Any = REQUIRED

    @property
    def flag_name(self) -> str:
        """The name on the command line without its dashes: `flag`, or derived from the keyword."""
        name = self.keyword.replace("_", "-")
        if self.kind in (Quantity.ANGLE, Quantity.ANGLES, Quantity.JOINT_POSITIONS):
            name = f"{name}-deg"
        elif self.kind is bool and self.default:
            name = f"no-{name}"
        return self.flag or name


def options_of(factory: Callable[..., Any]) -> dict[str, Option]:
    """The options of a factory by keyword, with their defaults.

    Raises `OptionError` for something that cannot be called, or an annotation that names something that is not imported
    at run time.
    """
    if not callable(factory):
        raise OptionError("factory", repr(factory), "a function")
    annotated = vars(factory).get("__init__") if isinstance(factory, type) else factory
    try:
        hints = get_type_hints(annotated, include_extras=True)
    except NameError as fault:
        raise OptionError(factory.__qualname__, f"annotation: {fault}", "names that are imported at run time") from None
    return {
        name: replace(mark, keyword=name, default=parameter.default)
        for name, parameter in signature(factory).parameters.items()
        for mark in getattr(hints.get(name), "__metadata__", ())
        if isinstance(mark, Option)
    }


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


@dataclass(frozen=True, slots=True)
class Registry(Generic[T]):
    """Choices of one kind by name: own rows, then entry points of the group "lwr_dyn.KIND".

    Another package adds a row in its pyproject.toml; an own name cannot be replaced:

        [project.entry-points."lwr_dyn.controller"]
        mine = "my_package.my_module:make_mine"
    """

    kind: str
    rows: Mapping[str, Row]

    def __getitem__(self, name: str) -> Row:
        if name in self.rows:
            return self.rows[name]
        added = self._added()
        if name not in added:
            raise UnknownNameError(self.kind.replace("_", " "), name, (*self.rows, *added))
        return added[name]

    @property
    def names(self) -> tuple[str, ...]:
        """All names, this package's own first."""
        return (*self.rows, *self._added())

    def load(self, name: str) -> T:
        """The object that a row names.

        Raises `UnknownNameError` for no row of that name, or a row of another package whose attribute does not exist;
        `MissingPackageError`, which names the extra, where its module or a package that this needs is not installed;
        `OptionError` for a module of another package that cannot be imported.
        """
        row, attribute = self[name], self[name].target.partition(":")[2]
        try:
            with needs_extra(row.extra):
                module = import_module(row.module)
        except MissingPackageError:
            raise
        except Exception as fault:
            if name in self.rows:
                raise
            broken = f"{row.module}: {type(fault).__name__}: {fault}"
            raise OptionError(f"{self.kind} {name}, {row.about}", broken, "a module that can be imported") from fault
        if not hasattr(module, attribute):
            raise UnknownNameError(f"attribute of {row.module}", attribute, ())
        return cast(T, getattr(module, attribute))

    def make(self, name: str, /, *arguments: Any, **options: Any) -> Any:
        """The result of a row's factory, called with these arguments and options.

        Raises as `load`, and `OptionError` for an option that the factory does not know, that is missing, or that
        another one leaves without effect.
        """
        factory = cast(Callable[..., Any], self.load(name))
        check_options(f"{self.kind} {name}", factory, len(arguments), options)
        return factory(*arguments, **options)

    def _added(self) -> dict[str, Row]:
        points = _entry_points(f"lwr_dyn.{self.kind}", *sys.path)
        return {
            point.name: Row(point.value, f"from {point.dist.name if point.dist else point.module}")
            for point in points
            if point.name not in self.rows
        }


@lru_cache(maxsize=1)
def _all_entry_points(*places: str) -> Any:
    """What the packages in these places offer; read once, since it opens a file of every package installed."""
    from importlib.metadata import entry_points  # not for --version

    return entry_points()


@lru_cache(maxsize=64)
def _entry_points(group: str, *places: str) -> Any:
    return _all_entry_points(*places).select(group=group)


def check_options(subject: str, factory: Callable[..., Any], given: int, options: Mapping[str, Any]) -> None:
    """Raise `OptionError` for options that a factory cannot take; its first `given` arguments are positional."""
    marked = options_of(factory)
    keywords = list(signature(factory).parameters.values())[given:]
    names = [p.name for p in keywords if p.kind is not Parameter.VAR_KEYWORD]
    if len(names) == len(keywords):
        for name in (name for name in options if name not in names):
            raise OptionError(name, f"no option of {subject}", ", ".join(names) or "none")
    for p in keywords:
        if p.default is REQUIRED and p.name in names and p.name not in options:
            raise OptionError(p.name, "not given", f"a value, which {subject} needs")
    for name, option in marked.items():
        if name in options and options.get(option.unless):
            raise OptionError(name, "would do nothing here", f"without {option.unless}")
