"""What other programs say of the same planted faults: a table of kind x program.

    pip install urdf-validator==1.6.0 urdf_parser_py mujoco drake; scripts/linter_peers.py --arms FOLDER

Faults are drawn by seed from the good arms of a part whose files MuJoCo compiles as they are (it reads no DAE). Any
change of what a program says of a file counts as found, wherever it points; of `lwr_dyn` a new error or warning
anywhere in the file counts. Each verdict is asked of a process of its own: Drake aborts on exchanged limits.
"""

from __future__ import annotations

import argparse
import io
import json
import logging
import os
import re
import sys
import tempfile
from collections.abc import Callable, Iterable
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from lwr_dyn.foundation.version import VERSION  # noqa: E402
from tests.checks.urdf.detection import findings_of  # noqa: E402
from tests.checks.urdf.fault_plants import FaultPlant, fault_kinds, plants  # noqa: E402
from tests.checks.urdf.judged_arms import ARMS_FOLDER, judged_arms  # noqa: E402

HALVES = ("tuning", "unused", "fresh")
_NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?", re.IGNORECASE)

Verdict = Callable[[str, Path], frozenset[str]]
"""What a program says of a URDF text that stands for a file: lines without their numbers."""


def lines_of(text: str) -> frozenset[str]:
    """Lines without their numbers."""
    return frozenset(_NUMBER.sub("#", line.strip()) for line in text.splitlines() if line.strip())


def lwr_dyn_says(text: str, path: Path) -> frozenset[str]:
    """Errors and warnings of the linter by code and place."""
    return frozenset(f"{f.code} {f.level} {f.subject}" for f in findings_of(text, path) if f.level != "note")


def urdf_validator_says(text: str, path: Path) -> frozenset[str]:
    """urdf-validator's lines with a warning or failure."""
    from urdf_validator_main.cli import main

    out = io.StringIO()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "robot.urdf"
        file.write_text(text, encoding="utf-8")
        sys.argv = ["urdf_validate", str(file), "--output-dir", folder]
        with redirect_stdout(out), redirect_stderr(out):
            try:
                code: object = main()
            except SystemExit as end:
                code = end.code
            except Exception as fault:  # a program under test may raise anything
                code = f"{type(fault).__name__} {fault}"
    said = (line for line in out.getvalue().splitlines() if re.search("WARN|FAIL|ERROR|INVALID|missing|Unknown", line))
    counts = frozenset(line for line in out.getvalue().splitlines() if "[PHYSICS]" in line)
    return lines_of("\n".join([f"exit {code}", *said])) | counts


class _Kept(logging.Handler):
    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(record.getMessage())


def drake_says(text: str, path: Path) -> frozenset[str]:
    """Drake's errors and warnings."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    kept, logger = _Kept(), logging.getLogger("drake")
    logger.addHandler(kept)
    logger.propagate = False
    try:
        plant = MultibodyPlant(0.0)
        Parser(plant).AddModelsFromString(text, "urdf")
        plant.Finalize()
    except Exception as fault:
        kept.lines.append(str(fault))
    finally:
        logger.removeHandler(kept)
    return lines_of("\n".join(kept.lines))


def mujoco_says(text: str, path: Path) -> frozenset[str]:
    """MuJoCo's refusal."""
    import mujoco

    compiler = '<mujoco><compiler strippath="false" discardvisual="false" fusestatic="false"/></mujoco></robot>'
    try:
        mujoco.MjModel.from_xml_string(text.replace("</robot>", compiler))
    except Exception as fault:
        return lines_of(str(fault))
    return frozenset()


def pinocchio_says(text: str, path: Path) -> frozenset[str]:
    """Pinocchio's refusal."""
    import pinocchio

    try:
        pinocchio.buildModelFromXML(text)
    except Exception as fault:
        return lines_of(str(fault))
    return frozenset()


PROGRAMS: dict[str, tuple[str, str, Verdict]] = {
    "lwr_dyn": ("lwr_dyn", "lwr_dyn", lwr_dyn_says),
    "urdf-validator": ("urdf-validator", "urdf_validator_main.cli", urdf_validator_says),
    "Drake": ("drake", "pydrake.multibody.parsing", drake_says),
    "MuJoCo": ("mujoco", "mujoco", mujoco_says),
    "Pinocchio": ("pin", "pinocchio", pinocchio_says),
}
"""Name -> distribution, module, what it says."""


def compiled(half: str) -> list[tuple[str, str, Path, frozenset[str]]]:
    """Name, text, path and faulty links of the good arms of a part that are here and that MuJoCo compiles."""
    here = [arm for arm in judged_arms() if arm.half == half and arm.judgement == "good" and arm.is_as_judged]
    rows = [(arm.name, arm.text(), arm.path, frozenset(arm.faults)) for arm in here]
    return [row for row in rows if not apart(mujoco_says, row[1], row[2])]


def drawn(each: int, seed: int, half: str) -> Iterable[tuple[FaultPlant, str, Path]]:
    """Plants of every kind, drawn by seed, with the file's own text and path."""
    every = []
    for name, text, path, faults in compiled(half):
        found = list(plants(text, path, fault_kinds(), faults))
        print(f"{name}: {len(found)} plants", file=sys.stderr)
        every += [(plant, text, path) for plant in found]
    rng = Random(seed)
    for kind in fault_kinds():
        of_kind = [x for x in every if x[0].kind.name == kind.name]
        yield from rng.sample(of_kind, min(each, len(of_kind)))


def installed(names: Iterable[str]) -> dict[str, str]:
    """Name -> version of the programs that are here."""
    found = {}
    for name in names:
        try:
            found[name] = VERSION if name == "lwr_dyn" else version(PROGRAMS[name][0])
            import_module(PROGRAMS[name][1])  # once, not in each process that asks
        except PackageNotFoundError:
            print(f"{name} is not installed", file=sys.stderr)
    return found


def apart(says: Verdict, text: str, path: Path) -> frozenset[str]:
    """What a program says in a process of its own: some abort."""
    reader, writer = os.pipe()
    if not (pid := os.fork()):
        code = 1
        try:
            with open(os.devnull, "w", encoding="utf-8") as nothing, os.fdopen(writer, "w", encoding="utf-8") as out:
                os.dup2(nothing.fileno(), 2)
                json.dump(sorted(says(text, path)), out)
            code = 0
        finally:
            os._exit(code)
    os.close(writer)
    with os.fdopen(reader, encoding="utf-8") as source:
        said = source.read()
    _, status = os.waitpid(pid, 0)
    return frozenset(json.loads(said)) if status == 0 else frozenset({f"aborted, {os.waitstatus_to_exitcode(status)}"})


def table(each: int, seed: int, half: str) -> str:
    """Kind x program: how many of the drawn faults each sees."""
    versions = installed(PROGRAMS)
    counts: dict[str, dict[str, int]] = {}
    before: dict[tuple[str, Path], frozenset[str]] = {}
    for plant, text, path in drawn(each, seed, half):
        row = counts.setdefault(plant.kind.name, dict.fromkeys(["n", *versions], 0))
        row["n"] += 1
        for name in versions:
            says = PROGRAMS[name][2]
            if (name, path) not in before:
                before[name, path] = apart(says, text, path)
            row[name] += apart(says, plant.text, path) != before[name, path]
    heads = [f"{name} {number}" for name, number in versions.items()]
    lines = [f"| kind | n | {' | '.join(heads)} |", "|" + "---|" * (len(heads) + 2)]
    lines += [f"| {kind} | {' | '.join(str(x) for x in row.values())} |" for kind, row in counts.items()]
    total = [sum(row[name] for row in counts.values()) for name in ("n", *versions)]
    kinds = [sum(row[name] > row["n"] / 2 for row in counts.values()) for name in versions]
    lines += [
        f"| all | {' | '.join(map(str, total))} |",
        f"| kinds of which more than half | | {' | '.join(map(str, kinds))} |",
    ]
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=3, help="faults of each kind (default: 3)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--half", choices=HALVES, default=HALVES[-1])
    parser.add_argument("--arms", help=f"folder of the repositories (default: {ARMS_FOLDER})")
    options = parser.parse_args()
    if options.arms:
        os.environ[ARMS_FOLDER] = options.arms
    print(table(options.each, options.seed, options.half))
    return 0


if __name__ == "__main__":
    sys.exit(main())
