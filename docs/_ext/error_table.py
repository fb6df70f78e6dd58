"""The errors of the package with their built-in parents and exit codes."""

import importlib
import pkgutil
from pathlib import Path

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError


def errors_text(root: Path) -> str:
    """A table of all errors, by name."""
    for module in pkgutil.walk_packages(lwr_dyn.__path__, "lwr_dyn."):
        if module.name.endswith((".errors", ".check_errors")):
            importlib.import_module(module.name)
    rows = sorted(below(LwrDynError), key=lambda error: error.__name__)
    lines = ["| error | is also a | exit code | when |", "|---|---|---|---|"]
    for error in rows:
        parents = [base.__name__ for base in error.__mro__ if base.__module__ == "builtins"]
        also = next((name for name in parents if name not in ("Exception", "BaseException", "object")), "Exception")
        when = (error.__doc__ or "").strip().split("\n\n")[0].replace("\n", " ").replace("|", "\\|")
        lines.append(f"| `{error.__name__}` | `{also}` | {error.exit_code} | {' '.join(when.split())} |")
    return "\n".join(lines)


def below(error: type[LwrDynError]) -> list[type[LwrDynError]]:
    """An error and all that descend from it."""
    return [error, *(each for child in error.__subclasses__() for each in below(child))]
