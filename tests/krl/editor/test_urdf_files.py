"""What the linter would write instead, as a change of the text."""

import pytest

from lwr_dyn.krl.editor.urdf_files import UrdfRemark, is_urdf, quick_fix, tag_at

TEXT = '<robot>\n  <link name="a">\n    <mass\n      value="1"/>\n    <inerta>x</inerta>\n  </link>\n</robot>\n'


def fixed(text, line, column, instead):
    remark = UrdfRemark("a.urdf", line, column, "error", "code", "", instead)
    for first, last, new in sorted(quick_fix(text, remark), reverse=True):
        text = text[:first] + new + text[last:]
    return text


@pytest.mark.parametrize(
    ("place", "instead", "expected"),
    [
        ((3, 5), '<mass value="2"/>', TEXT.replace('<mass\n      value="1"/>', '<mass value="2"/>')),
        ((2, 3), '<link name="b"/>', TEXT.replace('"a"', '"b"')),
        ((5, 5), "<inertial>", TEXT.replace("inerta", "inertial")),
    ],
)
def test_a_tag_is_replaced_and_stays_open_or_closed(place, instead, expected):
    assert fixed(TEXT, *place, instead) == expected


@pytest.mark.parametrize(
    ("text", "place", "instead"),
    [
        (TEXT, (3, 5), "export it again"),
        (TEXT, (3, 5), '<mass value="..."/>'),
        (TEXT, (3, 5), '<mass value="1"/>, or none'),
        (TEXT, (3, 5), '<axis xyz="0 0 1"/>'),
        (TEXT, (3, 1), '<mass value="2"/>'),
        (TEXT, (99, 1), '<mass value="2"/>'),
        ('<robot>\n<mass value="${m}"/></robot>', (2, 1), '<mass value="2"/>'),
        ('<robot>\n<mesh filename="$(find x)/a.stl"/></robot>', (2, 1), '<mesh filename="b"/>'),
    ],
)
def test_without_a_whole_tag_or_in_a_macro_nothing_is_written(text, place, instead):
    assert fixed(text, *place, instead) == text


def test_a_tag_ends_where_no_text_in_it_does():
    assert tag_at('<a b=">" c=\'"\'/>rest', 1, 1)[0] == '<a b=">" c=\'"\'/>'


def test_files_are_known_by_their_endings(tmp_path):
    assert [is_urdf(tmp_path / x) for x in ("a.urdf", "a.URDF", "a.urdf.xacro", "a.xml", "a.src")] == [
        True, True, True, False, False,
    ]  # fmt: skip
