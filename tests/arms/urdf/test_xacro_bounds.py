"""A foreign xacro file that would take the machine's time or memory is refused in a second; others cost nothing."""

import os
import sys
import threading
import time
from collections import Counter

import pytest
import xacro

from lwr_dyn.arms.urdf.xacro_bounds import _MACRO_ARGUMENT, LARGEST_FILE, LARGEST_YAML
from lwr_dyn.arms.urdf.xacro_expressions import Expressions
from lwr_dyn.arms.urdf.xacro_files import expand_xacro
from lwr_dyn.foundation.errors import UrdfError
from tests.arms.urdf.small_files import HEAD, xacro_file

MANY = "<a/>" * 20000
HUNGRY = {
    "arguments that double": "<xacro:arg name='a0' default='aaaaaaaa'/>"
    + "".join(f"<xacro:arg name='a{i + 1}' default='$(arg a{i})$(arg a{i})'/>" for i in range(30)),
    "a folder searched from the root": "<xacro:include filename='/*/*/*/*/*/*.nothing'/>",
    "a body cloned for nothing": f"<xacro:macro name='m'><xacro:if value='0'>{MANY}</xacro:if></xacro:macro>"
    + "<xacro:m/>" * 1000,
    "a block cloned for nothing": f"<xacro:property name='p'><xacro:if value='0'>{MANY}</xacro:if></xacro:property>"
    + "<xacro:insert_block name='p'/>" * 1000,
    "children moved one by one": "<xacro:if value='1'><a/></xacro:if>" * 25000,
    "comments taken away one by one": "<!---->" * 130000 + "<xacro:if value='0'/>",
    "a text of dollars": f"<link name='{'$a' * 400000}'/>",
    "a long parameter list": f"<xacro:macro name='m' params='{'a ' * 100000}'><a/></xacro:macro>",
    "files that include twice": "<xacro:include filename='i0.xacro'/>",
    "a long file": MANY * 20,
    "a pipe": "<xacro:include filename='pipe'/>",
    "a pipe of YAML": "<link name=\"${xacro.load_yaml('pipe')}\"/>",
    "a long file of YAML": "<link name=\"${xacro.load_yaml('long.yaml')}\"/>",
    "bytes of YAML": "<link name=\"${len(xacro.load_yaml('bytes.yaml').b * 1500000000)}\"/>",
    "substitutions that make others": "<xacro:property name='s' value=\"${'a' + ') $' + '(arg a'}\"/>"
    "<xacro:arg name='a' default='b'/><link name='$(arg ${s})'/>",
}


@pytest.fixture
def place(tmp_path):
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe")
    (tmp_path / "long.yaml").write_text("#" * (LARGEST_YAML + 1))
    (tmp_path / "full.yaml").write_text("#" * LARGEST_YAML)
    (tmp_path / "bytes.yaml").write_text("b: !!binary YWJj\n")
    for i in range(20):
        (tmp_path / f"i{i}.xacro").write_text(HEAD + f"<xacro:include filename='i{i + 1}.xacro'/>" * 2 + "</robot>")
    (tmp_path / "i20.xacro").write_text(HEAD + "<a/>" * 100 + "</robot>")
    return tmp_path


def expanded(place, body, **options):
    return expand_xacro(xacro_file(place, body), **options)


@pytest.mark.parametrize("kind", HUNGRY)
def test_what_takes_time_or_memory_is_refused(place, kind):
    start = time.process_time()
    with pytest.raises(UrdfError) as refused:
        expanded(place, HUNGRY[kind])
    assert time.process_time() - start < 5.0
    assert len(str(refused.value)) < 2000


BLOCKS = "".join(f"<xacro:property name='p'>{x}</xacro:property>" for x in ("<a/><b/>", "<a/>", "<a/>"))
COSTS = {  # what counts it, how much it is, and why: letters by 10, nodes by 60 where they are cloned, moves by 1 / 20
    "<xacro:arg name='x' default='yz'/><a b='$(arg x)'/>": ("eval_extension", 1000 + 10 * 2),
    "<xacro:include filename='f*.xacro'/>": ("glob", 1000),
    "<xacro:include filename='f.xacro'/>": ("_file", 20_000 + 5 * len(f"{HEAD}<a/></robot>")),
    "<a b='${xacro.load_yaml(\"full.yaml\")}'/>": ("_file", 20_000 + 50 * LARGEST_YAML),
    f"<a b='{'$${x' * 128}'/>": ("eval_text", 4 * 128 * 2 * 128 // 1024 + 3 * 128),
    f"<xacro:macro name='m' params='{'a ' * 150}'/>": ("grab_macro", 300 * 300 // 1000),
    "<xacro:macro name='m'><a/>b<c><d/></c></xacro:macro><xacro:m/>": ("resolve_macro", 1000 + 60 * (1 + 4)),
    BLOCKS: ("grab_property", 3 + 2 + 2),
    f"{BLOCKS}<xacro:insert_block name='p'/>": ("check_attrs", 60 * 3),
    "<xacro:property name='p'><a/></xacro:property><xacro:insert_block name='p'/>": ("replace_node", 60 * 2),
    f"<xacro:if value='1'><a/><b/></xacro:if>{'<d/>' * 29}": ("replace_node", (1 + 2) * (30 + 2) // 20),
    f"{'<!---->' * 29}<xacro:if value='0'/>": ("remove_previous_comments", 30 * 30 // 20),
    f"{'<!---->' * 29}<c/> <!----><xacro:if value='0'/>": ("remove_previous_comments", 3 * 33 // 20),
}


@pytest.mark.parametrize("body", COSTS)
def test_what_is_made_read_or_moved_counts_as_much_as_it_costs(place, monkeypatch, body):
    (place / "f.xacro").write_text(f"{HEAD}<a/></robot>")
    counted, count = Counter(), Expressions.count

    def noted(self, size):
        counted[sys._getframe(1).f_code.co_name] += size
        count(self, size)

    monkeypatch.setattr(Expressions, "count", noted)
    expanded(place, body)
    of_all = counted.copy()
    counted.clear()
    expanded(place, "")
    by, cost = COSTS[body]
    assert of_all[by] - counted[by] == cost + (5 * len(body) if by == "_file" else 0)


BOUNDS = (  # just allowed, one more, and what refuses it
    ("<!--{}-->", LARGEST_FILE - len(f"{HEAD}<!----></robot>"), f"of {LARGEST_FILE + 1} bytes, above {LARGEST_FILE}"),
    ("<xacro:macro name='m' params='{}'/>", 10_000, "parameters of 10001 characters"),
    ("<xacro:property name='{}' value='1'/>", 9_999, "must be valid python identifiers"),
    ("<xacro:arg name='{0}' default='b'/><a b='$(arg {0})'/>", 9_993, "a substitution that makes others"),
)


@pytest.mark.parametrize(("body", "most", "words"), BOUNDS, ids=range(len(BOUNDS)))
def test_sizes_are_bounded_where_they_are_said_to_be(place, body, most, words):
    expanded(place, body.format("a" * most))
    with pytest.raises(UrdfError, match=words):
        expanded(place, body.format("a" * (most + 1)))


@pytest.mark.parametrize("quotes", ["x" * 60 + "'", "'" * 61, "x" * 60 + '"'])
def test_a_parameter_with_an_open_quote_is_no_puzzle(place, quotes):
    quoted = quotes.replace('"', "&quot;")
    assert "<robot" in expanded(place, f'<xacro:macro name="m" params="a:={quoted}"><a/></xacro:macro>')


def test_parameters_and_arguments_of_eval_are_read_as_xacro_reads_them(place):
    for text in (
        "a:=1 b", "a=1", "a:=^ b:=2", "a:=^|3 b", "a:='x y' b", 'a:="x y"', "a:=${1 + 2} b", "a:=$(arg x) b", "a b",
        "*origin a:=b", "a:= b:=2", "a:=x'y z'w b", "  a  :=  1\n  b:=2",
    ):  # fmt: skip
        ours, theirs = _MACRO_ARGUMENT.match(text), xacro.re_macro_arg.match(text)
        assert (ours and ours.groups()) == (theirs and theirs.groups()), text
    body = '<xacro:arg name="n" default="3"/><xacro:arg name="side" default="left"/>'
    body += '<link name="$(eval n * 2 + 3)"/><link name="$(eval side == \'left\' and true and pi > n)"/>'
    assert expanded(place, body).count('name="9"') == 1
    assert expanded(place, body) == expanded(place, body, trust=True)


def test_wildcards_blocks_and_namespaces_work(place):
    (place / "parts").mkdir()
    for k in range(3):
        (place / "parts" / f"p{k}.xacro").write_text(f'{HEAD}<link name="l{k}"/></robot>')
    (place / "c.xacro").write_text(f'{HEAD}<xacro:property name="v" value="2"/></robot>')
    (place / "c.yaml").write_text("lower: !degrees 90\nnames: [a, b]\n")
    body = """<xacro:include filename="parts/*.xacro"/><xacro:include filename="c.xacro" ns="c"/>
      <xacro:property name="limits" value="${xacro.load_yaml('c.yaml')}"/>
      <xacro:property name="o"><origin xyz="${c.v} 0 0"/></xacro:property>
      <xacro:macro name="part" params="name *at n:=${1 + 1} t:='a b'">
        <link name="${name}_${n}"><xacro:insert_block name="at"/></link>
        <xacro:if value="${n &gt; 0}"><xacro:part name="${name}" n="${n - 1}"><origin/></xacro:part></xacro:if>
      </xacro:macro>
      <xacro:part name="${limits.names[1]}"><origin rpy="${limits['lower']} 0 0"/></xacro:part>
      <link name="z"><xacro:insert_block name="o"/></link>"""
    ours = expanded(place, body)
    assert ours == expanded(place, body, trust=True)
    assert ours.count("<link") == 7
    assert "1.57" in ours


def test_threads_do_not_take_each_others_guard_away(place):
    """While one thread leaves xacro as it was, another one still expands a foreign file."""
    target, faults = place / "PWNED", []
    slow = place / "slow.urdf.xacro"
    many = '<a b="${1 + 1}"/>' * 1000
    slow.write_text(f"{HEAD}{many}</robot>")
    bad = place / "bad.urdf.xacro"
    escape = f"[b.gi_frame.f_back.f_back.f_builtins['op'+'en']('{target}', 'w') for b in [(x for x in [1])]]"
    bad.write_text(f'{HEAD}{many}<link name="${{{escape}}}"/></robot>')

    def run(path):
        try:
            expand_xacro(path)
        except UrdfError as fault:
            faults.append(str(fault))

    for _ in range(2):
        threads = [threading.Thread(target=run, args=(path,)) for path in (slow, bad, slow)]
        for thread in threads:
            thread.start()
            time.sleep(0.02)
        for thread in threads:
            thread.join()
    assert len(faults) == 2
    assert not target.exists()
