import json
import re
from pathlib import Path

import jsonschema
import pytest

from lwr_dyn.checks.urdf.document import UrdfFinding
from lwr_dyn.checks.urdf.lint import lint_file
from lwr_dyn.checks.urdf.reports import annotations, grouped, sarif_record, uri_of
from lwr_dyn.checks.urdf.xml_tree import Place
from tests.checks.urdf.box_arm import BoxArm


def finding(code: str, subject: str, severity="error", cause: str = "") -> UrdfFinding:
    return UrdfFinding("x", "", Place("f", 1, 1), subject, cause=cause, severity=severity, code=code)


GRAMS = finding("mass-grams", "link a", cause="masses in g")


def test_what_follows_from_a_cause_stands_in_its_group_only_at_the_same_link():
    here, there = finding("density", "link a", "warning"), finding("density", "link b", "warning")
    weight = finding("effort-weight", "joint c", "warning")
    first, second = grouped([here, there, weight, GRAMS])
    assert (first.cause, first.findings, first.following) == ("masses in g", (GRAMS,), (here, weight))
    assert second.findings == (there,)


def test_no_finding_is_lost_and_errors_and_large_groups_come_first():
    notes = [finding("inertial-equal", f"link {k}", "note") for k in range(9)]
    warnings = [finding("limit-equal", f"joint {k}", "warning") for k in range(2)]
    more = [finding("axis-not-unit", f"joint {k}", "warning") for k in range(3)]
    groups = grouped([*notes, *warnings, *more, GRAMS])
    assert [group.codes for group in groups] == [
        ("mass-grams",), ("axis-not-unit",), ("limit-equal",), ("inertial-equal",)
    ]  # fmt: skip
    assert sum(len(group.findings) + len(group.following) for group in groups) == 15


def test_a_group_is_as_severe_as_its_worst_finding():
    (group,) = grouped([finding("density", "link a", "note"), finding("density", "link b", "warning")])
    assert group.severity == "warning"


SCHEMA = json.loads((Path(__file__).parent / "sarif_2_1_0_part.json").read_text(encoding="utf-8"))


@pytest.fixture
def report(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = re.sub(r'effort="[^"]*"', 'effort="0"', BoxArm().text()).replace("<axis", "<!-- ü𝛼 --><axis")
    (tmp_path / "my arm.urdf").write_text(text.replace('"0 1 0"', '"0 1 1"'), encoding="utf-8")
    return lint_file("my arm.urdf")


def test_the_record_follows_the_schema(report):
    record = sarif_record([report])
    jsonschema.validate(record, SCHEMA)
    run = record["runs"][0]
    rules = [rule["id"] for rule in run["tool"]["driver"]["rules"]]
    assert rules == ["effort-zero", "axis-not-unit"]
    assert all(rules[result["ruleIndex"]] == result["ruleId"] for result in run["results"])
    assert [result["level"] for result in run["results"]] == ["error"] * 3 + ["warning"] * 2


def test_lines_and_columns_are_those_of_the_file(report):
    lines = Path("my arm.urdf").read_text(encoding="utf-8").split("\n")
    for result in sarif_record([report])["runs"][0]["results"]:
        place = result["locations"][0]["physicalLocation"]
        assert place["artifactLocation"]["uri"] == "my%20arm.urdf"
        tag = "<axis" if result["ruleId"] == "axis-not-unit" else "<limit"
        assert lines[place["region"]["startLine"] - 1][place["region"]["startColumn"] - 1 :].startswith(tag)


def test_fingerprints_differ_and_last_when_lines_above_change(report):
    def prints(of):
        results = sarif_record([of])["runs"][0]["results"]
        return [result["partialFingerprints"]["primaryLocationLineHash"] for result in results]

    before = prints(report)
    assert len(set(before)) == len(before) == 5
    file = Path("my arm.urdf")
    file.write_text("\n\n" + file.read_text(encoding="utf-8"), encoding="utf-8")
    assert prints(lint_file("my arm.urdf")) == before


def test_annotations_escape_what_github_reads(report):
    lines = list(annotations([report]))
    assert lines[0].startswith("::error file=my arm.urdf,line=26,col=128,")
    assert all(line.count("\n") == 0 for line in lines)
    assert all(re.match(r"::(error|warning) file=[^,]*,line=\d+,col=\d+,title=[\w-]+::", line) for line in lines)


def test_a_file_outside_has_an_absolute_uri(report):
    assert uri_of("../x y.urdf").startswith("file:///")
