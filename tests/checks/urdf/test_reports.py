import json
import re
from pathlib import Path

import jsonschema
import pytest

from lwr_dyn.checks.urdf.document import UrdfFinding
from lwr_dyn.checks.urdf.lint import LintReport, lint_file
from lwr_dyn.checks.urdf.reports import annotations, grouped, report_text, sarif_record, summary, uri_of
from lwr_dyn.checks.urdf.xml_tree import Place
from tests.checks.urdf.box_arm import BoxArm


def finding(code: str, subject: str, severity="error", cause: str = "", **more) -> UrdfFinding:
    return UrdfFinding("x", "", Place("f", 1, 1), subject, cause=cause, severity=severity, code=code, **more)


GRAMS = finding("mass-grams", "link a", cause="masses in g")
HERE, THERE = finding("density", "link a", "warning"), finding("density", "link b", "warning")
WEIGHT = finding("effort-weight", "joint c", "warning")
NOTES = [finding("inertial-equal", f"link {k}", "note") for k in range(9)]
TWO = [finding("limit-equal", f"joint {k}", "warning") for k in range(2)]
THREE = [finding("axis-not-unit", f"joint {k}", "warning") for k in range(3)]


def test_what_follows_from_a_cause_stands_in_its_group_only_at_the_same_link():
    first, second = grouped([HERE, THERE, WEIGHT, GRAMS])
    assert (first.cause, first.findings, first.following) == ("masses in g", (GRAMS,), (HERE, WEIGHT))
    assert (second.findings, second.following) == ((THERE,), ())


def test_no_finding_is_lost_and_errors_and_large_groups_come_first():
    groups = grouped([*NOTES, *TWO, *THREE, GRAMS])
    assert [(g.codes, g.severity, len(g.findings)) for g in groups] == [
        (("mass-grams",), "error", 1), (("axis-not-unit",), "warning", 3), (("limit-equal",), "warning", 2),
        (("inertial-equal",), "note", 9),
    ]  # fmt: skip
    (group,) = grouped([finding("density", "link a", "note"), THERE])
    assert (group.severity, group.findings[0].level) == ("warning", "note")


def test_a_report_as_text():
    """A group says how many places and links it has; five of its findings are shown, one of notes, or all."""
    twice = [finding("axis-not-unit", "joint 0", "warning", sure="likely", instead="y"), *THREE, *THREE[:2]]
    report = LintReport("f", (HERE, THERE, WEIGHT, GRAMS, *twice, *NOTES), ("rem",), 12, 1, 2)
    heads = [
        "error: masses in g [mass-grams]",
        "warning: an axis whose length is not 1 (6 places, 3 joints) [axis-not-unit]",
        "warning: mass over volume that no arm has [density]",
        "note: the inertial of the neighbour (9 links) [inertial-equal]",
    ]  # fmt: skip
    text, whole = (report_text(report, everything).splitlines() for everything in (False, True))
    assert [line for line in text if not line.startswith(" ")] == [
        *heads, "f: rem", "f: 12 links, 1 of them moving: 1 error, 9 warnings, 9 notes; 2 ignored"
    ]  # fmt: skip
    assert text[1:3] == ["  f:1:1: link a: x", "  2 more findings most likely follow from it: density, effort-weight"]
    assert text[4:11] == [
        "  f:1:1: joint 0: x (likely)", "      instead: y", *(f"  f:1:1: joint {k}: x" for k in (0, 1, 2, 0)),
        "  and 1 more (--all)",
    ]  # fmt: skip
    assert text[-4:-2] == ["  f:1:1: link 0: x", "  and 8 more (--all)"]
    assert whole[3:5] == ["  f:1:1: warning: link a: x", "  f:1:1: warning: joint c: x"]
    assert sum(": x" in line for line in whole) == 19
    one = LintReport("g", (finding("mass-zero", ""),), (), 1, 0, 0)
    assert report_text(one).splitlines()[1] == "  f:1:1: x"
    assert [summary(x) for x in ([one], [one, report], [LintReport("h", (), (), 0, 0, 0)])] == [
        "g: 1 link, 0 of them moving: 1 error", "2 files: 13 links, 1 of them moving: 2 errors, 9 warnings, 9 notes; 2 "
        "ignored", "h: no findings",
    ]  # fmt: skip


SCHEMA = json.loads((Path(__file__).parent / "sarif_2_1_0_part.json").read_text(encoding="utf-8"))


@pytest.fixture
def report(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = re.sub(r'effort="[^"]*"', 'effort="0"', BoxArm().text()).replace("<axis", "<!-- ü𝛼 --><axis")
    (tmp_path / "my arm.urdf").write_text(text.replace('"0 1 0"', '"0 1 1"'), encoding="utf-8")
    return lint_file("my arm.urdf")


def test_the_record_follows_the_schema_and_names_each_place(report):
    record = sarif_record([report])
    jsonschema.validate(record, SCHEMA)
    run = record["runs"][0]
    rules = [rule["id"] for rule in run["tool"]["driver"]["rules"]]
    levels = [rule["defaultConfiguration"]["level"] for rule in run["tool"]["driver"]["rules"]]
    assert (rules, levels) == (["effort-zero", "axis-not-unit"], ["error", "warning"])
    assert [(x["ruleId"], x["ruleIndex"], x["level"]) for x in run["results"]] == [
        *[("effort-zero", 0, "error")] * 3, *[("axis-not-unit", 1, "warning")] * 2
    ]  # fmt: skip
    lines = Path("my arm.urdf").read_text(encoding="utf-8").split("\n")
    for result, found in zip(run["results"], report.findings, strict=True):
        place = result["locations"][0]["physicalLocation"]
        assert (place["artifactLocation"]["uri"], result["message"]["text"]) == ("my%20arm.urdf", found.message)
        tag = "<axis" if result["ruleId"] == "axis-not-unit" else "<limit"
        assert lines[place["region"]["startLine"] - 1][place["region"]["startColumn"] - 1 :].startswith(tag)
    assert uri_of("../x y.urdf").startswith("file:///")


def test_fingerprints_differ_and_last_when_lines_above_change(report):
    def prints(of):
        results = sarif_record([of])["runs"][0]["results"]
        return [result["partialFingerprints"]["primaryLocationLineHash"] for result in results]

    before = prints(report)
    assert len(set(before)) == len(before) == 5
    file = Path("my arm.urdf")
    file.write_text("\n\n" + file.read_text(encoding="utf-8"), encoding="utf-8")
    assert prints(lint_file("my arm.urdf")) == before
    doubled = LintReport("f", (GRAMS, GRAMS), (), 1, 1, 0)
    assert [x.rpartition(":")[2] for x in prints(doubled)] == ["1", "2"]


def test_annotations_escape_what_github_reads(report):
    lines = list(annotations([report]))
    assert lines[0] == (
        "::error file=my arm.urdf,line=26,col=128,title=effort-zero::joint j1: effort limit 0; the joint has no "
        "torque; the motor's effort, in N m"
    )
    assert all(re.match(r"::(error|warning) file=[^,]*,line=\d+,col=\d+,title=[\w-]+::.*$", line) for line in lines)
    odd = LintReport("f", (finding("a:b,c", "link 1%\r\n", "note"),), (), 1, 1, 0)
    assert list(annotations([odd])) == ["::notice file=f,line=1,col=1,title=a%3Ab%2Cc::link 1%25%0D%0A: x"]
