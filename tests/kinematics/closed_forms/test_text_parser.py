"""The small part of C as a tree: precedence, whole numbers put in, what does not belong to it refused."""

import pytest

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.closed_forms import tree
from lwr_dyn.kinematics.closed_forms.text_parser import parsed


def body(text, **wholes):
    (function,) = parsed(f"static double f(const double *a, double x, int n)\n{{\n{text}\n}}\n", wholes).functions
    return function.body


def test_signs_of_a_higher_level_come_first_and_names_of_whole_numbers_are_those_numbers():
    (statement,) = body("return x - 1.0 - 2.0 * -x;")
    x, one = tree.CName("x"), tree.CNumber(1.0)
    assert statement.value.left == tree.CBinary("-", x, one)
    assert statement.value.right.sign == "*"
    (statement,) = body("return x < 1.0 && !(x > 2.0) || n == 3 ? x : 1.0;")
    assert isinstance(statement.value, tree.CChoice)
    assert statement.value.test.sign == "||"
    assert statement.value.test.left.sign == "&&"
    (loop,) = body("for (int i = 2; i < 3 * MANY; i += 4) {\n    x += a[i];\n}", MANY=5)
    assert loop == tree.CFor("i", tree.CNumber(2), tree.CBinary("*", tree.CNumber(3), tree.CNumber(5)), 4, loop.body)
    assert loop.body == (tree.CSet("", tree.CName("x"), tree.CBinary("+", tree.CName("x"), loop.body[0].value.right)),)
    (loop,) = body("for (int i = 0; i < 8; i += ROW) {\n n = n + (int)a[i];\n}", ROW=4)
    assert loop.step == 4
    assert loop.body[0].value.right == tree.CCall("int", (tree.CItem("a", tree.CName("i")),))


def test_else_if_is_a_branch_in_a_branch_and_arguments_and_constants_are_read():
    (first,) = body("if (x > 0.0) {\n n++;\n} else if (x < 0.0) {\n n--;\n} else {\n return x;\n}")
    (second,) = first.no
    assert isinstance(second, tree.CIf)
    assert len(second.no) == 1
    text = parsed("static const double A = 1e-3;\nint g(const double pose[16], double *q, int k)\n{\n}\n", {})
    assert text.constants == {"A": 1e-3}
    assert text.functions[0].arguments == (("double*", "pose"), ("double*", "q"), ("int", "k"))


@pytest.mark.parametrize("text", ["x = 1.0", "for (int i = 0; i > 3; i++) {\n}", "x @ 2.0;", "float y = x;"])
def test_what_is_not_of_it_is_refused(text):
    with pytest.raises((OptionError, AssertionError)):
        body(text)
