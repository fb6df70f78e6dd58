"""A document as a page: names escaped, nothing loaded, no colour of its own, scripts only where allowed."""

import re

from lwr_dyn.foundation.document import Document, Fact, Note, PageFigure, Section
from lwr_dyn.foundation.tables import Heading, Marked, Table
from lwr_dyn.pages.document import POLICY, document_html, notebook_html, page_html


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
    return Document("A & b", "all holds", sections, "lwr-dyn made", "margins")


def test_a_page_has_title_verdict_notes_tiles_and_cards():
    page = page_html(found())
    assert page == page_html(found())
    for part in ("<h1>A &amp; b</h1>", "<li>all holds</li><li>at &lt; rest</li>", '<div title="Of &lt;it&gt;.">',
                 "<b>2.0 kg</b>", "<h2>Card</h2>", ".own {}", "<script>own()</script>", 'data-state="good"',
                 '<option value="bad">bad (1)</option>', 'title="How far."', "a &lt;1&gt;"):  # fmt: skip
        assert part in page
    assert "default-src 'none'" in page
    assert "Card" not in page_html(found(there=False))
    assert "<script" not in page_html(found(there=False))


def test_a_notebook_shows_verdict_facts_and_brief_tables():
    short = notebook_html(found())
    assert short == "<b>all holds</b><div>mass: 2.0 kg</div><div>at &lt; rest</div>"
    brief = notebook_html(found(brief=True))
    assert '<tr><th scope="row">a &lt;1&gt;</th><td>good</td><td>1.5</td></tr>' in brief
    assert "<script" not in brief


def test_long_lines_and_tables_are_cut_in_a_notebook():
    rows = [(str(i),) for i in range(30)]
    text = notebook_html(Document("x" * 500, "", [Section("", [Table("", ("n",), rows)], brief=True)]))
    assert "and 18 more" in text
    assert len(text) < 1200
