"""Write the schemas of `--json` in lwr_dyn/cli/schemas from the documents of small examples, or check them.

python scripts/build_schemas.py            write
python scripts/build_schemas.py --check    list those that are not fresh; exit 1 when there are any
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import lwr_dyn
from lwr_dyn.cli.main import group, schema_file
from lwr_dyn.foundation.document import Document
from lwr_dyn.identification.logs.joint_log import log_of_run
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import motion_document

BENT = (0.0, 0.5, 0.0, -1.0, 0.0, 0.5, 0.0)


class _Found(Exception):  # noqa: N818
    """The document that a command was about to print."""


def printed(line: str) -> Callable[[], Document]:
    """The document that a command line prints."""

    def found() -> Document:
        def stop(document: Document) -> None:
            raise _Found(document)

        whole, Document.record = Document.record, stop  # type: ignore[method-assign, assignment]
        try:
            group.main(args=[*line.split(), "--json"], prog_name="lwr-dyn", standalone_mode=False)
        except _Found as one:
            return one.args[0]
        finally:
            Document.record = whole  # type: ignore[method-assign]
        raise AssertionError(f"{line}: prints no document")

    return found


def motion() -> Document:
    """A fit to two seconds of a swing."""
    arm = lwr_dyn.load("lwr4plus", "physical")
    swing = lwr_dyn.reference("point-to-point", arm, start=BENT, end=np.add(BENT, 0.6), duration=2.0)
    log = log_of_run(lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), swing))
    found = identify_motion([log], arm)
    return motion_document(found, robot=arm.name, unseen=found.validated_on([log]))


def compare() -> Document:
    """Two short runs."""
    arm = lwr_dyn.load("lwr4plus", "physical")
    hold = lwr_dyn.reference("hold", arm, q=BENT, duration=0.01)
    runs = [lwr_dyn.simulate(arm, lwr_dyn.controller(name, arm), hold) for name in ("pid", "pd-gravity")]
    return lwr_dyn.compare(*runs).document


def krl_check() -> Document:
    """A program."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "made.src"
        path.write_text("DEF made()\n$TOOL = $NULLFRAME\nEND\n", encoding="utf-8")
        return printed(f"krl check {path} --no-motion")()


def krl_diff() -> Document:
    """Two states of a program."""
    with TemporaryDirectory() as folder:
        before, after = (Path(folder) / f"{name}.src" for name in ("before", "after"))
        for path, speed in ((before, 10), (after, 20)):
            path.write_text(f"DEF {path.stem}()\n$VEL_AXIS[1] = {speed}\nEND\n", encoding="utf-8")
        return printed(f"krl diff {before} {after}")()


EXAMPLES: Mapping[str, Callable[[], Document]] = {
    "check": printed("check lwr4plus"),
    "compare": compare,
    "dh": printed("dh kr30ha --convention modified"),
    "fk": printed("fk kr30ha --axes-deg A2=-90,A3=90"),
    "krl check": krl_check,
    "krl diff": krl_diff,
    "lint": printed("lint wam7"),
    "list": printed("list"),
    "conventions": printed("conventions wam7"),
    "excite": printed("excite lwr4plus --reading physical --starts 1 --duration 5"),
    "gains": printed("gains lwr4plus"),
    "identify motion": motion,
    "kernels": printed("kernels kr30ha"),
    "margins": printed("margins lwr4plus --reading physical --q-deg 0,30,0,-60,0,30,0"),
    "parity": printed("parity wam7 --engine pinocchio"),
    "sensitivity": printed("sensitivity kr30ha --task joint-move --poses 5 --rate 100"),
}
"""Command -> a document of it that has all its parts."""

BY_HAND = frozenset({
    "identify-elastic", "identify-friction", "identify-payload", "identify-table", "ik",
    "krl-run", "reproduce", "simulate", "sweep", "tune",
})  # fmt: skip
"""Schemas that are not generated yet: what their commands print is no document."""


def differences() -> dict[Path, str]:
    """File -> what it should be, where it is not."""
    wanted = {
        Path(str(schema_file(name))): json.dumps(one().schema(), indent=1) + "\n" for name, one in EXAMPLES.items()
    }
    there = {path: path.read_text(encoding="utf-8") for path in wanted if path.is_file()}
    return {path: text for path, text in wanted.items() if there.get(path) != text}


def unlisted() -> list[str]:
    """Schemas that no list has, and those of a list that are not there."""
    listed = {name.replace(" ", "-") for name in EXAMPLES} ^ BY_HAND
    return sorted({path.stem for path in Path(str(schema_file("x"))).parent.glob("*.json")} ^ listed)


def main(arguments: list[str] | None = None) -> int:
    check = "--check" in (sys.argv[1:] if arguments is None else arguments)
    stale, odd = differences(), unlisted()
    for path, text in stale.items():
        if not check:
            path.write_text(text, encoding="utf-8")
    lines = [f"{'stale' if check else 'written'}: {path.name}" for path in stale]
    lines += [f"in no list, or missing: {name}" for name in odd]
    print("\n".join(lines) or f"fresh: {len(EXAMPLES)} schemas, {len(BY_HAND)} by hand")
    return int(bool(odd) or (check and bool(stale)))


if __name__ == "__main__":
    sys.exit(main())
