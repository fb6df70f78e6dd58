"""`lwr-dyn lint` and `check` of URDFs: what they print, their exit codes, and one line for bad input."""

import json
import re

import pytest

from lwr_dyn.checks.urdf.reports import urdf_files
from tests.checks.urdf.box_arm import BoxArm

GOOD = BoxArm().text().replace('"0 1 0"', '"0 0 1"')
"""With axes that turn no box into its parent, which is a note."""
PARTS = [re.search(part, GOOD, re.DOTALL)[0] for part in ('<link name="l3">.*?</link>', '<joint name="j3".*?</joint>')]
FILES = {
    "robots/good": GOOD,
    "robots/weak": re.sub(r'effort="[^"]*"', 'effort="0"', GOOD),
    "warned": GOOD.replace('velocity="2"', 'velocity="180"'),
    "noted": GOOD.replace("<axis", "<flavour/><axis", 1),
    "thrice": GOOD.replace('<axis xyz="', '<axis hue="1" xyz="'),
    "fork": GOOD.replace("</robot>", "".join(re.sub("([lj])3", r"\g<1>4", part) for part in PARTS) + "</robot>"),
    "broken": "<robot>",
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robots").mkdir()
    (tmp_path / "empty").mkdir()
    (tmp_path / "robots" / "macros.xacro").write_text("<robot/>", encoding="utf-8")
    for name, text in FILES.items():
        (tmp_path / f"{name}.urdf").write_text(text, encoding="utf-8")
    return tmp_path


def test_findings_are_grouped_and_errors_give_exit_code_1(folder, lwr_dyn_command):
    code, out, err = lwr_dyn_command("lint", "robots/weak.urdf")
    lines = out.splitlines()
    assert (code, err, lines[:2], lines[-1]) == (
        1, "", ["error: effort limits of 0 stand for unknown (3 joints) [effort-zero]",
                "  robots/weak.urdf:26:117: joint j1: effort limit 0"],
        "robots/weak.urdf: 4 links, 3 of them moving: 3 errors",
    )  # fmt: skip
    assert "instead: the motor's effort, in N m" in out
    code, out, _ = lwr_dyn_command("lint", "robots")
    assert (code, out.splitlines()[-1]) == (1, "2 files: 8 links, 6 of them moving: 3 errors")
    assert list(urdf_files(["robots"])) == ["robots/good.urdf", "robots/weak.urdf"]
    assert "and 2 more (--all)" in lwr_dyn_command("lint", "thrice.urdf")[1]
    assert lwr_dyn_command("lint", "thrice.urdf", "--all")[1].count("hue of <axis> is not known") == 3


def test_json_and_sarif(folder, lwr_dyn_command):
    code, out, _ = lwr_dyn_command("lint", "robots/weak.urdf", "--json", "--sarif", "out.sarif")
    record = json.loads(out)
    assert (code, record["holds"], len(record["findings"])) == (1, False, 3)
    assert record["findings"][0] | {"why": "", "instead": ""} == {
        "code": "effort-zero", "severity": "error", "file": "robots/weak.urdf", "line": 26, "column": 117,
        "subject": "joint j1", "what": "effort limit 0", "why": "", "sure": "certain", "instead": "",
        "cause": "effort limits of 0 stand for unknown",
    }  # fmt: skip
    assert len(json.loads((folder / "out.sarif").read_text(encoding="utf-8"))["runs"][0]["results"]) == 3


def test_ignored_explained_and_for_github(folder, lwr_dyn_command):
    assert lwr_dyn_command("lint", "robots/weak.urdf", "--ignore", "effort-zero")[:2] == (
        0, "robots/weak.urdf: 4 links, 3 of them moving: no findings; 3 ignored\n"
    )  # fmt: skip
    code, out, _ = lwr_dyn_command("lint", "--explain", "effort-zero")
    assert (code, out[:58]) == (0, "effort-zero (error): an effort limit of 0 or less\n\nAn effo")
    assert lwr_dyn_command("lint", "warned.urdf", "--github")[1].startswith("::warning file=warned.urdf,line=26")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("lint", "none.urdf"), "none.urdf: no such file"),
        (("lint", "robots/good.urdf", "--ignore", "effort-zer"), "did you mean effort-zero?"),
        (("lint", "--explain", "effort-zer"), "did you mean effort-zero?"),
        (("lint", "wam7", "--strict"), "--strict: would do nothing here"),
        (
            ("lint", "wam7", "--require-meshes"),
            "--require-meshes: would do nothing here; allowed: with a .urdf, a .xacro",
        ),
        (("lint", "robots/good.urdf", "--sarif", "none/x.sarif"), "no directory none"),
        (("lint", "empty"), "no .urdf or .urdf.xacro file below it"),
        (("lint", "robots", "--trust-xacro"), "given for the folder robots"),
        (("check", "robots/weak.urdf", "--tip", "none"), "none"),
    ],
)
def test_bad_input(folder, lwr_dyn_command, arguments, message):
    code, _, err = lwr_dyn_command(*arguments)
    assert (code, err.count("\n")) == (2, 1)
    assert message in err


def test_check_judges_the_file_and_skips_laws_where_no_chain_is_chosen(folder, lwr_dyn_command):
    code, out, _ = lwr_dyn_command("check", "robots/good.urdf")
    assert (code, out.splitlines()[0]) == (0, "robots/good.urdf: 4 links, 3 of them moving: no findings")
    assert "mass matrix: Pinocchio against our own recursion" in out
    assert out.endswith(" checks hold\n")
    code, out, _ = lwr_dyn_command("check", "fork.urdf")
    assert (code, "laws and roads skipped: fork.urdf: " in out, "--tip" in out) == (0, True, True)
    code, out, _ = lwr_dyn_command("check", "robots/weak.urdf", "--json")
    record = json.loads(out)
    assert (code, record["holds"], len(record["findings"]), bool(record["verdicts"])) == (1, False, 3, True)
    assert lwr_dyn_command("check", "robots/weak.urdf")[1].endswith("checks hold; the file as written fails\n")
    code, out, err = lwr_dyn_command("check", "broken.urdf")
    assert (code, err, "broken.urdf:1:8: not XML: no element found" in out) == (1, "", True)
    assert "broken.urdf: 1 error\nlaws and roads skipped: broken.urdf: XML" in out
    code, out, _ = lwr_dyn_command("check", "broken.urdf", "--json")
    assert (code, json.loads(out)["findings"][0]["code"]) == (1, "xml-syntax")


@pytest.mark.parametrize("mesh", ["package://none_such/a.stl", "https://example.org/a.stl", "broken.stl", "a.ply"])
def test_meshes_that_are_not_judged_are_errors_where_meshes_are_required(folder, lwr_dyn_command, mesh):
    (folder / "broken.stl").write_bytes(b"solid nothing")
    (folder / "a.ply").write_bytes(b"ply\n")
    shape = f'<visual><geometry><mesh filename="{mesh}"/></geometry></visual></link>'
    (folder / "away.urdf").write_text(GOOD.replace("</link>", shape, 1), encoding="utf-8")
    assert lwr_dyn_command("lint", "away.urdf")[0] == 0
    code, out, _ = lwr_dyn_command("lint", "away.urdf", "--require-meshes", "--sarif", "out.sarif")
    assert (code, "error: " in out) == (1, True)
    results = json.loads((folder / "out.sarif").read_text())["runs"][0]["results"]
    assert [x["level"] for x in results if "mesh" in x["ruleId"]] == ["error"]
    assert lwr_dyn_command("lint", "robots/good.urdf", "--require-meshes")[0] == 0  # all of its none are there


def test_exit_codes_are_as_the_help_says(folder, lwr_dyn_command):
    said = " ".join(lwr_dyn_command("lint", "--help")[1].split())
    assert "Exit code 1 for an error, and for a warning in a table or, with --strict, in a URDF; 0 for notes" in said
    codes = {
        file: tuple(lwr_dyn_command("lint", f"{file}.urdf", *option)[0] for option in ((), ("--strict",)))
        for file in ("robots/good", "robots/weak", "warned", "noted", "none")
    }
    assert codes == {"robots/good": (0, 0), "robots/weak": (1, 1), "warned": (0, 1), "noted": (0, 0), "none": (2, 2)}
