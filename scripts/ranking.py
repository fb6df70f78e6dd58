"""Run the ranking of docs/ranking.md again: four commands, their numbers in docs/ranking.json, the tables in the page.

python scripts/ranking.py                   all four, then the page (a quarter of an hour on two free cores)
python scripts/ranking.py ist-physical      one of them; the others keep their numbers
python scripts/ranking.py --page            the page alone, from the numbers that are there
"""

from __future__ import annotations

import argparse
import json
import re
import shlex
import subprocess
import sys
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from lwr_dyn.foundation.files import write_file
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.studies.compare.comparison import cross_table

ROOT = Path(__file__).resolve().parent.parent
PAGE, NUMBERS = ROOT / "docs" / "ranking.md", ROOT / "docs" / "ranking.json"
PLACE = re.compile(r"<!-- ranking: (?P<what>[\w-]+) -->\n.*?<!-- ranking: end -->", re.DOTALL)
PEAK = 1.7
CONTROLLERS = (
    "pd-gravity:velocity-error", "pid:velocity-error", "motor-pd", "inverse-dynamics", "inverse-dynamics+friction",
    "inverse-dynamics+motor-side", "robust", "adaptive{0}", "adaptive{0}:adapt-friction", "joint-impedance",
    "cartesian-impedance",
)  # fmt: skip
ADAPTS = {"physical": "", "computed": ":adapt-gain=3"}
"""With the default, 10, no omega_n keeps the margin on light rotors."""
PLANTS = (
    "nominal", "scale=1.1", "payload=3", "payload=7", "friction", "noise=1e-5", "delay=1", "delay=2", "delay=4",
    "payload=3+friction+noise=1e-5+delay=1", "elastic", "elastic+payload=3", "elastic+encoders=link",
)  # fmt: skip
FEW = ("nominal", "payload=3", "friction", "payload=3+friction+noise=1e-5+delay=1", "elastic")
"""On the longer task."""
MOVE = ("--from-deg", "0,30,0,-60,0,30,0", "--to-deg", "60,60,30,-90,60,-30,90", "--duration", "2.5")
TASKS = {"ist": ("--task", "ist-clear"), "move": ("--task", "point-to-point", *MOVE)}
PLANTS_OF = {"ist": FEW, "move": PLANTS}
READINGS = ("physical", "computed")
STUDIES = tuple(f"{task}-{reading}" for task in TASKS for reading in READINGS)
FIGURES = (
    "typed",
    "controller",
    "plant",
    "tip_rms_mm",
    "tip_max_mm",
    "peak_torque",
    "torque_cut_share",
    "unstable",
    "best",
)
"""Of each run."""


def command(study: str) -> tuple[str, ...]:
    """The arguments of `lwr-dyn` that make a study."""
    task, _, reading = study.partition("-")
    return (
        "compare", "lwr4plus", "--reading", reading, *TASKS[task], "--twice", "--tuned", f"{PEAK:g}",
        "--friction-share", "0.01", "--controllers", ",".join(controllers(reading)),
        "--plants", ",".join(PLANTS_OF[task]),
    )  # fmt: skip


def controllers(reading: str) -> list[str]:
    """As typed."""
    return [one.format(ADAPTS[reading]) for one in CONTROLLERS]


def measured(study: str, processes: int) -> dict[str, Any]:
    """The numbers of a study, run now."""
    arguments = [*command(study), "--jobs", str(processes), "--json"]
    done = subprocess.run([sys.executable, "-m", "lwr_dyn", *arguments], stdout=subprocess.PIPE, check=True, text=True)
    found = json.loads(done.stdout)
    commit = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, stdout=subprocess.PIPE, check=True, text=True)
    return {
        "command": f"lwr-dyn {shlex.join(command(study))}", "version": VERSION, "commit": commit.stdout.strip(),
        "date": datetime.now(UTC).date().isoformat(), "title": found["title"], "tuned": found["tuned"],
        "failures": found["failures"], "runs": [{name: run[name] for name in FIGURES} for run in found["runs"]],
    }  # fmt: skip


def parts(numbers: Mapping[str, Any]) -> dict[str, str]:
    """What stands in the places of the page."""
    out = {"gains": gains(numbers)}
    for study, record in numbers.items():
        made = f"Made by lwr_dyn {record['version']}, commit {record['commit'][:10]}, {record['date']}"
        failures = "".join(f"\n- {one}" for one in grouped(record["failures"]))
        below = f"\n\nNo run, and why:\n{failures}" if failures else ""
        out[study] = f"{cross_table(record['runs'])}{below}\n\n{made}:\n\n```text\n{folded(record['command'])}\n```"
    return out


def grouped(failures: Sequence[str]) -> list[str]:
    """Failures with the same reason as one line: what their pairs have in common at the end, and how many they are."""
    of_reason: dict[str, list[list[str]]] = {}
    for one in failures:
        pair, _, reason = one.partition(": ")
        of_reason.setdefault(reason, []).append(pair.split(", "))
    out = []
    for reason, pairs in of_reason.items():
        same: list[str] = []
        for words in zip(*(reversed(pair) for pair in pairs), strict=False):
            if len(set(words)) > 1:
                break
            same.insert(0, words[0])
        out.append(f"{', '.join(same)}{f' ({len(pairs)} pairs)' if len(pairs) > 1 else ''}: {reason}")
    return out


def gains(numbers: Mapping[str, Any]) -> str:
    """omega_n of each law, and what stands in the way of a larger one."""
    studies = [study for study in STUDIES if study in numbers]
    lines = [["controller", *studies], ["---"] * (1 + len(studies))]
    for one in CONTROLLERS:
        typed = [one.format(ADAPTS[study.partition("-")[2]]) for study in studies]
        cells = [numbers[study]["tuned"].get(name) for study, name in zip(studies, typed, strict=True)]
        words = [
            f"{x['omega_n']:.3g} ({x['case'].replace(', 1000 Hz', '').replace(' (motor encoders)', '')})"
            if x
            else "none"
            for x in cells
        ]
        lines.append([f"`{one.format('')}`", *words])
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def folded(text: str, width: int = 110) -> str:
    """A command on several lines, each but the last with a backslash at its end."""
    lines = [""]
    for word in text.split(" "):
        if lines[-1] and len(lines[-1]) + len(word) >= width:
            lines.append("   ")
        lines[-1] += f"{' ' if lines[-1] else ''}{word}"
    return " \\\n".join(lines)


def filled(page: str, numbers: Mapping[str, Any]) -> str:
    """The page with its places filled from the numbers."""
    texts = parts(numbers)
    return PLACE.sub(
        lambda found: f"<!-- ranking: {found['what']} -->\n{texts[found['what']]}\n<!-- ranking: end -->", page
    )


def main() -> None:
    """As the module says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("studies", nargs="*", metavar="STUDY", help=", ".join(STUDIES))
    parser.add_argument("--page", action="store_true", help="fill the page only")
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    for unknown in set(given.studies) - set(STUDIES):
        parser.error(f"no study {unknown}; known: {', '.join(STUDIES)}")
    numbers = json.loads(NUMBERS.read_text("utf-8")) if NUMBERS.is_file() else {}
    for study in () if given.page else given.studies or STUDIES:
        numbers[study] = measured(study, given.processes)
        write_file(NUMBERS, json.dumps({key: numbers[key] for key in STUDIES if key in numbers}, indent=1) + "\n")
    write_file(PAGE, filled(PAGE.read_text("utf-8"), numbers))


if __name__ == "__main__":
    main()
