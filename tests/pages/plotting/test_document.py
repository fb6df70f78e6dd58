"""The frame of one-file documents: names escaped, nothing loaded, no colour of its own, scripts only where allowed."""

import re
from pathlib import Path

from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.replay_page import POLICY, document_html


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


def test_no_colour_is_named():
    style = (Path(replay_page.__file__).parent / "document.css").read_text("utf-8")
    assert re.findall(r"#[0-9a-fA-F]{3,8}\b", style) == []
