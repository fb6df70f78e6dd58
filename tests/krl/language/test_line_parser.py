"""The grammar and the functions that build its records name the same rules; lines of one shape share one tree."""

import pytest
from lark import Lark

from lwr_dyn.krl.language.lexer import GRAMMAR, KEYWORDS
from lwr_dyn.krl.language.line_parser import RULES, parse_line


@pytest.mark.slow
def test_each_rule_of_the_grammar_has_a_function_and_no_function_lacks_a_rule():
    rules = Lark(GRAMMAR, parser="lalr", lexer="basic", start="line", maybe_placeholders=True).rules
    named = {x.alias or str(x.origin.name) for x in rules if x.alias or not x.options.expand1}
    assert {name for name in named if not name.startswith("_")} == set(RULES)


def test_keywords_of_the_grammar_are_keywords_of_the_lexer():
    assert KEYWORDS["TRIGGER"] == "TRIGGER"
    assert KEYWORDS["SCIRC_REL"] == "CIRCULAR"
    assert "NAME" not in KEYWORDS


def test_a_line_of_a_known_shape_takes_its_own_tokens():
    for text in ("x = y + 1", "alpha = beta - 22"):
        assert parse_line(text)[0].target.name == text.split()[0]
        assert parse_line(text)[0].value.operator == text.split()[3]
