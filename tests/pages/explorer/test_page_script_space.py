"""The page's scripts lose space and comments, and nothing else."""

import re
from importlib.resources import files

import pytest

from lwr_dyn.pages.explorer.page import _SPACE, without_space

SHORTENED = {
    'say("a  // b", `c  ${ d }  // e`);': 'say("a  // b",`c  ${ d }  // e`);',
    "x = y / 2 / z;": "x=y /2 /z;",
    "x = text.replace(/[\"'`] +/g, '');": "x=text.replace(/[\"'`] +/g,'');",
    "return a + +b - c;": "return a + +b -c;",
    "const { a, b: { c } } = d;": "const{a,b:{c}}=d;",
    "`${l.map((x) => `<i a='${x ? \"a b\" : ''}'>`)} end`;": "`${l.map((x) => `<i a='${x ? \"a b\" : ''}'>`)} end`;",
    "`a ${ { b: `c }` } } d`;": "`a ${ { b: `c }` } } d`;",
    "1 .toFixed(2);": "1 .toFixed(2);",
    "return .5;": "return .5;",
}


@pytest.mark.parametrize("line", SHORTENED)
def test_texts_templates_and_patterns_keep_their_space(line):
    assert without_space(line) == SHORTENED[line]
    assert without_space(SHORTENED[line]) == SHORTENED[line]


def test_comments_and_empty_lines_go():
    assert without_space("// head\n\n  a = 1; // one\n/* two\nlines */ b = 2;\n") == "a=1;\nb=2;"


def test_every_script_is_shortened_and_stays_as_it_is_the_second_time():
    scripts = [each for each in files("lwr_dyn.pages.explorer").iterdir() if each.name.endswith(".js")]
    assert len(scripts) > 20
    for each in scripts:
        text = each.read_text(encoding="utf-8")
        short = without_space(text)
        assert without_space(short) == short
        assert len(short) < len(text)
        assert not set(_SPACE.sub("", text)) & set("`\"'")  # every string and template was found whole
        assert short.count("`") == len(re.findall("`", re.sub(r"(?m)^\s*//.*$", "", text)))
