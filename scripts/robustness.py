"""The robustness study of docs/robustness.md: its runs, their numbers in docs/robustness.json, the tables in the page.

python scripts/robustness.py --out FOLDER      the study, 35 minutes of one core; begun again it resumes
python scripts/robustness.py --page            the page alone, from the numbers that are there
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]
import robustness_runs as runs  # noqa: E402
from ranking import folded  # noqa: E402

from lwr_dyn.foundation.files import write_file  # noqa: E402
from lwr_dyn.foundation.version import VERSION  # noqa: E402
from lwr_dyn.studies.sweep.intervals import quantile_of, share_of  # noqa: E402

PAGE, NUMBERS = ROOT / "docs" / "robustness.md", ROOT / "docs" / "robustness.json"
STUDY = ROOT / "scripts" / "studies" / "robustness.toml"
TUNE = ("--law", "inverse-dynamics", "--gain", "omega-n=10:250", "--gain", "xi=0.5:2", "--runs", "512",
        "--population", "12", "--generations", "6", "--check-runs", "2000", "--front", "0")  # fmt: skip
PLACE = re.compile(r"<!-- robustness: (?P<what>[\w-]+) -->\n.*?<!-- robustness: end -->", re.DOTALL)
SHARES = (0.5, 0.9, 0.99, 0.999)
"""Quantiles over runs."""
TOLERANCE = 1e-3
"""[m]"""
AGAIN, SEED = 16, 26
"""Runs of each controller whose numbers are kept one by one, for the test that repeats them."""


def figures(columns: Mapping[str, Any], velocity: np.ndarray) -> dict[str, Any]:
    """The numbers of one controller, from the columns of its runs; errors in mm.

    A run with a flag has no number: it counts as above every number, and as outside the limits.
    """
    flags, known, delay = columns["flags"], columns["payload.known"] > 0.5, columns["loop.delay"]
    tip = {name: _worst(1e3 * columns[name], flags) for name in ("tip_max", "tip_rms")}
    cut = (columns["saturated_s"] > 0.0).any(axis=1)
    stop = (flags == "stop") | (columns["limit_margin"] <= 0.0).any(axis=1)
    fast = (columns["peak_speed"] > velocity).any(axis=1)
    lost = (flags != "") & (flags != "stop")
    keeps, inside = tip["tip_max"] <= 1e3 * TOLERANCE, ~(cut | stop | fast | lost)
    chosen = np.sort(np.random.default_rng(SEED).choice(flags.size, min(AGAIN, flags.size), replace=False))
    return {
        "runs": int(flags.size),
        **{name: [_quantile(x, share) for share in SHARES] for name, x in tip.items()},
        "keeps": _share(keeps),
        "inside": _share(inside),
        "stop": _share(stop), "cut": _share(cut), "fast": _share(fast), "lost": _share(lost),
        "known": _part(tip, keeps, known), "unknown": _part(tip, keeps, ~known),
        "by_delay": [
            {"delay": d, **_part(tip, keeps, delay == d), "inside": _share(inside[delay == d])} for d in range(5)
        ],
        "again": [{"run": int(columns["run"][i]), **{name: _number(x[i]) for name, x in tip.items()}} for i in chosen],
    }  # fmt: skip


def _worst(values: np.ndarray, flags: np.ndarray) -> np.ndarray:
    return np.where((flags != "") | np.isnan(values), np.inf, values)


def _part(tip: Mapping[str, np.ndarray], keeps: np.ndarray, which: np.ndarray) -> dict[str, Any]:
    return {
        "tip_max": [_quantile(tip["tip_max"][which], share) for share in SHARES],
        "tip_rms": [_quantile(tip["tip_rms"][which], share) for share in SHARES],
        "keeps": _share(keeps[which]),
    }


def _quantile(values: np.ndarray, share: float) -> dict[str, Any]:
    found = quantile_of(values, share)
    return {"share": share, **{name: _number(getattr(found, name)) for name in ("value", "low", "high")}}


def _share(which: np.ndarray) -> dict[str, Any]:
    found = share_of(int(which.sum()), which.size)
    return {"count": found.count, "runs": found.runs, "low": _digits(found.low), "high": _digits(found.high)}


def _number(x: float) -> float | None:
    """Six digits; None for a run without a number."""
    return _digits(float(x)) if np.isfinite(x) else None


def _digits(x: float) -> float:
    return float(f"{x:.6g}")


def parts(numbers: Mapping[str, Any]) -> dict[str, str]:
    """What stands in the places of the page."""
    found = numbers["controllers"]
    made = f"Runs made by lwr_dyn {numbers['version']}, commit {numbers['commit'][:10]}, {numbers['date']}."
    return {
        "made": made,
        "tuned": _tuned(numbers["tuned"]),
        "errors": _table(
            ["controller", "runs", *(f"{100 * share:g} %" for share in SHARES), "within 1 mm"],
            [[f"`{name}`", f"{one['runs']}", *map(_cell, one["tip_max"]), _percent(one["keeps"])]
             for name, one in found.items()],
        ),
        "rms": _table(
            ["controller", *(f"{100 * share:g} %" for share in SHARES)],
            [[f"`{name}`", *map(_cell, one["tip_rms"])] for name, one in found.items()],
        ),
        "limits": _table(
            ["controller", "inside all limits", "touches a position limit", "torque cut", "too fast", "lost"],
            [[f"`{name}`", *(_percent(one[key]) for key in ("inside", "stop", "cut", "fast", "lost"))]
             for name, one in found.items()],
        ),
        "known": _table(
            ["controller", "known: 50 %", "99 %", "within 1 mm", "unknown: 50 %", "99 %", "within 1 mm"],
            [[f"`{name}`", *(cell for part in ("known", "unknown") for cell in (
                _plain(one[part]["tip_max"][0]), _plain(one[part]["tip_max"][2]), _percent(one[part]["keeps"], False)))]
             for name, one in found.items()],
        ),
        "delay": _table(
            ["controller", *(f"{d} ms" for d in range(5))],
            [[f"`{name}`", *(f"{_plain(each['tip_max'][2])}; {_percent(each['inside'], False)}"
                             for each in one["by_delay"])] for name, one in found.items()],
        ),
        "alone": _table(
            ["controller", *(row["words"] for row in next(iter(found.values()))["alone"]), "first"],
            [[f"`{name}`", *(row["text"] for row in one["alone"]), one["first"]] for name, one in found.items()],
        ),
        "stick": _table(
            ["controller", "runs", "median", "least", "most"],
            [[f"`{name}`", f"{one['stick']['runs']}", *(f"{one['stick'][key]:+.1%}".replace("%", " %")
                                                       for key in ("median", "least", "most"))]
             for name, one in found.items()],
        ),
    }  # fmt: skip


def _tuned(one: Mapping[str, Any]) -> str:
    """The gains that were given and those that were found, on runs that the search has not seen."""
    rows = []
    for name in ("given", "found"):
        aim, use = ([None if x is None else f * x for x in one["check"][name][key].values()]
                    for key, f in (("aim", 1e3), ("torque_use", 100.0)))  # fmt: skip
        cells = (_cell(dict(zip(("value", "low", "high"), numbers, strict=True))) for numbers in (aim, use))
        rows.append([name, *(f"{x:.4g}" for x in one[name].values()), *cells])
    head = [
        "gains",
        *(path.partition(".")[2] for path in one["given"]),
        "99 % of the largest error [mm]",
        "torque use [%]",
    ]
    ratio, words = one["check"]["ratio"], f"lwr-dyn tune scripts/studies/{STUDY.name} {' '.join(TUNE)}"
    kept = "kept" if one["check"]["keeps_bound"] else "NOT kept"
    return (
        f"{_table(head, rows)}\n\nFound over given: {ratio['value']:.3g} ({ratio['low']:.3g} to {ratio['high']:.3g}); "
        f"the bound, 100 % of the torque limits in 99 % of them, is {kept} there.\n\n```text\n{folded(words)}\n```"
    )


def _cell(one: Mapping[str, Any]) -> str:
    """A quantile with its interval; "none" where it reaches into runs that have no number."""
    if one["value"] is None:
        return "none"
    ends = ("-" if x is None else f"{x:.4g}" for x in (one["low"], one["high"]))
    return f"{one['value']:.4g} ({' to '.join(ends)})"


def _plain(one: Mapping[str, Any]) -> str:
    return "none" if one["value"] is None else f"{one['value']:.3g}"


def _percent(one: Mapping[str, Any], interval: bool = True) -> str:
    value, low, high = (
        f"{x:.6g}" if x > 99.5 else f"{x:.3g}"
        for x in (100 * one["count"] / one["runs"], 100 * one["low"], 100 * one["high"])
    )
    return f"{value} % ({low} to {high})" if interval else f"{value} %"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(cells)} |" for cells in [head, ["---"] * len(head), *rows])


def filled(page: str, numbers: Mapping[str, Any]) -> str:
    """The page with its places filled from the numbers."""
    texts = parts(numbers)
    return PLACE.sub(
        lambda found: f"<!-- robustness: {found['what']} -->\n{texts[found['what']]}\n<!-- robustness: end -->", page
    )


def main() -> None:
    """As the module says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", metavar="FOLDER", help="of the results; those that are there are kept")
    parser.add_argument("--page", action="store_true", help="fill the page only")
    parser.add_argument("--threads", type=int, default=1)
    given = parser.parse_args()
    if not given.page:
        if given.out is None:
            parser.error("--out FOLDER, or --page")
        made = runs.made(STUDY, Path(given.out), given.threads)
        commit = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, stdout=subprocess.PIPE, check=True, text=True)
        numbers = {
            "version": VERSION, "commit": commit.stdout.strip(), "date": datetime.now(UTC).date().isoformat(),
            "study": made.study.digest, "tuned": runs.tuned(STUDY, TUNE),
            "controllers": {
                name: {**figures(columns, made.velocity), **runs.alone(made, name), "stick": runs.stick(made, name)}
                for name, columns in made.columns.items()
            },
        }  # fmt: skip
        write_file(NUMBERS, json.dumps(numbers, indent=1) + "\n")
    write_file(PAGE, filled(PAGE.read_text("utf-8"), json.loads(NUMBERS.read_text("utf-8"))))


if __name__ == "__main__":
    main()
