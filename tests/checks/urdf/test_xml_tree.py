import pytest

from lwr_dyn.checks.urdf.xml_tree import Place, XmlFaultError, expand_with_places, numbers, read_tree, scalar, vector


@pytest.mark.parametrize(
    ("text", "places"),
    [
        ('<robot>\n  <a/><!-- ä𝛼 --><b\n x="1"\n/>\n</robot>', [(2, 3), (2, 18)]),  # code points, from one
        ("<robot>" + "\n" * 70_000 + " <link\n\nname='x'/><joint/></robot>", [(70_001, 2), (70_003, 11)]),
        (b"\n \n<?xml version='1.0'?>\n<robot><link/></robot>\0\n", [(4, 8)]),
    ],
    ids=("code points", "beyond 65535 lines", "blank lines and nulls around"),
)
def test_places_of_elements(text, places):
    assert [child.place for child in read_tree(text, "f").children] == [Place("f", *place) for place in places]


def test_undeclared_prefixes_are_part_of_the_tag_and_elements_may_be_nested_deep():
    deep = "<x>" * 3000 + "</x>" * 3000
    root = read_tree(f"<robot><drake:gear_ratio value='2'/>{deep}</robot>", "f")
    assert [child.tag for child in root.children] == ["drake:gear_ratio", "x"]


def test_a_comment_asks_to_ignore_codes_in_the_next_element_and_all_inside():
    text = "<robot><!-- lwr-dyn: ignore A-b, c --><link><mass/></link><link/></robot>"
    link, other = read_tree(text, "f").children
    assert (link.ignored, link.children[0].ignored, other.ignored) == ({"a-b", "c"}, {"a-b", "c"}, frozenset())
    assert read_tree("<!-- lwr-dyn: ignore x -->\n<robot><link/></robot>", "f").children[0].ignored == {"x"}


@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        (b"\n\n<robot>\n <link>\n</robot>", Place("f", 5, 3), "mismatched tag"),
        (b"", Place("f", 1, 1), "no element found"),
        (b"<?xml version='1.0' encoding='klingon'?><a/>", Place("f", 1, 1), "unknown encoding"),
    ],
)
def test_text_that_is_no_xml(text, place, said):
    with pytest.raises(XmlFaultError, match=said) as fault:
        read_tree(text, "f")
    assert fault.value.place == place


def test_behind_a_file_that_need_not_be_there_others_are_looked_for_where_they_are(tmp_path):
    space = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    absent, there = (
        '<xacro:include filename="sub/absent.xacro" optional="true"/>',
        '<xacro:include filename="b.xacro"/>',
    )
    (tmp_path / "a.xacro").write_text(f'<robot name="a" {space}>{absent}{there}</robot>')
    (tmp_path / "b.xacro").write_text(f'<robot {space}><link name="b"/></robot>')
    assert 'name="b"/>' in expand_with_places(tmp_path / "a.xacro", {})


def test_a_place_attribute_counts_only_where_places_are_carried():
    text = '<robot at.="7:8:m.xacro"/>'
    assert read_tree(text, "f", carried=True).place == Place("m.xacro", 7, 8)
    assert read_tree(text, "f").place == Place("f", 1, 1)
    for broken in ("x:8:m", "7:8", "7:8:", ""):
        assert read_tree(f'<robot at.="{broken}"/>', "f", carried=True).place == Place("f", 1, 1)


def test_numbers_of_attributes():
    """None beyond 1e15, 0 below 1e-30; a vector has three, and a default where it is not written."""
    assert [numbers(text) for text in ("9e14 -9e14", "1e15", "-1e15", "2e-30 1e-30", None)] == [
        (9e14, -9e14), None, None, (2e-30, 0.0), ()
    ]  # fmt: skip
    root = read_tree('<a one="4" two="1 2" three="1 2 3"/>', "f")
    assert [scalar(root, name) for name in ("one", "two", "none")] == [4.0, None, None]
    found = [vector(root, name, (7.0, 8.0, 9.0)) for name in ("one", "three", "none")]
    assert [x if x is None else x.tolist() for x in found] == [None, [1.0, 2.0, 3.0], [7.0, 8.0, 9.0]]
