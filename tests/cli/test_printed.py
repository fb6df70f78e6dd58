"""What commands print stays, word for word: digests of their text and record, with their numbers rounded.

Here the cheap commands run, so that a changed line, row, unit or order is seen at once; the pages of the docs, which
show more, are slow. Where a change is meant, `python -m tests.cli.test_printed` writes the digests again, after a look
at what the command prints now. Numbers that another processor rounds otherwise are left to other tests: the digests
are the same with OPENBLAS_CORETYPE=Nehalem and NPY_DISABLE_CPU_FEATURES="X86_V3 X86_V4 AVX512_ICL AVX512_SPR".
"""

import hashlib
import io
import json
import os
import re
import tempfile
import tomllib
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest

from lwr_dyn.cli.main import main
from lwr_dyn.foundation.version import VERSION
from tests.cli.krl.test_write import TASK

KNOWN = Path(__file__).resolve().with_name("printed.toml")
WRITTEN = {".urdf", ".toml", ".csv", ".src", ".dat", ".py", ".json"}
BENT = "0,30,0,-60,0,30,0"
HOLD = f"simulate lwr4plus --task hold --from-deg {BENT} --duration 0.05"
SCENES = {
    "tables": (
        "list", "list wam7 --json", "check lwr4", "check kr30ha --reading printed", "check lwr4plus --json",
        "dh lwr4plus --convention modified", "dh kr30ha --json", "conventions kr30ha", "conventions wam7 --json",
        "lint wam7", "lint lwr4plus --json",
    ),
    "files": (
        "urdf kr30ha --mount wall --tool xyz=0,0,0.2 --tool mass=3 --out cell.urdf", "lint cell.urdf",
        "lint cell.urdf --json", "urdf panda --reading fer --out panda.urdf", "origin panda.urdf",
        "origin panda.urdf --json", "dh wam7 --out own.toml", "check own.toml --json",
        "new arm arm.toml --joints RRPR --convention modified", "check arm.toml", "new cell new_cell.toml",
        "new controller mine.py",
    ),
    "poses": (
        "fk lwr4 --q-deg 0,90,90,-90,0,90,0 --point 0,0.05,0.1", "fk kr30ha --axes-deg A2=-90,A3=90 --json",
        "ik lwr4plus --xyz -0.05,-0.45,0.55 --rpy-deg -90,0,0", "ik lwr4plus --xyz 0,0,2",
        "ik kr30ha --xyz-mm 91,-1139,1392 --abc-deg 0,0,0",
    ),
    "loops": (
        f"margins lwr4plus --reading physical --q-deg {BENT} --controller pid --limit 1.7",
        f"margins lwr4plus --reading physical --q-deg {BENT} --elastic 1e4 --encoders link --limit 1.7 --json",
        "margins lwr4plus --poses 20", "gains kr30ha", "gains lwr4plus --reading physical",
    ),
    "runs": (
        f"{HOLD} --payload 3 --controller pid --encoder-bits 16 --mount ceiling --friction none --csv hold.csv",
        f"{HOLD} --elastic 1e4 --controller motor-pd --out elastic.npz",
        f"{HOLD} --controller inverse-dynamics --friction none --out hold.npz",
        "simulate kr30ha --task point-to-point --from-deg 0,-90,90,0,0,0 --to-deg 9,-80,90,0,0,0 --json",
        "compare hold.npz elastic.npz --json",
    ),
    "programs": (
        "krl write task.toml --out TwoPoint.src", "krl check TwoPoint.src --json", "krl run TwoPoint.src",
        "krl run TwoPoint.src --out TwoPoint.npz", "krl format TwoPoint.src",
        "krl diff TwoPoint.src TwoPoint.src", "krl write TwoPoint.npz --tolerance-mm 0.5 --out again.src",
        "krl diff TwoPoint.src again.src --json",
    ),
}  # fmt: skip


def short(number, digits=5):
    """Of a long number some digits; 0 of what rounding or the end of a search decides."""
    x, is_long = float(number.group()), len(number.group()) > 8
    return "0" if abs(x) < (1e-4 if is_long else 1e-6) else f"{x:.{digits}g}" if is_long else number.group()


def rounded(text):
    text = text.replace(VERSION, "VERSION")
    return re.sub(r"(?<![\w.])-?\d+\.\d*(?:e[-+]?\d+)?|-?\b\d+e-\d+", short, text)


def said(line):
    """What a command prints, the errors behind the rest, and its exit code."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as stop:
        main(line.split())
    return f"{stop.value.code}\n{out.getvalue()}\n{err.getvalue()}"


def played(scene):
    """The commands of a scene in this folder: what each prints, and the texts that it writes."""
    Path("task.toml").write_text(TASK, encoding="utf-8")
    seen, shown = {}, {}
    for line in SCENES[scene]:
        text = said(line)
        for path in sorted(p for p in Path().rglob("*") if p.suffix in WRITTEN):
            written = path.read_text(encoding="utf-8")
            text += f"{path}\n{written}" if seen.get(path) != written else ""
            seen[path] = written
        shown[line] = rounded(text)
    return shown


def digests(scene):
    return {line: hashlib.sha256(text.encode()).hexdigest()[:12] for line, text in played(scene).items()}


@pytest.mark.parametrize("scene", SCENES)
def test_what_is_printed_and_written_stays(scene, folder):
    assert digests(scene) == tomllib.loads(KNOWN.read_text(encoding="utf-8"))[scene]


def test_a_changed_digit_or_word_is_seen_and_the_last_bits_are_not():
    assert rounded("at 0.123456789 m") == rounded("at 0.1234567891 m") != rounded("at 0.123466789 m")
    assert rounded("-1e-17 N m") == rounded("3.2e-16 N m") == "0 N m" != rounded("3.2e-4 N m")


if __name__ == "__main__":
    lines = ["# Digests of what commands print and write: see test_printed.py."]
    for scene in SCENES:
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            lines += ["", f"[{scene}]", *(f"{json.dumps(k)} = {json.dumps(x)}" for k, x in digests(scene).items())]
    KNOWN.write_text("\n".join(lines) + "\n", encoding="utf-8")
