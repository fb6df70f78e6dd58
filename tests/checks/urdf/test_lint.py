from pathlib import Path

import pytest

from lwr_dyn.arms.papers.catalog import studied
from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.lint import lint_document, lint_file
from lwr_dyn.foundation.errors import FileAccessError, UnknownNameError
from tests.checks.urdf import broken_files

MODELS = sorted((Path(__file__).resolve().parents[3] / "models").glob("*/*.urdf"))


def test_the_models_of_the_studied_papers_give_no_finding():
    """Those of published sets have the findings of their sets."""
    reports = [lint_file(path) for path in MODELS if path.parent.name in studied()]
    assert len(reports) == 9
    assert [finding.message for report in reports for finding in report.findings] == []
    assert all(report.remarks for report in reports)


def arm(inertial: str = "", before_link: str = "", top: str = "") -> str:
    """A link that a joint moves, one that is welded to it, and one that nothing moves."""
    return (
        f'{top}<robot name="r"><link name="base">{inertial}</link>{before_link}<link name="arm">{inertial}</link>'
        f'<link name="tool">{inertial}</link>'
        '<joint name="turn" type="continuous"><parent link="base"/><child link="arm"/></joint>'
        '<joint name="weld" type="fixed"><parent link="arm"/><child link="tool"/></joint></robot>'
    )


IMPOSSIBLE = '<inertial><mass value="1"/><inertia ixx="0.10" iyy="0.10" izz="0.30"/></inertial>'


def judged(text: str, ignore: tuple[str, ...] = ()):
    report = lint_document(document_of(text, "r.urdf"), ignore)
    return {f.subject: f.level for f in report.findings if f.code == "inertia-triangle"}, report.ignored


def test_severity_depends_on_what_moves_the_link():
    levels, ignored = judged(arm(IMPOSSIBLE))
    assert levels == {"link arm": "error", "link tool": "warning", "link base": "note"}
    assert ignored == 0


def test_ignored_by_option_and_by_comments():
    assert judged(arm(IMPOSSIBLE), ("inertia-triangle",)) == ({}, 3)
    comment = "<!-- lwr-dyn: ignore inertia-triangle -->"
    levels, ignored = judged(arm(IMPOSSIBLE, before_link=comment))
    assert set(levels) == {"link tool", "link base"}
    assert ignored == 1
    assert judged(arm(IMPOSSIBLE, top=comment)) == ({}, 3)
    assert judged(arm(IMPOSSIBLE, top="<!-- lwr-dyn: ignore all -->"))[0] == {}


def test_a_comment_that_ignores_a_code_that_does_not_exist_is_said():
    comment = "<!-- lwr-dyn: ignore inertia-triangel, all -->"
    remarks = lint_document(document_of(arm(IMPOSSIBLE, top=comment), "r.urdf")).remarks
    assert [line for line in remarks if "ignore" in line] == [
        "a comment asks to ignore 'inertia-triangel': no rule has this code"
    ]


def test_files_of_other_formats_are_named():
    (found,) = lint_document(document_of("<mujoco/>", "r.urdf")).findings
    assert found.why == "it is MJCF (MuJoCo); this command judges URDF and xacro"


def test_a_code_that_does_not_exist():
    with pytest.raises(UnknownNameError, match="did you mean inertia-triangle"):
        lint_document(document_of(arm(), "r.urdf"), ["inertia-triangel"])


def test_a_file_that_cannot_be_read(tmp_path):
    for path in (tmp_path / "none.urdf", tmp_path):
        with pytest.raises(FileAccessError):
            lint_file(path)


@pytest.mark.parametrize(("text", "code"), [(b"<robot>", "xml-syntax"), (b"<robot name='\xe9'/>", "xml-encoding")])
def test_text_that_is_no_urdf_is_one_finding(text, code):
    report = lint_document(document_of(text, "r.urdf"))
    assert [f.code for f in report.findings] == [code]
    assert not report.holds()


def test_warnings_count_only_when_strict():
    text = '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed">' + (
        '<parent link="a"/><child link="b"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    report = lint_document(document_of(text, "r.urdf"))
    assert [f.code for f in report.findings] == ["fixed-limits"]
    assert report.holds()
    assert not report.holds(strict=True)


def test_broken_files_are_judged_without_an_exception():
    """A share of `scripts/soak.py linter_broken`."""
    counts = [broken_files.judged(seed) for seed in range(120)]
    assert sum(count > 0 for count in counts) > 80
    assert len({broken_files.broken(seed) for seed in range(120)}) > 110
