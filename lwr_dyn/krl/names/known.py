"""Names that need no declaration: KUKA's own, those of option packages, and those of a user's file, as records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from lwr_dyn.krl.names.types import Type


@dataclass(frozen=True, slots=True)
class FunctionParameter:
    """A parameter of a function of the controller; `optional` may be left out."""

    name: str
    type: Type
    mode: str = "IN"
    """IN or OUT."""
    optional: bool = False

    def __str__(self) -> str:
        return f"{self.type} {self.name}:{self.mode}{'?' if self.optional else ''}"


@dataclass(frozen=True, slots=True)
class Function:
    """A function or subprogram of every controller, or of an option package."""

    returns: Type | None
    """None for a subprogram without a value."""
    parameters: tuple[FunctionParameter, ...] = ()
    open: bool = False
    """Whether it takes any more arguments."""

    @property
    def least(self) -> int:
        """Fewest arguments."""
        return sum(not p.optional for p in self.parameters)

    @property
    def most(self) -> int:
        """Most arguments."""
        return 99 if self.open else len(self.parameters)


@dataclass(frozen=True, slots=True)
class Origin:
    """Who brings a name: a package ("KSS" is the kernel), its group, and a version of KSS that has it, where known."""

    title: str
    package: str
    kss: str | None = None

    def __str__(self) -> str:
        version = f" {self.kss}" if self.kss else ""
        return f"{self.package}{version}: {self.title}" if self.package == "KSS" else f"{self.package}: {self.title}"


@dataclass(frozen=True, slots=True, eq=False)
class KnownNames:
    """Names by kind, in capitals; `structures` and `enums` as declared, the `open` ones have more members."""

    functions: dict[str, Function] = field(default_factory=dict)
    variables: dict[str, Type] = field(default_factory=dict)
    structures: dict[str, Mapping[str, Type]] = field(default_factory=dict)
    enums: dict[str, frozenset[str]] = field(default_factory=dict)
    open: set[str] = field(default_factory=set)
    """Structures and enumerations with members that are not listed."""
    origins: dict[str, Origin] = field(default_factory=dict)

    def copy(self) -> KnownNames:
        """Names of its own, equal to these."""
        return KnownNames(
            dict(self.functions), dict(self.variables), dict(self.structures), dict(self.enums), set(self.open),
            dict(self.origins),
        )  # fmt: skip

    def text(self, name: str) -> str | None:
        """One line about a name: its declaration and its origin; None for an unknown name."""
        key = name.upper()
        if key in self.functions:
            said = _function_text(key, self.functions[key])
        elif key in self.variables:
            said = f"{self.variables[key]} {key}"
        elif key in self.structures:
            said = f"STRUC {key} {', '.join(f'{kind} {part}' for part, kind in self.structures[key].items())}"
        elif key in self.enums:
            said = f"ENUM {key} {', '.join(sorted(self.enums[key]))}"
        else:
            return None
        more = ", ..." if key in self.open else ""
        origin = self.origins.get(key)
        return f"{said}{more} ({origin})" if origin else said + more


def _function_text(name: str, x: Function) -> str:
    parameters = [str(p) for p in x.parameters] + (["..."] if x.open else [])
    return f"{'DEF' if x.returns is None else f'DEFFCT {x.returns}'} {name}({', '.join(parameters)})"
