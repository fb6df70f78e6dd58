"""Which test files are a module's own: by its name, or by its row in `covered.toml`."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path

TESTS = Path(__file__).resolve().parent


def covered(tests: Path = TESTS) -> dict[str, list[str]]:
    """The table: module, as `dynamics/newton_euler` -> its test files, relative to `tests`."""
    table: dict[str, list[str]] = tomllib.loads((tests / "covered.toml").read_text(encoding="utf-8"))["covered"]
    return table


def named_after(module: str, tests: Path = TESTS) -> list[Path]:
    """`test_<module>.py` and `test_<module>_<aspect>.py` in the folder that mirrors the module's.

    A file whose name begins with that of a longer module beside it belongs to that one.
    """
    place, name = tests / module, Path(module).name
    longer = [p.stem for p in (tests.parent / "lwr_dyn" / module).parent.glob(f"{name}_*.py")]
    found = []
    for path in sorted(place.parent.glob(f"test_{name}*.py")):
        aspect = path.stem.removeprefix("test_")
        if aspect == name or (aspect.startswith(f"{name}_") and not aspect.startswith(tuple(longer))):
            found.append(path)
    return found


def own_tests(module: str, tests: Path = TESTS, table: Mapping[str, Sequence[str]] | None = None) -> list[Path]:
    """All of a module's own, those of its name first; a file that its row names need not exist."""
    rows = covered(tests) if table is None else table
    return list(dict.fromkeys([*named_after(module, tests), *(tests / name for name in rows.get(module, ()))]))
