"""A fifth paper: its own folder and its data file are all that it takes.

A copy of the package gets a folder `reproduction/fifth` and a file `arms/papers/fifth.toml`; no other file is touched.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import lwr_dyn
from tests.reproduction.two_links import TEXT

pytestmark = pytest.mark.slow

PACKAGE = Path(lwr_dyn.__file__).parent
DATA = f"""{TEXT.replace('"two_links"', '"fifth"')}
[[erratum]]
id = "reach-digits"
where = "conclusion"
printed = "0.09"
read_as = "0.9"
why = "0.5 m and 0.4 m are 0.9 m"
effect = "none"
severity = "result"
status = "proven"
patch = [{{ at = "results.conclusion.reach[0]", printed = "0.09", read = "0.9" }}]
"""
FILES = {
    "arms/papers/fifth.toml": DATA,
    "reproduction/fifth/results.toml": """
schema = 1
paper = "fifth"
[table_2]
where = "Table 2"
form = "table"
unit = "kg"
compute = "total_mass"
cells = { mass = ["3.5"] }
[conclusion]
where = "conclusion"
form = "text"
unit = "m"
compute = "reach"
cells = { reach = ["0.09"] }
""",
    "reproduction/fifth/__init__.py": '''
"""The fifth paper recomputed."""

from lwr_dyn.reproduction.papers import StudyOption, Study

STUDY = Study(
    order=5,
    run="lwr_dyn.reproduction.fifth.study:run",
    formulas="lwr_dyn.reproduction.fifth.study:FORMULAS",
    proofs="lwr_dyn.reproduction.fifth.study:PROOFS",
    options=(StudyOption("loudly", "in capital letters"),),
    conventions="tensors",
)
''',
    "reproduction/fifth/study.py": '''
"""The fifth paper: how far it reaches."""

from lwr_dyn.foundation.document import Note
from lwr_dyn.reproduction.case import PaperFormula
from lwr_dyn.reproduction.case import Proof
from lwr_dyn.reproduction.paper_study import Reproduction, study_document
from lwr_dyn.reproduction.case import SHARED


def reach(case, _):
    """a_1 + a_2 [m]"""
    return {"reach": [sum(case.values("dh", "a")) / 1000]}


def reach_digits(data):
    value = reach(data.case(), None)["reach"][0]
    return Proof("the links add up to 0.9 m", abs(value - 0.9) < 1e-12, {"sum [m]": value})


def run(place, arm, progress, loudly=False):
    progress("nothing to simulate")
    text = f"{arm.name} has {arm.n} joints"
    return Reproduction(True, study_document(Note(text.upper() if loudly else text), joints=arm.n))


FORMULAS = SHARED | {"reach": PaperFormula(reach)}
PROOFS = {"reach-digits": reach_digits}
''',
}


@pytest.fixture(scope="module")
def command(tmp_path_factory):
    """`lwr-dyn` of a copy of the package with the fifth paper in it."""
    place = tmp_path_factory.mktemp("copy")
    shutil.copytree(PACKAGE, place / "lwr_dyn")
    for name, text in FILES.items():
        (place / "lwr_dyn" / name).parent.mkdir(exist_ok=True)
        (place / "lwr_dyn" / name).write_text(text.lstrip(), encoding="utf-8")

    def run(*arguments):
        line = [sys.executable, "-m", "lwr_dyn", *arguments]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(place), str(PACKAGE.parent)])}  # its metadata
        return place, subprocess.run(line, cwd=place, env=environment, capture_output=True, text=True, check=False)

    return run


def test_it_is_reproduced_with_its_option(command):
    place, done = command("reproduce", "fifth", "--loudly")
    assert (done.returncode, done.stderr) == (0, "")
    assert "FIFTH HAS 2 JOINTS" in done.stdout
    folder = place / "out" / "fifth"
    names = {path.name for path in folder.iterdir()}
    assert names == {"models", "checks.txt", "tables.txt", "results.json", "report.html"}
    record = json.loads((folder / "results.json").read_text())
    assert record["holds"] is True
    assert [(n["cell"], n["verdict"], n["errata"]) for n in record["numbers"]] == [
        ("results.table_2.mass[0]", "reproduced", []),
        ("results.conclusion.reach[0]", "after erratum", ["reach-digits"]),
    ]
    assert record["errata"][0]["proof"]["holds"] is True
    assert (record["joints"], bool(record["resolver"])) == (2, True)
    assert "Two links in a vertical plane" in (folder / "report.html").read_text()


def test_it_is_offered_beside_the_others_and_its_option_only_there(command):
    text = " ".join(command("reproduce", "--help")[1].stdout.split())
    assert "(lwr4plus, lwr4, wam7, kr30ha, fifth, all, or yo" in text
    assert "--loudly fifth: in capital letters." in text
    refused = command("reproduce", "lwr4", "--loudly")[1]
    assert (refused.returncode, refused.stderr.count("\n")) == (2, 1)
    assert "loudly: given for lwr4; allowed: only for fifth" in refused.stderr


def test_other_commands_know_it(command):
    assert "fifth" in command("list")[1].stdout
    assert "numbers looked at" in command("lint", "fifth")[1].stdout
