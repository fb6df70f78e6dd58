"""A URDF that is broken, or that the options do not fit, is refused in one line."""

import pytest
from hypothesis import given

from lwr_dyn.arms.urdf.reader import read_urdf
from lwr_dyn.arms.urdf.writer import urdf_text
from lwr_dyn.foundation.errors import FileAccessError, LwrDynError, UnknownNameError, UrdfError
from tests.arms.urdf.small_files import LINK, joint, robot, written
from tests.random_arms import arms

ONE = robot(joint("j", "a", "b"), a="", b=LINK)
TWO = robot(joint("j", "a", "b"), joint("k", "a", "c"), a="", b=LINK, c=LINK)
BROKEN = {
    "not XML": ("<robot", "XML"),
    "undeclared namespace, no link": ('<robot name="r"><drake:x/></robot>', "0 links without a parent"),
    "another root": ('<sdf name="r"/>', "<robot>"),
    "no name": (ONE.replace(' name="r"', ""), "robot: no name; allowed: a name"),
    "empty": ('<robot name="r"/>', "one root"),
    "only a link": (robot(a=LINK), "no moving joint"),
    "link twice": (ONE.replace("</robot>", '<link name="a"/></robot>'), "link a: used twice; allowed: a name of its"),
    "joint twice": (TWO.replace('name="k"', 'name="j"'), "joint j: used twice"),
    "link without a name": (ONE.replace('<link name="a">', "<link>"), "link 1: no name"),
    "parent not there": (ONE.replace('parent link="a"', 'parent link="z"'), "'z'"),
    "no child": (ONE.replace('<child link="b"/>', ""), "<child>: 'nothing'"),
    "no type": (ONE.replace(' type="revolute"', ""), "no type"),
    "floating": (ONE.replace("revolute", "floating"), "type floating"),
    "unknown type": (ONE.replace("revolute", "ball"), "type ball"),
    "no axis": (ONE.replace('axis xyz="0 0 1"', 'axis xyz="0 0 0"'), "<axis>"),
    "two numbers": (ONE.replace("0.1 -0.2 0.3", "0.1 -0.2"), "3 finite numbers"),
    "nan": (ONE.replace("0.4 0.5", "nan 0.5"), "3 finite numbers"),
    "word": (ONE.replace('mass value="2"', 'mass value="two"'), "'two'"),
    "infinite mass": (ONE.replace('mass value="2"', 'mass value="inf"'), "<mass> value: 'inf'; allowed: a finite"),
    "negative mass": (ONE.replace('mass value="2"', 'mass value="-2"'), "<mass> value: '-2'; allowed: a mass of"),
    "no mass": (ONE.replace('<mass value="2"/>', ""), "<mass> value: missing"),
    "no moment": (ONE.replace('iyy="0.03"', ""), "link 'b' <inertia> iyy: missing; allowed: a number"),
    "limits crossed": (ONE.replace('lower="-2"', 'lower="3"'), "lower <= upper"),
    "negative effort": (ONE.replace('effort="9"', 'effort="-9"'), "at least 0"),
    "mimic": (ONE.replace("</joint>", '<mimic joint="x"/></joint>'), "follows 'x'"),
    "two ends": (TWO, "b (1 joint), c (1 joint)"),
    "two roots": (robot(joint("j", "a", "b"), a="", b=LINK, c=""), "2 links without a parent: a, c; allowed: one root"),
    "two parents": (robot(joint("j", "a", "c"), joint("k", "b", "c"), a="", b="", c=""), "carried by j and k"),
    "loop": (robot(joint("j", "a", "b"), joint("k", "b", "a"), c="", a="", b=""), "a loop through a, b; allowed"),
    "loop without a root": (robot(joint("j", "a", "b"), joint("k", "b", "a"), a="", b=""), "0 links without a parent"),
    "rotor": (ONE.replace("</robot>", '<transmission><joint name="j"/><actuator><drake:gear_ratio value="x"/>'
                          "</actuator></transmission></robot>"), "gear_ratio"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_file_is_one_line(tmp_path, case, caplog):
    text, words = BROKEN[case]
    with pytest.raises(UrdfError) as caught:
        read_urdf(written(tmp_path, text))
    message = str(caught.value)
    assert message.startswith("arm.urdf: ")
    assert words in message
    assert "allowed" in message
    assert "\n" not in message
    assert not caplog.records


def test_wrong_tips_locks_and_files_that_cannot_be_read_are_refused(tmp_path):
    path = written(tmp_path, TWO)
    for error, words, options in (
        (UnknownNameError, "known: b, c, a", {"tip": "z"}),
        (UnknownNameError, "known: j, k", {"tip": "b", "lock": {"z": 0.0}}),
        (UrdfError, "no moving joint", {"tip": "a"}),
    ):
        with pytest.raises(error, match=words):
            read_urdf(path, **options)
    for path, words in ((tmp_path / "none.urdf", "no such file"), (tmp_path, "directory")):
        with pytest.raises(FileAccessError, match=words):
            read_urdf(path)
    binary = tmp_path / "binary.urdf"
    binary.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(UrdfError):
        read_urdf(binary)


@given(arms)
def test_half_a_file_never_breaks_the_reader(tmp_path_factory, arm):
    text = urdf_text(arm)
    path = written(tmp_path_factory.getbasetemp(), text[: int(len(text) * 0.6)])
    with pytest.raises(LwrDynError):
        read_urdf(path)
