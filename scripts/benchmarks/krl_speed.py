"""Times of KRL: a change in the editor until its diagnoses, and real programs read and checked, first and again.

    python scripts/benchmarks/krl_speed.py [FOLDER] [--lines 100000] [--edits 9]

FOLDER holds one folder a repository of public programs, as `scripts/studies/krl_programs.py` takes it; without it only
invented files are timed. The server is a process of its own and the editor is scripted; its times include the 100 ms
that it waits after a change. "First" has empty caches, "again" those of the first time.
"""

from __future__ import annotations

import argparse
import random
import statistics
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from lwr_dyn.foundation.errors import FileAccessError  # noqa: E402
from lwr_dyn.krl.checks.static_checks import static_diagnostics  # noqa: E402
from lwr_dyn.krl.language.source import is_krl_file  # noqa: E402
from lwr_dyn.krl.project.program import load_project, program_in  # noqa: E402
from tests.krl.language_client import LanguageClient  # noqa: E402

LINES = 6000


def clean_text(lines: int = LINES) -> str:
    """A program without a fault: blocks, assignments and motions, no two lines alike."""
    block = "IF i < {n} THEN\n  x = x + {n}.5 * SIN(y)\n  $OUT[{out}] = TRUE\n  i = i + {n}\nELSE\n"
    block += "  LIN {{X {n}.1, Y {n}.2, Z 100, A 0, B 90, C 0}} C_DIS ;point {n}\nENDIF\n"
    head = "DEF clean( )\nDECL INT i\nDECL REAL x, y\ni = 0\nx = 0\ny = 0\n"
    return head + "".join(block.format(n=n, out=n % 100 + 1) for n in range((lines - 7) // 7)) + "END\n"


def unknown_text(lines: int = LINES) -> str:
    """A program with two unknown names in nearly every line."""
    return "DEF unknown( )\n" + "".join(f"name{n} = other{n} + 1\n" for n in range(lines - 2)) + "END\n"


def points_text(lines: int = LINES) -> str:
    """A program of motions to poses, as a CAM system writes it."""
    pose = "LIN {{X {x:.3f},Y {y:.3f},Z 100.0,A 0.0,B 90.0,C 0.0}} C_DIS\n"
    motions = (pose.format(x=0.37 * n, y=1.1 * (n % 97)) for n in range(lines - 2))
    return "DEF points( )\n" + "".join(motions) + "END\n"


def time_edits(text: str, edits: int) -> tuple[float, float, list[float]]:
    """[s] From the start of the server, and from opening a file, to its first diagnoses; of each change to its own."""
    rng, lines = random.Random(7), text.split("\n")
    with tempfile.TemporaryDirectory() as name:
        path = Path(name).resolve() / "a.src"
        with LanguageClient(path.parent) as client:
            opened = time.perf_counter()
            client.open(path, text)
            first = client.diagnostics(path)[0]
            changes = []
            for k in range(edits):
                new, i = list(lines), rng.randrange(10, len(lines) - 5)
                new[i] = f"{new[i]} ;edit {k}" if k % 2 else f"misspelt = {k}"
                sent = time.perf_counter()
                client.change(path, "\n".join(new))
                changes.append(client.diagnostics(path)[0] - sent)
            return first - client.began, first - opened, changes


def time_server(edits: int) -> None:
    """A row for each invented file."""
    print("\n### The server: time to diagnoses [ms]\n")
    print("| file | lines | start to first | open to first | change, median | largest |\n|---|---|---|---|---|---|")
    for what, text in (("clean", clean_text()), ("points", points_text()), ("12 000 unknown names", unknown_text())):
        start, opened, changes = time_edits(text, edits)
        shown = (start, opened, statistics.median(changes), max(changes))
        print(f"| {what} | {text.count(chr(10))} |", " | ".join(f"{1e3 * x:.0f}" for x in shown), "|", flush=True)


def check_all(folders: list[Path], most: int) -> tuple[int, int]:
    """Lines read and diagnoses found in the repositories, until there are so many lines."""
    lines = found = 0
    for folder in folders:
        if lines >= most:
            break
        try:
            project = load_project(folder)
        except FileAccessError:
            continue
        lines += sum(len(x.file.lines) for x in project.files)
        for module in project.modules:
            program = program_in(project, module)
            found += len(program.diagnostics) + len(static_diagnostics(program))
    return lines, found


def time_programs(folder: Path, most: int) -> None:
    """Rows for all repositories together, and for each one that is a whole backup."""
    print("\n### Read and checked, without motion [s]\n")
    print("| what | lines | diagnoses | first | again |\n|---|---|---|---|---|")
    folders = sorted(x for x in folder.iterdir() if x.is_dir())
    rows = [("programs", folders)] + [(f"backup {x.name}", [x]) for x in folders if is_backup(x)]
    with ProcessPoolExecutor(1, mp_context=get_context("spawn"), max_tasks_per_child=1) as fresh:
        for what, chosen in rows:
            lines, found, first, again = fresh.submit(first_and_again, chosen, most).result()
            print(f"| {what} | {lines} | {found} | {first:.2f} | {again:.2f} |", flush=True)


def first_and_again(folders: list[Path], most: int) -> tuple[int, int, float, float]:
    """Lines, diagnoses, and both times [s]; of a process that has read nothing yet."""
    times = []
    for _ in range(2):
        began = time.perf_counter()
        lines, found = check_all(folders, most)
        times.append(time.perf_counter() - began)
    return lines, found, times[0], times[1]


def is_backup(folder: Path) -> bool:
    """Whether it has R1/System and R1/Program, and 10 000 lines."""
    robots = [x for x in folder.rglob("R1") if (x / "System").is_dir() and (x / "Program").is_dir()]
    files = filter(is_krl_file, folder.rglob("*"))
    return bool(robots) and sum(x.read_bytes().count(b"\n") for x in files) >= 10_000


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--lines", type=int, default=100_000)
    parser.add_argument("--edits", type=int, default=9)
    options = parser.parse_args()
    time_server(options.edits)
    if options.folder is not None:
        time_programs(options.folder, options.lines)
