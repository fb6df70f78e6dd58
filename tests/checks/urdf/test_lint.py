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


IMPOSSIBLE = '<inertial><mass value="1"/><inertia ixx="0.10" iyy="0.10" izz="0.30"/></inertial>'


def arm(inertial=IMPOSSIBLE, before_link="", top=""):
    """A link that a joint moves, one that is welded to it, and one that nothing moves."""
    return (
        f'{top}<robot name="r"><link name="base">{inertial}</link>{before_link}<link name="arm">{inertial}</link>'
        f'<link name="tool">{inertial}</link>'
        '<joint name="turn" type="continuous"><parent link="base"/><child link="arm"/></joint>'
        '<joint name="weld" type="fixed"><parent link="arm"/><child link="tool"/></joint></robot>'
    )


COMMENT = "<!-- lwr-dyn: ignore {} -->"
LEVELS = {"link arm": "error", "link tool": "warning", "link base": "note"}


@pytest.mark.parametrize(
    ("text", "ignore", "levels", "ignored"),
    [
        (arm(), (), LEVELS, 0), (arm(), ("inertia-triangle",), {}, 3),
        (arm(before_link=COMMENT.format("inertia-triangle")), (), LEVELS.keys() - {"link arm"}, 1),
        (arm(top=COMMENT.format("inertia-triangle")), (), {}, 3), (arm(top=COMMENT.format("all")), (), {}, 5),
        (arm(top=COMMENT.format("inertia-zero")), (), LEVELS, 0),
    ],
)  # fmt: skip
def test_severity_depends_on_what_moves_the_link_and_a_code_may_be_ignored(text, ignore, levels, ignored):
    report = lint_document(document_of(text, "r.urdf"), ignore)
    found = {f.subject: f.level for f in report.findings if f.code == "inertia-triangle"}
    assert (found, report.ignored, report.links, report.moved) == ({x: LEVELS[x] for x in levels}, ignored, 3, 2)


def test_a_code_that_does_not_exist_is_said_of_a_comment_and_refused_of_an_option():
    remarks = lint_document(document_of(arm(top=COMMENT.format("inertia-triangel, all")), "r.urdf")).remarks
    assert [line for line in remarks if "ignore" in line] == [
        "a comment asks to ignore 'inertia-triangel': no rule has this code"
    ]
    with pytest.raises(UnknownNameError, match="did you mean inertia-triangle"):
        lint_document(document_of(arm(), "r.urdf"), ["inertia-triangel"])


@pytest.mark.parametrize("name", ["none.urdf", ""])
def test_a_file_that_cannot_be_read(tmp_path, name):
    with pytest.raises(FileAccessError):
        lint_file(tmp_path / name)


@pytest.mark.parametrize(
    ("text", "code", "place", "says"),
    [
        (b"<robot>", "xml-syntax", (1, 8), "not XML: no element found; no program can read the file"),
        (b"<robot\n n='\xc3\xa9\xe9'/>", "xml-encoding", (2, 6), "byte 0xe9 is not UTF-8; no program can read the "
         "file; save the file as UTF-8"),
        (b"<mujoco/>", "root-tag", (1, 1), "the outermost element is <mujoco>; it is MJCF (MuJoCo); this command "
         "judges URDF and xacro"),
        (b"<list/>", "root-tag", (1, 1), "the outermost element is <list>; a URDF is one <robot>; write <robot>"),
        (b"<robot name='r'/>", "root-tag", (1, 1), "no <link>; a robot has at least one link"),
    ],
)  # fmt: skip
def test_text_that_is_no_urdf_is_one_finding(text, code, place, says):
    report = lint_document(document_of(text, "r.urdf"))
    (found,) = report.findings
    assert (found.code, (found.place.line, found.place.column), found.message) == (code, place, says)
    assert (report.holds(), report.count("error")) == (False, 1)


def test_warnings_count_only_when_strict():
    text = '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed">' + (
        '<parent link="a"/><child link="b"/><limit lower="0" upper="{0}" effort="{0}" velocity="{0}"/></joint></robot>'
    )
    for limit, levels, holds in (("1", ["warning"], False), ("0", ["note"], True)):
        report = lint_document(document_of(text.format(limit), "r.urdf"))
        assert [f.level for f in report.findings if f.code == "fixed-limits"] == levels
        assert (report.holds(), report.holds(strict=True)) == (True, holds)


def test_broken_files_are_judged_without_an_exception():
    """A share of `scripts/soak.py linter_broken`."""
    counts = [broken_files.judged(seed) for seed in range(120)]
    assert sum(count > 0 for count in counts) > 80
    assert len({broken_files.broken(seed) for seed in range(120)}) > 110
