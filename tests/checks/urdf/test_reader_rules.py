"""The law: what the reader refuses, lint says; what lint finds nothing in, the reader reads."""

import random

import pytest

from lwr_dyn.arms.urdf.reader import read_urdf
from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.lint import RULES, lint_document, lint_file
from lwr_dyn.checks.urdf.reader_rules import OF_THE_TREE, refusal
from lwr_dyn.foundation.errors import UrdfError
from tests.arms.urdf.small_files import LINK, joint, robot
from tests.arms.urdf.test_reader_refusals import BROKEN, ONE, TWO
from tests.hostile.changes import changed
from tests.hostile.readers import _urdfs

SECOND = '</inertial><inertial><mass value="-1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
MORE = {
    "default namespace": ONE.replace("<robot", '<robot xmlns="http://example.org"'),
    "macro of xacro": ONE.replace("<robot", '<robot xmlns:xacro="http://ros.org/wiki/xacro"').replace(
        "</robot>", '<xacro:arm prefix="x"/></robot>'
    ),
    "nested": ONE.replace("</robot>", "<gazebo>" + "<a>" * 120 + "</a>" * 120 + "</gazebo></robot>"),
    "an undeclared prefix that XML reserves": ONE.replace("</robot>", '<gazebo xmlns:xml="x"/></robot>'),
    "a second inertial": ONE.replace("</inertial>", SECOND),
    "an empty inertial": ONE.replace("</link>", "<inertial/></link>", 1),
    "a number of an unknown element": ONE.replace("<mass ", '<flavour value="sweet"/><mass '),
    "no type": ONE.replace('type="revolute"', 'type=""'),
    "no inertia": ONE.replace("<inertia ", "<flavour "),
    "negative damping": ONE.replace("</joint>", '<dynamics damping="-0.5"/></joint>'),
    "negative friction": ONE.replace("</joint>", '<dynamics friction="-3"/></joint>'),
    "infinite damping": ONE.replace("</joint>", '<dynamics damping="inf"/></joint>'),
    "negative speed": ONE.replace('velocity="', 'velocity="-'),
    "limits beyond all numbers, exchanged": ONE.replace('lower="-2"', 'lower="1e16"'),
    "negative mass of a link at rest": robot(joint("j", "a", "b"), a=LINK.replace('value="2"', 'value="-2"'), b=LINK),
    "an axis of zeros on the left arm": TWO.replace("0 0 1", "0 0 0", 1),
}
"""Beside those of `test_reader_refusals`."""
REFUSED = {name: text for name, (text, _) in BROKEN.items()} | MORE


def said(report):
    """Whether a report says why no arm is read."""
    return report.count("error") or any(line.startswith("no arm is read") for line in report.remarks)


def refuses(path):
    """What the reader says; empty where it reads the file."""
    try:
        read_urdf(path)
    except UrdfError as fault:
        return str(fault)
    return ""


@pytest.mark.parametrize("case", REFUSED)
def test_what_the_reader_refuses_is_said(tmp_path, case):
    """Only a choice of chain, and a type that other programs know, leave a file without an error."""
    path = tmp_path / "arm.urdf"
    path.write_text(REFUSED[case], encoding="utf-8")
    assert refuses(path)
    report = lint_file(path)
    assert said(report), refuses(path)
    assert (report.count("error") == 0) == (case in {"only a link", "floating", "unknown type", "two ends"})


@pytest.mark.parametrize("case", ["default namespace", "macro of xacro", "nested", "a second inertial"])
def test_what_no_other_rule_names_is_said_in_the_words_of_the_reader(case):
    document = document_of(REFUSED[case], "arm.urdf")
    (found,) = [f for f in lint_document(document).findings if f.code == "reader-refuses"]
    fault = refusal(document).fault
    assert (found.what, found.why, found.instead) == (
        f"the reader refuses {fault.element}: {fault.found}", "no command loads the file", f"allowed: {fault.allowed}"
    )  # fmt: skip
    assert found.subject == ("link b" if case == "a second inertial" else "")


@pytest.mark.parametrize("tag", ["include filename='x'", "property name='x' value='1'", "arg name='x' default='1'"])
def test_a_leftover_of_xacro_is_a_note(tmp_path, tag):
    path, name = tmp_path / "arm.urdf", f"<xacro:{tag.split()[0]}>"
    text = ONE.replace("<robot", '<robot xmlns:xacro="http://ros.org/xacro"')
    path.write_text(text.replace("<link", f"<xacro:{tag}/><link", 1))
    report = lint_file(path)
    found = [(f.level, f.what) for f in report.findings if f.code == "xacro-leftover"]
    assert (found, report.count("error")) == ([("note", f"{name} is left over from xacro")], 0)
    assert read_urdf(path).notes == (f"arm.urdf: {name} left over from xacro, passed over as every reader does",)


@pytest.mark.parametrize("case", ["negative damping", "negative mass", "two roots", "link twice", "two parents", "nan"])
def test_what_a_rule_names_is_not_said_twice(case):
    codes = [f.code for f in lint_document(document_of(REFUSED[case], "arm.urdf")).findings if f.level == "error"]
    assert codes
    assert "reader-refuses" not in codes


def test_the_choice_of_an_arm_is_a_remark_and_not_a_finding():
    report = lint_document(document_of(TWO, "arm.urdf"))
    assert report.holds(strict=True)
    (line,) = [x for x in report.remarks if x.startswith("no arm is read")]
    assert "--tip: b (1 joint), c (1 joint)" in line
    assert set(OF_THE_TREE) <= set(RULES.names)


def test_changed_files_are_judged_as_they_are_read(tmp_path):
    """What the reader refuses of files changed by seeds, the linter says."""
    path, apart = tmp_path / "x.urdf", []
    for seed in range(60):
        rng = random.Random(seed)
        text = changed(rng.choice((*_urdfs(), *REFUSED.values())), rng)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        if refuses(path) and not said(lint_file(path)):
            apart.append((seed, text, refuses(path)))
    assert apart == []
