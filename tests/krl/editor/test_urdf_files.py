"""What the linter would write instead, as a change of the text."""

from pathlib import Path

import pytest

from lwr_dyn.krl.editor.urdf_files import UrdfRemark, is_urdf, quick_fix, tag_at

TEXT = '<robot>\n  <link name="a">\n    <mass\n      value="1"/>\n    <inerta>x</inerta>\n  </link>\n</robot>\n'


@pytest.mark.parametrize(
    ("place", "instead", "old", "new"),
    [
        ((3, 5), '<mass value="2"/>', '<mass\n      value="1"/>', '<mass value="2"/>'),
        ((2, 3), '<link name="b"/>', '"a"', '"b"'),
        ((5, 5), "<inertial>", "inerta", "inertial"),
        ((3, 5), "<maess>", "<mass", "<maess"),
        ((3, 5), "export it again", "", ""),
        ((3, 5), '<mass value="..."/>', "", ""),
        ((3, 5), '<mass value="1"/>, or none', "", ""),
        ((3, 5), '<axis xyz="0 0 1"/>', "", ""),
        ((3, 1), '<mass value="2"/>', "", ""),
        ((8, 1), '<mass value="2"/>', "", ""),
    ],
)
def test_a_whole_tag_is_replaced_and_stays_open_or_closed(place, instead, old, new):
    text = TEXT
    for first, last, piece in sorted(quick_fix(text, UrdfRemark("a.urdf", *place, "error", "", "", instead)))[::-1]:
        text = text[:first] + piece + text[last:]
    assert text == TEXT.replace(old, new)


@pytest.mark.parametrize("tag", ['<mass value="${m}"/>', '<mass value="$(find x)/a.stl"/>'])
def test_in_a_macro_nothing_is_written(tag):
    assert quick_fix(f"<robot>\n{tag}</robot>", UrdfRemark("", 2, 1, "error", "", "", '<mass value="2"/>')) == []


def test_a_tag_ends_where_no_text_in_it_does_and_files_are_known_by_their_endings():
    assert tag_at('<a b=">" c=\'"\'/>rest', 1, 1)[0] == '<a b=">" c=\'"\'/>'
    names = ("a.urdf", "a.URDF", "a.urdf.xacro", "a.xml", "a.src")
    assert [is_urdf(Path(x)) for x in names] == [True, True, True, False, False]
