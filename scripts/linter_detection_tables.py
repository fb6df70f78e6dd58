"""Tables of what the linter found: by kind, by size, in all, and the false alarms; and verdicts as lines of JSON."""

import json
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence

from tests.checks.urdf.detection import Alarm, PlantVerdict
from tests.checks.urdf.fault_plants import fault_kinds

SIZES = {
    "two diagonals exchanged, ratio": (("exchanged",), (1.0, 1.5, 2.0, 3.0)),
    "com sign, shift / diameter": (("com sign",), (0.0, 0.1, 0.3)),
    "about the joint, m c^2 / largest moment": (("about the joint",), (0.0, 0.5, 2.0, 5.0)),
    "product signs, product / middle diagonal": (("product signs",), (0.0, 0.2, 0.4)),
    "products permuted, product / middle diagonal": (("products permuted",), (0.0, 0.2, 0.4)),
    "mirrored, shift / diameter": (("mirrored",), (0.0, 0.1, 0.3)),
    "inertial rpy + 90, ratio": (("inertial rpy + 90",), (1.0, 1.5, 2.0, 3.0)),
    "origin sign or axes, shift / diameter": (("origin sign", "origin axes"), (0.0, 0.1, 0.3, 1.0)),
}
"""Title -> beginnings or ends of the kinds, and the lower ends of the bins."""
LEVELS = ("error", "warning", "note")


def shares(verdicts: Sequence[PlantVerdict]) -> tuple[float, float, float]:
    """Found by an error; by an error or a warning; by any finding."""
    n = max(len(verdicts), 1)
    error, warning, note = (sum(v.seen(level) for v in verdicts) / n for level in LEVELS)
    return error, warning, note


def _row(title: str, verdicts: Sequence[PlantVerdict]) -> str:
    return f"| {title} | {len(verdicts)} | " + " | ".join(f"{100 * x:.1f}" for x in shares(verdicts)) + " |"


def table(title: str, groups: Iterable[tuple[str, Sequence[PlantVerdict]]]) -> str:
    """One row a group: plants, found by errors, + warnings, + notes [%]."""
    lines = [f"| {title} | n | error % | + warning % | + note % |", "|---|---|---|---|---|"]
    return "\n".join(lines + [_row(name, chosen) for name, chosen in groups if chosen])


def totals(verdicts: Sequence[PlantVerdict]) -> str:
    """Above the floors without the hopeless kinds, and all 73."""
    large = [v for v in verdicts if v.large]
    return table("planted", (("above the floors, without the hopeless kinds", large), ("all 73 kinds", verdicts)))


def by_kind(verdicts: Sequence[PlantVerdict]) -> str:
    """One row a kind; beside it the share of the large ones."""
    lines = ["| kind | n | error % | + warning % | + note % | above the floor: n | + warning % |", "|" + "---|" * 7]
    for kind in fault_kinds():
        chosen = [v for v in verdicts if v.kind == kind.name]
        large = [v for v in chosen if v.large]
        last = f"{len(large)} | {100 * shares(large)[1]:.1f}" if large else "- | -"
        name = f"{kind.name} (hopeless)" if kind.hopeless else kind.name
        lines += [f"{_row(name, chosen)} {last} |"] if chosen else []
    return "\n".join(lines)


def by_size(verdicts: Sequence[PlantVerdict]) -> str:
    """One row a bin of the sizes that decide."""
    groups = []
    for title, (words, ends) in SIZES.items():
        chosen = [v for v in verdicts if v.kind.startswith(words) or v.kind.endswith(words)]
        for low, up in zip(ends, (*ends[1:], float("inf")), strict=True):
            inside = [v for v in chosen if low <= v.size < up]
            groups.append((f"{title} {low:g} to {up:g}" if up < float("inf") else f"{title} > {low:g}", inside))
    return table("size", groups)


def by(key: Callable[[PlantVerdict], str], title: str, verdicts: Sequence[PlantVerdict]) -> str:
    """One row a value of a key, such as the arm."""
    names = sorted({key(v) for v in verdicts})
    return table(title, [(name, [v for v in verdicts if key(v) == name]) for name in names])


def alarm_lines(found: Sequence[Alarm], links: int) -> str:
    """False errors, links with a warning, and each alarm in a line."""
    errors = sum(a.level == "error" for a in found)
    warned = len({(a.arm, a.link) for a in found if a.level == "warning"})
    rate = f"1 in {links / warned:.1f}" if warned else "none"
    counts = ", ".join(f"{code} {n}" for code, n in Counter(a.code for a in found).most_common()) or "none"
    head = (
        f"{links} moving links judged good: {errors} errors; links with a warning: {warned} ({rate}); codes: {counts}"
    )
    return "\n".join([head, *(f"- {a.level} {a.arm} {a.link} {a.code}: {a.message}" for a in found)])


def to_record(verdict: PlantVerdict) -> str:
    """A line of JSON."""
    return json.dumps({name: getattr(verdict, name) for name in verdict.__dataclass_fields__})


def from_record(line: str) -> PlantVerdict:
    """A verdict of a line of JSON."""
    row: Mapping = json.loads(line)
    return PlantVerdict(**{**row, "codes": tuple(row["codes"])})
