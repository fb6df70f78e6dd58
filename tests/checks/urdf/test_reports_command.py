import json
import re

import pytest

from lwr_dyn.checks.urdf.reports import urdf_files
from tests.checks.urdf.box_arm import BoxArm

GOOD = BoxArm().text().replace('"0 1 0"', '"0 0 1"')
"""With axes that turn no box into its parent, which is a note."""
WEAK = re.sub(r'effort="[^"]*"', 'effort="0"', GOOD)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "good.urdf").write_text(GOOD, encoding="utf-8")
    (tmp_path / "robots" / "weak.urdf").write_text(WEAK, encoding="utf-8")
    (tmp_path / "robots" / "macros.xacro").write_text("<robot/>", encoding="utf-8")
    return tmp_path


def test_findings_are_grouped_and_errors_give_exit_code_1(folder, lwr_dyn_command):
    code, out, err = lwr_dyn_command("lint", "robots/weak.urdf")
    assert (code, err) == (1, "")
    lines = out.splitlines()
    assert lines[0] == "error: effort limits of 0 stand for unknown (3 joints) [effort-zero]"
    assert lines[1] == "  robots/weak.urdf:26:117: joint j1: effort limit 0"
    assert "instead: the motor's effort, in N m" in out
    assert lines[-1] == "robots/weak.urdf: 4 links, 3 of them moving: 3 errors"
    assert lwr_dyn_command("lint", "robots/good.urdf")[0] == 0


def test_a_folder_and_its_summary(folder, lwr_dyn_command):
    code, out, _ = lwr_dyn_command("lint", "robots")
    assert code == 1
    assert out.splitlines()[-1] == "2 files: 8 links, 6 of them moving: 3 errors"
    assert list(urdf_files(["robots"])) == ["robots/good.urdf", "robots/weak.urdf"]


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


def test_ignored_explained_strict(folder, lwr_dyn_command):
    assert lwr_dyn_command("lint", "robots/weak.urdf", "--ignore", "effort-zero")[:2] == (
        0, "robots/weak.urdf: 4 links, 3 of them moving: no findings; 3 ignored\n"
    )  # fmt: skip
    code, out, _ = lwr_dyn_command("lint", "--explain", "effort-zero")
    assert code == 0
    assert out.startswith("effort-zero (error): an effort limit of 0 or less\n")
    fast = GOOD.replace('velocity="2"', 'velocity="99"')
    (folder / "x.urdf").write_text(fast, encoding="utf-8")
    assert [lwr_dyn_command("lint", "x.urdf", *more)[0] for more in ((), ("--strict",))] == [0, 1]
    assert lwr_dyn_command("lint", "x.urdf", "--github")[1].startswith("::warning file=x.urdf,line=26")


def test_all_prints_every_finding_of_a_group(folder, lwr_dyn_command):
    twice = GOOD.replace('<axis xyz="', '<axis hue="1" xyz="')
    (folder / "x.urdf").write_text(twice, encoding="utf-8")
    assert "and 2 more (--all)" in lwr_dyn_command("lint", "x.urdf")[1]
    assert lwr_dyn_command("lint", "x.urdf", "--all")[1].count("hue of <axis> is not known") == 3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("none.urdf",), "none.urdf: no such file"),
        (("robots/good.urdf", "--ignore", "effort-zer"), "did you mean effort-zero?"),
        (("--explain", "effort-zer"), "did you mean effort-zero?"),
        (("wam7", "--strict"), "--strict: would do nothing here"),
        (("robots/good.urdf", "--sarif", "none/x.sarif"), "no directory none"),
        (("empty",), "no .urdf or .urdf.xacro file below it"),
    ],
)
def test_bad_input(folder, lwr_dyn_command, arguments, message):
    (folder / "empty").mkdir()
    code, _, err = lwr_dyn_command("lint", *arguments)
    assert code == 2
    assert message in err
    assert err.count("\n") == 1


def test_check_judges_the_file_and_skips_laws_where_no_chain_is_chosen(folder, lwr_dyn_command):
    code, out, _ = lwr_dyn_command("check", "robots/good.urdf")
    assert code == 0
    assert out.startswith("robots/good.urdf: 4 links, 3 of them moving: no findings\n")
    assert "mass matrix: Pinocchio against our own recursion" in out
    more = [re.search(part, GOOD, re.DOTALL) for part in ('<link name="l3">.*?</link>', '<joint name="j3".*?</joint>')]
    second = "".join(re.sub("([lj])3", r"\g<1>4", part[0]) for part in more)
    fork = GOOD.replace("</robot>", second + "</robot>")
    (folder / "fork.urdf").write_text(fork, encoding="utf-8")
    code, out, _ = lwr_dyn_command("check", "fork.urdf")
    assert code == 0
    assert "laws and roads skipped: fork.urdf: " in out
    assert "--tip" in out
    code, out, _ = lwr_dyn_command("check", "robots/weak.urdf", "--json")
    assert (code, json.loads(out)["holds"], len(json.loads(out)["findings"])) == (1, False, 3)
    assert json.loads(out)["verdicts"]


def test_check_of_a_file_that_no_program_reads_says_where_as_lint_does(folder, lwr_dyn_command):
    (folder / "x.urdf").write_text("<robot>", encoding="utf-8")
    code, out, err = lwr_dyn_command("check", "x.urdf")
    assert (code, err) == (1, "")
    assert "x.urdf:1:8: not XML: no element found" in out
    assert "x.urdf: 1 error\nlaws and roads skipped: x.urdf: XML" in out
    code, out, _ = lwr_dyn_command("check", "x.urdf", "--json")
    assert (code, json.loads(out)["findings"][0]["code"]) == (1, "xml-syntax")


def test_check_says_at_its_end_that_the_file_as_written_fails(folder, lwr_dyn_command):
    assert lwr_dyn_command("check", "robots/weak.urdf")[1].endswith("checks hold; the file as written fails\n")
    assert lwr_dyn_command("check", "robots/good.urdf")[1].endswith(" checks hold\n")


def test_a_wrong_option_of_check_is_bad_input_whatever_the_file_says(folder, lwr_dyn_command):
    code, _, err = lwr_dyn_command("check", "robots/weak.urdf", "--tip", "none")
    assert code == 2
    assert err.count("\n") == 1


MESH = '<visual><geometry><mesh filename="{}"/></geometry></visual></link>'


@pytest.mark.parametrize("mesh", ["package://none_such/a.stl", "https://example.org/a.stl", "broken.stl", "a.ply"])
def test_meshes_that_are_not_judged_are_errors_where_meshes_are_required(folder, lwr_dyn_command, mesh):
    (folder / "broken.stl").write_bytes(b"solid nothing")
    (folder / "a.ply").write_bytes(b"ply\n")
    text = GOOD.replace("</link>", MESH.format(mesh), 1)
    (folder / "away.urdf").write_text(text, encoding="utf-8")
    code, out, _ = lwr_dyn_command("lint", "away.urdf")
    assert code == 0, out
    code, out, _ = lwr_dyn_command("lint", "away.urdf", "--require-meshes", "--sarif", "out.sarif")
    assert code == 1
    assert "error: " in out
    (result,) = [
        x for x in json.loads((folder / "out.sarif").read_text())["runs"][0]["results"] if "mesh" in x["ruleId"]
    ]
    assert result["level"] == "error"


def test_required_meshes_that_are_all_there_change_nothing(folder, lwr_dyn_command):
    assert lwr_dyn_command("lint", "robots/good.urdf", "--require-meshes")[0] == 0
    code, _, err = lwr_dyn_command("lint", "wam7", "--require-meshes")
    assert (code, err) == (
        2, "lwr-dyn: --require-meshes: would do nothing here; allowed: with a .urdf, a .xacro or a folder of these\n"
    )  # fmt: skip


def test_exit_codes_are_as_the_help_says(folder, lwr_dyn_command):
    _, text, _ = lwr_dyn_command("lint", "--help")
    said = " ".join(text.split())
    assert "Exit code 1 for an error, and for a warning in a table or, with --strict, in a URDF; 0 for notes" in said
    (folder / "warned.urdf").write_text(GOOD.replace('velocity="2"', 'velocity="180"'), encoding="utf-8")
    (folder / "noted.urdf").write_text(GOOD.replace("<axis", "<flavour/><axis", 1), encoding="utf-8")
    codes = {
        (file, option): lwr_dyn_command("lint", file, *option)[0]
        for file in ("robots/weak.urdf", "warned.urdf", "noted.urdf", "none.urdf")
        for option in ((), ("--strict",))
    }
    assert codes == {
        ("robots/weak.urdf", ()): 1, ("robots/weak.urdf", ("--strict",)): 1,
        ("warned.urdf", ()): 0, ("warned.urdf", ("--strict",)): 1,
        ("noted.urdf", ()): 0, ("noted.urdf", ("--strict",)): 0,
        ("none.urdf", ()): 2, ("none.urdf", ("--strict",)): 2,
    }  # fmt: skip
