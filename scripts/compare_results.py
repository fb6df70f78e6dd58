"""Compare the results of two runs of `lwr-dyn reproduce all`: exit 1 when they differ.

python scripts/compare_results.py BEFORE AFTER [PAPER ...]

Texts, verdicts, whole numbers and names must be the same; floats to 1e-12 relative. What rounding alone leaves
(residuals, differences of two ways to one number) must stay below `ROUNDING`. Renamed keys and texts stand in
tests/reproduction/renamed_keys.toml, if there are any.
"""

from __future__ import annotations

import argparse
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

RELATIVE = 1e-12
ROUNDING = 1e-9
"""Two numbers below this are both what rounding leaves."""
RENAMED = Path(__file__).resolve().parent.parent / "tests" / "reproduction" / "renamed_keys.toml"


def differences(before: Any, after: Any, place: str = "") -> Iterator[str]:
    """Every place where two parsed JSON values differ."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in sorted({*before, *after}):
            if key in before and key in after:
                yield from differences(before[key], after[key], f"{place}.{key}")
            else:
                yield f"{place}.{key}: only {'before' if key in before else 'after'}"
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for i, (x, y) in enumerate(zip(before, after, strict=True)):
            yield from differences(x, y, f"{place}[{i}]")
    elif not _same(before, after):
        yield f"{place}: {str(before)[:200]} -> {str(after)[:200]}"


def _same(before: Any, after: Any) -> bool:
    if not (isinstance(before, float) and isinstance(after, float)):
        return type(before) is type(after) and bool(before == after)
    sizes = abs(before), abs(after)
    return abs(before - after) <= RELATIVE * max(sizes) or max(sizes) < ROUNDING


def renamed(record: Any, names: dict[str, str]) -> Any:
    """A record with its keys and texts under their new names."""
    if isinstance(record, dict):
        return {names.get(key, key): renamed(value, names) for key, value in record.items()}
    if isinstance(record, list):
        return [renamed(value, names) for value in record]
    return names.get(record, record) if isinstance(record, str) else record


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("papers", nargs="*", help="all of `before` if not given")
    options = parser.parse_args()
    names = tomllib.loads(RENAMED.read_text(encoding="utf-8")) if RENAMED.is_file() else {}
    count = 0
    for paper in options.papers or sorted(path.parent.name for path in options.before.glob("*/results.json")):
        before, after = (json.loads((f / paper / "results.json").read_text()) for f in (options.before, options.after))
        for line in differences(renamed(before, names), after):
            print(f"{paper}{line}")
            count += 1
    print(f"{count} differences")
    return 1 if count else 0


if __name__ == "__main__":
    raise SystemExit(main())
