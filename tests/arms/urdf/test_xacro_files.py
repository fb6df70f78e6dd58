"""Foreign xacro files are expanded, and none of their code runs unless they are trusted."""

import pytest
import xacro

from lwr_dyn.arms.urdf.xacro_files import expand_xacro, package_folder
from lwr_dyn.cli.main import main
from lwr_dyn.foundation.errors import UrdfError
from tests.arms.urdf.small_files import xacro_file

WAYS = (
    "${{[c for c in ().__class__.__base__.__subclasses__() if c.__name__=='_wrap_close'][0]"
    ".__init__.__globals__['system']('touch {0}') for i in [1]]}}",
    "${{[b.gi_frame.f_back.f_back.f_builtins['op'+'en']('{0}', 'w') for b in [(x for x in [1])]]}}",
    "${{xacro.message.__globals__['os'].system('touch {0}')}}",
    "$(eval [].__class__)",
)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("place", ['<xacro:property name="p" value="{}"/><link name="${{p}}"/>', '<link name="{}"/>'])
def test_no_code_of_a_file_runs(tmp_path, way, place):
    target = tmp_path / "PWNED"
    value = way.format(target).replace("<", "&lt;").replace('"', "&quot;")
    with pytest.raises(UrdfError, match="xacro"):
        expand_xacro(xacro_file(tmp_path, place.format(value)))
    assert not target.exists()


def test_units_of_a_yaml_file_are_read_in_the_same_way_and_xacro_is_left_as_it_was(tmp_path):
    (tmp_path / "x.yaml").write_text("a: !degrees 2 * 45\nb: !degrees ().__class__\n", encoding="utf-8")
    path = xacro_file(tmp_path, "<link name=\"${xacro.load_yaml('x.yaml').a}\"/>")
    with pytest.raises(UrdfError, match="the attribute __class__"):
        expand_xacro(path)
    (tmp_path / "x.yaml").write_text("a: !degrees 2 * 45\n", encoding="utf-8")
    assert "1.57079" in expand_xacro(path)
    before = xacro.safe_eval, xacro.replace_node, xacro.parse
    expand_xacro(xacro_file(tmp_path, '<link name="${1 + 1}"/>'))
    assert (xacro.safe_eval, xacro.replace_node, xacro.parse) == before


def test_what_is_refused_says_how_it_is_trusted_and_trusted_it_is_run(tmp_path):
    path = xacro_file(tmp_path, "<link name=\"${'_'.join([str(i) for i in [1, 2]])}\"/>")
    with pytest.raises(UrdfError, match=r"ListComp in an expression.*--trust-xacro"):
        expand_xacro(path)
    assert 'name="1_2"' in expand_xacro(path, trust=True)
    with pytest.raises(UrdfError, match=r"'gone' is not defined.*a file that `xacro` expands"):
        expand_xacro(xacro_file(tmp_path, '<link name="${gone}"/>'))  # what xacro itself refuses


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (
            '<link name="$(find no_such_package)"/>',
            "the package no_such_package is not above or beside the file, or in",
        ),
        ("<link name=\"${xacro.load_yaml('none.yaml')}\"/>", r"No such file or directory: .*none\.yaml"),
    ],
)
def test_what_is_not_there_is_said(tmp_path, body, words):
    with pytest.raises(UrdfError, match=words):
        expand_xacro(xacro_file(tmp_path, body))


def test_long_messages_are_cut_and_of_a_package_file_the_beginning_is_read(tmp_path):
    def said(letters):
        with pytest.raises(UrdfError) as fault:
            expand_xacro(
                xacro_file(tmp_path, f"<xacro:macro name='m' params='a'/><xacro:m a='1' {'b' * letters}='1'/>")
            )
        return fault.value.found

    most = 600 - len(said(1)) + 1
    assert [len(said(most)), said(most + 1)] == [600, f"{said(most)[:-1]}b ..."]
    (tmp_path / "package.xml").write_text(f"{' ' * (100_000 - len('<name>x</name>'))}<name>x</name>")
    assert package_folder("x", tmp_path / "a.xacro") == tmp_path
    (tmp_path / "package.xml").write_text(f"{' ' * (100_000 - len('<name>'))}<name>x</name>")
    assert package_folder("x", tmp_path / "a.xacro") is None


def test_properties_and_macros_that_double_end(tmp_path):
    doubling = '<xacro:property name="p0" value="aaaaaaaa"/>'
    doubling += "".join(f'<xacro:property name="p{i + 1}" value="${{p{i}}}${{p{i}}}"/>' for i in range(40))
    with pytest.raises(UrdfError, match=r"longer than|without end"):
        expand_xacro(xacro_file(tmp_path, doubling + '<link name="${p40}"/>'))
    calls = '<xacro:macro name="m0"><link name="a"/></xacro:macro>'
    calls += "".join(f'<xacro:macro name="m{i + 1}">{f"<xacro:m{i}/>" * 2}</xacro:macro>' for i in range(40))
    with pytest.raises(UrdfError, match="without end"):
        expand_xacro(xacro_file(tmp_path, calls + "<xacro:m40/>"))


def test_an_argument_without_a_value_is_named_with_its_option(tmp_path, capsys):
    path = xacro_file(tmp_path, '<xacro:arg name="other" default="1"/><link name="$(arg side)_base"/>')
    with pytest.raises(UrdfError, match=r"the argument side has no value; allowed: --xacro-arg side:=VALUE, in Python"):
        expand_xacro(path)
    assert 'name="left_base"' in expand_xacro(path, {"side": "left"})
    with pytest.raises(SystemExit) as end:
        main(["lint", str(path)])
    assert end.value.code == 1
    assert "--xacro-arg side:=VALUE" in capsys.readouterr().out
