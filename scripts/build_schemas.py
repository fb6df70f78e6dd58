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
from lwr_dyn.cli.help_text import schema_file
from lwr_dyn.cli.main import group
from lwr_dyn.foundation.document import Document
from lwr_dyn.identification.elastic_joints import elastic_document, identify_elastic
from lwr_dyn.identification.friction.identify_friction import identify_friction
from lwr_dyn.identification.logs.joint_log import JointLog, log_of_run
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import MotionRule, motion_document
from lwr_dyn.identification.payload.identify_load import identify_load
from lwr_dyn.identification.payload.possible_load import load_document
from lwr_dyn.identification.slips.slip_tables import slip_document, table_against_log
from lwr_dyn.identification.slips.trace import trace_slips
from lwr_dyn.model.arm import Arm

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


def swing(payload: float = 0.0) -> tuple[Arm, JointLog]:
    """An arm and its log of two seconds."""
    arm = lwr_dyn.load("lwr4plus", "physical")
    move = lwr_dyn.reference("point-to-point", arm, start=BENT, end=np.add(BENT, 0.6), duration=2.0)
    return arm, log_of_run(lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), move, payload=payload))


def motion() -> Document:
    """A fit to a swing."""
    arm, log = swing()
    log = LogSensors(torque_noise=0.05).through(log, seed=0)
    found = identify_motion([log], arm, MotionRule(gains=0.1))
    return motion_document(found, robot=arm.name, unseen=found.validated_on([log]))


def payload() -> Document:
    """A load in a swing."""
    arm, log = swing(3.0)
    return load_document(identify_load([LogSensors(torque_noise=0.05).through(log, seed=0)], arm), arm.name)


def table() -> Document:
    """A table against a swing."""
    arm, log = swing()
    information = identify_motion([log], arm).information
    report = trace_slips(information, arm)
    return slip_document(report, table_against_log(information, arm))


def elastic() -> Document:
    """Five seconds of both sides of the gears."""
    arm, t = lwr_dyn.load("lwr4plus", "physical"), np.linspace(0.0, 5.0, 2501)
    angle = np.outer(t, np.arange(1.0, 6.0))
    waves = np.hstack([np.sin(angle), np.cos(angle)])
    q, bend, tau = waves @ np.random.default_rng(0).uniform(-0.5, 0.5, (3, 10, arm.n))
    log = JointLog("made", tuple(range(1, arm.n + 1)), t, q, tau, motor_q=q + 1e-3 * bend)
    return elastic_document(identify_elastic([log], arm), arm, arm.name)


def origin() -> Document:
    """The origin of a URDF of ours with one cell changed."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "made.urdf"
        text = lwr_dyn.urdf_text(lwr_dyn.load("panda", "fer"))
        path.write_text(text.replace('mass value="2.7907"', 'mass value="2.8"'), encoding="utf-8")
        return printed(f"origin {path}")()


def friction() -> Document:
    """A fit to four cruises of one joint."""
    t = np.linspace(0.0, 4.0, 401)
    cruises = ((v * t, np.full_like(t, np.sign(v) + v)) for v in (-0.2, -0.1, 0.1, 0.2))
    return identify_friction([JointLog("made", (1,), t, q[:, None], tau[:, None]) for q, tau in cruises]).document


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


def krl_run() -> Document:
    """A program with an output and an input."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "made.src"
        text = "DEF made()\nBAS(#INITMOV, 0)\nPTP {A1 0, A2 -90, A3 90, A4 5, A5 10, A6 0}\n$OUT[1] = $IN[1]\nEND\n"
        path.write_text(text, encoding="utf-8")
        return printed(f"krl run {path} --set $IN[1]=TRUE")()


STUDY = """
robot = "lwr4plus"
controllers = ["inverse-dynamics"]
[task]
name = "hold"
from-deg = [0, 30, 0, -60, 0, 30, 0]
duration = 0.02
[[parameter]]
path = "payload.mass"
low = 0
high = 5
"""


def study(line: str) -> Callable[[], Document]:
    """What a command makes of a small study."""

    def found() -> Document:
        with TemporaryDirectory() as folder:
            path = Path(folder) / "made.toml"
            path.write_text(STUDY, encoding="utf-8")
            return printed(line.format(path, folder))()

    return found


def reproduce() -> Document:
    """The smallest paper."""
    with TemporaryDirectory() as folder:
        return printed(f"reproduce lwr4 --out {folder}")()


EXAMPLES: Mapping[str, Callable[[], Document]] = {
    "check": printed("check lwr4plus"),
    "compare": compare,
    "dh": printed("dh kr30ha --convention modified"),
    "fk": printed("fk kr30ha --axes-deg A2=-90,A3=90"),
    "krl check": krl_check,
    "krl diff": krl_diff,
    "krl run": krl_run,
    "lint": printed("lint wam7"),
    "list": printed("list"),
    "origin": origin,
    "rank": printed("rank panda --log panda_salerno --sets gaz,fer --free load"),
    "conventions": printed("conventions wam7"),
    "excite": printed("excite lwr4plus --reading physical --starts 1 --duration 5"),
    "gains": printed("gains lwr4plus"),
    "identify elastic": elastic,
    "identify friction": friction,
    "identify motion": motion,
    "identify payload": payload,
    "identify table": table,
    "ik": printed("ik kr30ha --xyz-mm 91,-1139,1392 --abc-deg 0,0,0"),
    "kernels": printed("kernels kr30ha"),
    "margins": printed("margins lwr4plus --reading physical --q-deg 0,30,0,-60,0,30,0"),
    "parity": printed("parity wam7 --only pinocchio"),
    "simulate": printed("simulate lwr4plus --task hold --from-deg 0,30,0,-60,0,30,0 --duration 0.01"),
    "sweep": study("sweep {} --out {}/out --runs 16"),
    "tune": study("tune {} --gain omega-n=20:90 --runs 8 --population 5 --generations 1 --check-runs 8 --front 0"),
    "reproduce": reproduce,
    "sensitivity": printed("sensitivity kr30ha --task joint-move --poses 5 --rate 100"),
}
"""Command -> a document of it that has all its parts."""


def differences() -> dict[Path, str]:
    """File -> what it should be, where it is not."""
    wanted = {
        Path(str(schema_file(name))): json.dumps(one().schema(), indent=1) + "\n" for name, one in EXAMPLES.items()
    }
    there = {path: path.read_text(encoding="utf-8") for path in wanted if path.is_file()}
    return {path: text for path, text in wanted.items() if there.get(path) != text}


def unlisted() -> list[str]:
    """Schemas that are made of no example, and examples without a schema."""
    listed = {name.replace(" ", "-") for name in EXAMPLES}
    return sorted({path.stem for path in Path(str(schema_file("x"))).parent.glob("*.json")} ^ listed)


def main(arguments: list[str] | None = None) -> int:
    check = "--check" in (sys.argv[1:] if arguments is None else arguments)
    stale, odd = differences(), unlisted()
    for path, text in stale.items():
        if not check:
            path.write_text(text, encoding="utf-8")
    lines = [f"{'stale' if check else 'written'}: {path.name}" for path in stale]
    lines += [f"without an example, or missing: {name}" for name in odd]
    print("\n".join(lines) or f"fresh: {len(EXAMPLES)} schemas")
    return int(bool(odd) or (check and bool(stale)))


if __name__ == "__main__":
    sys.exit(main())
