"""Expressions of xacro files: the benign ones as xacro reads them, and no code of the file runs."""

import re

import pytest
import xacro

from lwr_dyn.arms.urdf.xacro_expressions import LONGEST, MOST_IN_ALL, ExpressionError, Expressions, _size

BENIGN = """
1
-0.5e-3
2**3 * pi / 180
(a + 1) // 2 % 3 - -a
radians(90) + math.sin(math.pi / 6) + sqrt(2)
prefix + 'link_' + str(3)
'%s_%d' % (prefix, 3)
limits['elbow']['max'] * 2
limits.elbow.max
[1, 2, 3][1:]
(1, 2)[-1] in [2, 3]
a == 1 and prefix != '' or not a
1 < 2 <= 2 < a
'yes' if a >= 1 else 'no'
max(1, min(2, 3)) + python.abs(-2) + round(2.567, 2) + len(prefix)
float('1.5') + int('2') + python.abs(-3)
prefix.upper().split('_')
'-'.join(['a', 'b']).replace('-', '+')
'elbow' in limits.keys()
limits.get('wrist', {'max': 0})['max']
list(python.enumerate([1, 2]))
{'a': 1}['a']
python.sum([1, 2]) + python.sorted([3, 1])[0] + list(python.range(4))[-1]
xacro.tokenize('1 2,3')
xacro.tokenize('a,;b c', ',;', False)
xacro.tokenize('a,;b c')
python.dict([(1, 2)], a=3)
python.dict({'b': 1}) == {'b': 1}
python.sorted(python.set([3, 1, 3])) + python.list(python.set())
python.list(python.zip('ab', [1, 2])) + python.list(python.reversed([1, 2]))
round(2.5) + round(1234.5, -2) + python.divmod(7, 2)[1]
python.range(9)[2:8:3] == python.range(2, 8, 3)
3 * [1, 2] + [0] * 2
0 or [] or 'last'
1 and 0 and 2
1 < 2 > 3
not a is None
'%s and %05.1f' % ('a', 2)
xacro.dotify({'a': {'b': 2}}).a.b
atan2(1, 1) * hypot(3, 4)
None is None
[]
True
""".strip().splitlines()
RUNS_CODE = """
().__class__.__base__.__subclasses__()
[c for c in ().__class__.__base__.__subclasses__() if c.__name__=='_wrap_close'][0].__init__.__globals__['system']('x')
[b.gi_frame.f_back.f_back.f_builtins['__imp'+'ort__']('os').getpid() for b in [(x for x in [1])]]
(x for x in [1]).gi_frame
(lambda: 1)()
'{0.__class__}'.format(1)
'{0.__class__}'.format_map({})
f'{a.__class__}'
math.sin.__self__
python.type(1)
python.vars(math)
python['type'](1)
math['sin'].__self__
limits.__class__
limits._x
prefix.__class__
sorted([1], key=python.vars)
sorted([1], key=xacro['load_yaml'])
max
[max][0](1, 2)
(y := 1)
[x for x in [1]]
{x: 1 for x in [1]}
len(*[[1]])
dict(**{'a': 1})
__import__('os')
xacro.load_yaml.__globals__
b'x'
...
1j
""".strip().splitlines()
GROWS = """
9**9**9
2**10000 * 2**10000
'a' * 10000000000
[0] * 10000000000
10000000000 * 'a'
[[0] * 1000] * 10000
'%1000000000d' % 1
'%*d' % (1000000000, 1)
range(10**12)
round(1, -10**9)
1 << 10**9
('a' * 1000000) + ('a' * 1000000)
('a' * 1000000).replace('a', 'a' * 1000000)
('a' * 1000000).join(['b', 'b', 'b'])
math.factorial(10**6)
math.lcm(2, 3)
int('f' * 900000, 16) // int('e' * 400000, 16)
python.set(python.range(0, 1000 * (2**61 - 1), 2**61 - 1))
python.dict(python.enumerate('a' * 1000))
('%(a)s' * 1000) % {'a': 'a' * 100000}
('%(a)999s' * 10000) % {'a': 'a'}
xacro.tokenize('aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa!', 'x]|(a+)+$|[y')
""".strip().splitlines()


@pytest.fixture
def names():
    symbols = xacro.Table(xacro.create_global_symbols())
    symbols["prefix"], symbols["a"] = "left_arm_", 1
    symbols._setitem("limits", xacro.YamlDictWrapper({"elbow": {"max": 3.0}}), unevaluated=False)
    return symbols


@pytest.mark.parametrize("text", BENIGN)
def test_what_is_read_has_the_value_that_xacro_gives(names, text):
    assert Expressions()(text, names) == xacro.safe_eval(text, names)


@pytest.mark.parametrize("text", RUNS_CODE)
def test_what_could_reach_python_itself_is_refused(names, text):
    with pytest.raises((ExpressionError, NameError)):
        Expressions()(text, names)


@pytest.mark.parametrize("text", GROWS)
def test_what_grows_without_bound_is_refused(names, text):
    with pytest.raises(ExpressionError):
        Expressions()(text, names)


def test_values_of_a_file_are_counted_together_those_on_the_way_too(names):
    read = Expressions()
    for _ in range(MOST_IN_ALL // LONGEST - 1):
        read(f"'a' * {LONGEST}", names)
    with pytest.raises(ExpressionError, match="without end"):
        read(f"'a' * {LONGEST}", names)
    names._setitem("long", "ab" * 100_000, unevaluated=False)
    names._setitem("many", list(range(100_000)), unevaluated=False)
    for text in ("len(('ab ' * 100000).split())", "long.count('aba')", "len(python.sorted(many))", "many == many"):
        with pytest.raises(ExpressionError, match="without end"):
            _again_and_again(Expressions(), text, names)


def _again_and_again(read, text, names):
    for _ in range(100):
        read(text, names)


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        ("gone + 1", NameError, "'gone' is not defined"),
        ("prefix(1)", TypeError, "prefix is no function"),
        ("a[0]", ExpressionError, "an index of a"),
        ("factorial(3)", ExpressionError, "a call of factorial"),
        ("1" + " + 1" * 3000, ExpressionError, "longer than 10000 characters"),
    ],
    ids=range(5),
)
def test_what_cannot_be_read_is_said(names, text, error, words):
    with pytest.raises(error, match=words):
        Expressions()(text, names)


BOUNDS = (  # what is just allowed, one more, and the words of its refusal
    (f"len('a' * {LONGEST - 1})", f"len('a' * {LONGEST + 1})", f"a value longer than {LONGEST} characters"),
    ("len(python.range(0, 300000, 3))", "len(python.range(0, 3000003, 3))", f"a range longer than {LONGEST} character"),
    ("round(1.25, 400)", "round(1.25, -401)", "round to -401 digits"),
    ("most", "one_more", "a number of more than 10000 bits"),
    ("-most", "least", "a number of more than 10000 bits"),
    ("2**5000", "2**5001", "a power of more than 10000 bits"),
    ("half * half", "half * (half + half)", "a product of more than 10000 bits"),
    ("python.set(keys)", "python.set(keys + [300])", "a set or dictionary of more than 300 numbers"),
    ("python.dict(python.enumerate(keys))", "python.dict(python.enumerate(keys + [0]))", "of more than 300 numbers"),
    ("'%999d' % 1", "'%1000d' % 1", "a width of more than three digits in a format"),
    ("text.replace('a', 'bcd')", "text.replace('a', 'bcdef')", f"a value longer than {LONGEST} characters"),
    ("text.join(['', '', ''])", "text.join(['', '', '', '', '', ''])", f"a value longer than {LONGEST} characters"),
)


@pytest.mark.parametrize(("good", "bad", "words"), BOUNDS)
def test_bounds_are_where_they_are_said_to_be(names, good, bad, words):
    values = {"most": 2**20_000 - 1, "one_more": 2**20_000, "least": -(2**20_000), "half": 2**4999}
    for name, value in {**values, "text": "a" * 200_000, "keys": list(range(300))}.items():
        names._setitem(name, value, unevaluated=False)
    assert Expressions()(good, names) == xacro.safe_eval(good, names)
    with pytest.raises(ExpressionError, match=re.escape(words)):
        Expressions()(bad, names)


def test_a_value_counts_its_characters_and_members_and_each_list_as_ten():
    values = ("abc", 5, None, [1, "ab"], [[1], [2]], {"a": 1}, ())
    assert [_size(value) for value in values] == [4, 1, 1, 14, 34, 13, 10]
    with pytest.raises(ExpressionError, match="a value longer than"):  # its parts are short, all together are not
        _size([["a" * 600_000], ["a" * 600_000]])


def test_values_of_many_levels_and_those_that_are_not_plain_are_refused(names):
    deep = [1]
    for _ in range(45):
        deep = [deep]
    names._setitem("deep", deep, unevaluated=False)
    assert Expressions()("len(deep)", names) == 1
    for _ in range(10):
        deep = [deep]
    names._setitem("deeper", deep, unevaluated=False)
    with pytest.raises(ExpressionError, match="a value of more than 50 levels"):
        Expressions()("len(deeper)", names)
    for value, kind in ((b"abc", "bytes"), (object(), "object")):
        dict.__setitem__(names, "odd", value)
        with pytest.raises(ExpressionError, match=f"of the kind {kind}"):
            Expressions()("odd * 1000000000", names)
