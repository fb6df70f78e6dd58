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


def of_folders(module: str, tests: Path = TESTS) -> list[str]:
    """The files that the rows of a module's folders name, the nearest folder's first."""
    text = (tests / "covered.toml").read_text(encoding="utf-8")
    table: dict[str, list[str]] = tomllib.loads(text).get("folders", {})
    return [name for folder in Path(module).parents for name in table.get(folder.as_posix(), ())]


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
    """All of a module's own, those of its name first; a file that its row names need not exist.

    Those of its folders, the commands that show what it makes, are added where the table is not given.
    """
    rows = covered(tests) if table is None else table
    further = [*rows.get(module, ()), *(of_folders(module, tests) if table is None else ())]
    return list(dict.fromkeys([*named_after(module, tests), *(tests / name for name in further)]))
