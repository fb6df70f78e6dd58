import pytest

from lwr_dyn.checks.urdf.xml_tree import Place, XmlFaultError, read_tree


def test_places_count_lines_and_code_points_from_one():
    root = read_tree('<robot>\n  <a/><!-- ä𝛼 --><b\n x="1"\n/>\n</robot>', "f")
    assert [child.place for child in root.children] == [Place("f", 2, 3), Place("f", 2, 18)]


def test_places_beyond_65535_lines():
    root = read_tree("<robot>" + "\n" * 70_000 + " <link\n\nname='x'/><joint/></robot>", "f")
    assert [child.place for child in root.children] == [Place("f", 70_001, 2), Place("f", 70_003, 11)]


def test_blank_lines_before_the_declaration_and_nulls_at_the_end():
    root = read_tree(b"\n \n<?xml version='1.0'?>\n<robot><link/></robot>\0\n", "f")
    assert root.children[0].place == Place("f", 4, 8)


def test_undeclared_prefixes_are_part_of_the_tag():
    root = read_tree("<robot><drake:gear_ratio value='2'/></robot>", "f")
    assert root.children[0].tag == "drake:gear_ratio"


def test_a_comment_asks_to_ignore_codes_in_the_next_element_and_all_inside():
    text = "<robot><!-- lwr-dyn: ignore A-b, c --><link><mass/></link><link/></robot>"
    link, other = read_tree(text, "f").children
    assert link.ignored == link.children[0].ignored == {"a-b", "c"}
    assert other.ignored == frozenset()
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


def test_a_place_attribute_counts_only_where_places_are_carried():
    text = '<robot at.="7:8:m.xacro"/>'
    assert read_tree(text, "f", carried=True).place == Place("m.xacro", 7, 8)
    assert read_tree(text, "f").place == Place("f", 1, 1)
    for broken in ("x:8:m", "7:8", "7:8:", ""):
        assert read_tree(f'<robot at.="{broken}"/>', "f", carried=True).place == Place("f", 1, 1)


def test_three_thousand_nested_elements():
    root = read_tree("<robot>" + "<x>" * 3000 + "</x>" * 3000 + "</robot>", "f")
    assert root.children[0].tag == "x"
