"""A document as a page: whole tables and cards, nothing loaded, scripts only where allowed; what a notebook shows."""

import re

import pytest

from lwr_dyn.foundation.document import Document, Fact, Note, PageFigure, Section
from lwr_dyn.foundation.tables import Heading, Marked, Table
from lwr_dyn.pages.document import POLICY, document_html, notebook_html, page_html, table_html


def test_names_are_escaped_and_nothing_is_loaded():
    text = document_html("<img src=x>", "a & b", "<h1>x</h1>", "lwr-dyn <x>")
    assert "<img" not in text
    assert "<span>a &amp; b</span>" in text
    assert "<script" not in text
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", text)
    assert re.findall(r"url\((?!data:)", text) == []
    assert "@@" not in text


def test_a_policy_stands_in_the_head_and_scripts_at_the_end():
    assert f'content="{POLICY}"' in document_html("x", "y", "", "z")
    text = document_html("x", "y", "", "z", style=".own{}", scripts="<script>1</script>\n", policy="default-src 'none'")
    assert "content=\"default-src 'none'\"" in text
    assert text.index(".own{}") < text.index("</style>") < text.index("<script>1") < text.index("</body>")


def found(**more) -> Document:
    columns = (
        Heading("joint", key="joint"),
        Heading("state", key="state", pick=True),
        Heading("pull", key="pull", format=".1f", says="How far.", bar=2.0),
    )
    rows = [("a <1>", "good", 1.5), ("b", "bad", Marked(-0.1, "bad"))]
    facts = Fact("mass", 2.0, "Of <it>.", "mass", "kg")
    figure = PageFigure(lambda: "<svg></svg>", ".own {}", lambda: "<script>own()</script>\n")
    sections = [Section("", [Note("at < rest"), facts]), Section("Card", [Table("T", columns, rows), figure], **more)]
    return Document("A & b", "all holds", sections, "lwr-dyn made", "margins", caveats=("first",))


TABLE = (
    '<p class="pick"><label>show <select class="states"><option value="">all (2)</option>'
    '<option value="good">good (1)</option><option value="bad">bad (1)</option></select></label></p>'
    '<div class="scroll" tabindex="0" role="region" aria-label="T"><table><caption>T</caption><thead><tr>'
    '<th scope="col">joint</th><th scope="col">state</th><th scope="col" class="n" title="How far.">pull</th>'
    '</tr></thead><tbody><tr data-state="good"><th scope="row">a &lt;1&gt;</th><td>good</td><td class="n">'
    '<span class="pull"><span class="track"><i class="bar far" style="left:50.0%;width:37.5%"></i></span>'
    '<span class="m">1.5</span></span></td></tr><tr data-state="bad"><th scope="row">b</th><td>bad</td>'
    '<td class="n bad">-0.1 !</td></tr></tbody></table></div>'
)


def test_a_page_has_title_verdict_notes_tiles_and_cards():
    """What the first section says stands below the headline; its facts, and all else, are cards."""
    page = page_html(found())
    assert page[page.index("<h1>") : page.index("</main>")].strip() == (
        '<h1>A &amp; b</h1><ul class="say"><li>first</li><li>all holds</li><li>at &lt; rest</li></ul>'
        '<section class="card"><div class="tiles"><div title="Of &lt;it&gt;."><b>2.0 kg</b><span>mass</span>'
        "</div></div></section>"
        f'<section class="card"><h2>Card</h2><div class="pairs"><div class="half">{TABLE}</div></div>'
        "<svg></svg></section>"
    )
    assert page.index(".own {}") < page.index("<script>own()</script>\n<script>")
    assert "default-src 'none'; script-src 'unsafe-inline'" in page
    assert "base-uri 'none'" in page
    gone = page_html(found(there=False))
    assert "Card" not in gone
    assert "<script" not in gone
    assert f'content="{POLICY}"' in gone


def test_a_page_shows_columns_that_text_leaves_out():
    table = Table("", [Heading("one"), Heading("two", page=True)], [("a", "b")])
    assert "two" in page_html(Document("d", "v", [Section("s", [table])]))
    assert "two" not in table.text()


@pytest.mark.parametrize(
    ("columns", "longest", "rows", "wide", "tall", "stacks"),
    [
        (3, 150, 16, "half", "scroll", False),
        (4, 150, 17, "half", "scroll tall", True),
        (5, 1, 1, "half", "scroll", True),
        (6, 1, 1, "wide", "scroll", True),
        (2, 151, 1, "wide", "scroll", False),
    ],
)
def test_a_table_is_wide_tall_or_stacked_by_its_size(columns, longest, rows, wide, tall, stacks):
    table = Table("", [f"h{k}" for k in range(columns)], [("x" * longest,) * columns] * rows)
    page = page_html(Document("d", "v", [Section("s", [table])]))
    assert f'<div class="{wide}"><div class="{tall}" tabindex="0" role="region" aria-label="table"><table' in page
    assert ('<table class="stacks">' in page) == ('data-label="h1"' in page) == stacks


def cell(heading, value):
    """The second cell of a row."""
    (found,) = re.findall(r"(<td.*</td>)", table_html(Table("", ("a", heading), [("x", value)]).shown(page=True)))
    return found


@pytest.mark.parametrize(
    ("heading", "value", "html"),
    [
        (Heading("b"), 2.5, '<td class="n">2.5</td>'),
        (Heading("b"), True, "<td>True</td>"),
        (Heading("b"), "t < u", "<td>t &lt; u</td>"),
        (Heading("b"), Marked(2.5, "best"), '<td class="n"><b>2.5 *</b></td>'),
        (Heading("b"), Marked(2.5, "bad"), '<td class="n bad">2.5 !</td>'),
        (Heading("b", cut=9), "one two three",
         "<td><details><summary>one two ...</summary>one two three</details></td>"),
        (Heading("b", cut=13), "one two three", "<td>one two three</td>"),
        (Heading("b", shade=lambda x: x / 10), 2.5,
         '<td class="n" style="background:color-mix(in srgb, var(--alarm) 25%, transparent)">2.5</td>'),
        (Heading("b", shade=lambda x: 0.0), 2.5, '<td class="n">2.5</td>'),
        *((Heading("b", bar=2.0), x, '<td class="n"><span class="pull"><span class="track"><i class="bar'
           f'{far}" style="left:{left}%;width:{wide}%"></i></span><span class="m">{x}</span></span></td>')
          for x, far, left, wide in ((0.6, "", "50.0", "15.0"), (0.61, " far", "50.0", "15.2"),
                                     (-1.0, " far", "25.0", "25.0"), (-5.0, " far", "0.0", "50.0"))),
    ],
)  # fmt: skip
def test_a_cell_is_a_number_a_text_a_mark_a_shade_or_a_bar(heading, value, html):
    assert cell(heading, value) == html


def test_a_list_chooses_rows_only_where_there_is_a_choice():
    heads = ("a", Heading("b", pick=True))
    assert "<select" not in table_html(Table("", heads, [("x", "one"), ("y", "one")]).shown(page=True))
    text = table_html(Table("", heads, [("x", "one"), ("y", "two"), ("z", "one")], "a note").shown(page=True))
    assert re.findall(r"<option.*?</option>", text) == [
        '<option value="">all (3)</option>', '<option value="one">one (2)</option>',
        '<option value="two">two (1)</option>',
    ]  # fmt: skip
    assert text.endswith('</div><p class="note">a note</p>')


def test_a_notebook_shows_verdict_facts_and_brief_tables():
    head = "<b>all holds</b><div>first</div><div>mass: 2.0 kg</div><div>at &lt; rest</div>"
    assert notebook_html(found()) == head
    assert notebook_html(found(brief=True)) == (
        f'{head}<table><caption style="text-align:left">T</caption><thead><tr><th scope="col">joint</th>'
        '<th scope="col">state</th><th scope="col">pull</th></tr></thead><tbody>'
        '<tr><th scope="row">a &lt;1&gt;</th><td>good</td><td>1.5</td></tr>'
        '<tr><th scope="row">b</th><td>bad</td><td>-0.1 !</td></tr></tbody></table>'
    )


@pytest.mark.parametrize(("rows", "more"), [(12, ""), (13, "and 1 more"), (30, "and 18 more")])
@pytest.mark.parametrize(("letters", "shown"), [(160, "x" * 160), (161, f"{'x' * 156} ...")])
def test_long_lines_and_tables_are_cut_in_a_notebook(rows, more, letters, shown):
    table = Table("", ("n",), [(str(i),) for i in range(rows)], "a note")
    text = notebook_html(Document("x" * letters, "", [Section("", [table], brief=True)]))
    body = "".join(f'<tr><th scope="row">{i}</th></tr>' for i in range(min(rows, 12)))
    notes = "".join(f'<div style="color:var(--soft,inherit)">{x}</div>' for x in (more, "a note") if x)
    head = '<table><thead><tr><th scope="col">n</th></tr></thead>'
    assert text == f"<b>{shown}</b>{head}<tbody>{body}</tbody></table>{notes}"
