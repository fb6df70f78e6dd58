"""Short functions in the place of their calls: the same numbers, worked out once, and only where they were before."""

import math

import pytest

from lwr_dyn.kinematics.closed_forms import tree
from lwr_dyn.kinematics.closed_forms.inlining import MOST_SET, inlined, is_short
from lwr_dyn.kinematics.closed_forms.python_text import python_text
from lwr_dyn.kinematics.closed_forms.text_parser import parsed

SHORT = """
static double larger(double a, double b)
{
    return b > a ? b : a;
}

static double rest(double x)
{
    const double y = x / 3.0;
    return x - 3.0 * floor(y);
}

static double first(const double *a, int at)
{
    return larger(a[at], a[at + 1]);
}
"""


def made(body, arguments="double x, double y"):
    text = parsed(f"{SHORT}\ndouble f({arguments})\n{{\n{body}\n}}\n", {})
    written, names = python_text(text), {}
    exec(written, names)
    return names["f"], written[written.index("def f(") :], inlined(text)


def test_calls_are_gone_with_the_same_numbers_of_arrays_and_in_each_turn_of_a_loop():
    f, written, text = made("return larger(x + 1.0, rest(y * y)) + larger(x, y);")
    assert "larger" not in written
    assert "rest" not in written
    assert f(0.5, 4.0) == max(1.5, 1.0) + 4.0
    assert [each.name for each in text.functions] == ["larger", "rest", "first", "f"]
    assert written.count("* y") == 1  # an argument is worked out once
    f, written, _ = made("return first(v, 1) + first(v, 0);", "const double *v")
    assert "first" not in written
    assert f([1.0, 5.0, 2.0]) == 10.0
    body = "double out = x;\nwhile (out < y) {\n out = larger(out + 1.0, rest(out));\n}\nreturn out;"
    f, written, _ = made(body)
    assert "larger" not in written
    assert f(0.5, 3.0) == 3.5
    assert math.isnan(made("return rest(x);")[0](math.nan, 0.0))


@pytest.mark.parametrize(
    ("body", "wanted"),
    [
        ("return x > 0.0 ? larger(1.0 / x, y) : y;", 2.0),
        ("return x > 0.0 && larger(1.0 / x, y) > 1.0 ? 3.0 : 4.0;", 4.0),
        ("double out = 0.0;\nif (x > 0.0) {\n out = larger(1.0 / x, y);\n}\nreturn out;", 0.0),
    ],
)
def test_what_may_not_be_worked_out_is_not(body, wanted):
    """It would divide by zero."""
    assert made(body)[0](0.0, 2.0) == wanted


def test_only_short_functions_are_put_in():
    many = "".join(f"    const double k{i} = x;\n" for i in range(MOST_SET + 1))
    text = parsed(
        f"double g(double x)\n{{\n{many}    return k0;\n}}\ndouble f(double x)\n{{\n    return g(x);\n}}\n", {}
    )
    assert not is_short(text.functions[0])
    assert is_short(text.functions[1])
    assert isinstance(inlined(text).functions[1].body[0].value, tree.CCall)
