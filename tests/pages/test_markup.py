"""HTML from records: what is escaped, what an attribute is called, a table with its headings."""

from lwr_dyn.pages.markup import Html, anchor, element, grid, joined


def test_text_is_escaped_and_html_is_not():
    assert joined(["a < b", Html("<i>c</i>"), None, ("d", ["&"])]) == "a &lt; b<i>c</i>d&amp;"
    assert isinstance(joined([]), Html)


def test_attributes():
    made = element("label", "x", for_="y", aria_label='"1" < 2', hidden=True, title=None, open=False, width=0)
    assert made == '<label for="y" aria-label="&quot;1&quot; &lt; 2" hidden width="0">x</label>'
    assert element("b") == "<b></b>"


def test_a_table_scrolls_and_its_first_column_names_the_rows():
    made = grid("A & B", ["", "kg m^2"], [("m1", "1 < 2", Html("<td>3</td>"))], "dense", id="t")
    assert made == (
        '<div class="scroll" role="region" tabindex="0" aria-label="A &amp; B, scrolls sideways">'
        '<table class="dense" id="t"><thead><tr><th scope="col"></th><th scope="col">kg m\u00b2</th></tr></thead>'
        '<tbody><tr><th scope="row">m1</th><td>1 &lt; 2</td><td>3</td></tr></tbody></table></div>'
    )
    assert '<table class="plain">' in grid("x", [], [])


def test_an_anchor_has_no_odd_characters():
    assert anchor("run", "a/b  c_1.5\u00e4") == "run-a-b-c_1.5-"
