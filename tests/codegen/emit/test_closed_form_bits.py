"""Inverse kinematics has the same bits in C by two compilers and in JavaScript by two engines."""

import pytest

from tests.codegen.emit.closed_form_digests import js_program, write_c
from tests.codegen.emit.digests import C_PRINT
from tests.codegen.emit.programs import output, program

pytestmark = pytest.mark.slow

ARMS, STATES = ("lwr4plus", "kr30ha", "ur10"), 1000
"""The WAM has the text of the LWR 4+; it and 500 states on a Cortex-M7: soak.py emitted_bits."""
BUILDS = {"gcc": ("-O2", "-std=c99"), "clang": ("-O2", "-std=c99", "-march=native")}
"""clang contracts products and sums of one statement where the processor can, if the file does not forbid it."""


@pytest.fixture(scope="module")
def node_lines(tmp_path_factory):
    """The digests of node, one line a function."""
    path = tmp_path_factory.mktemp("node") / "digests.js"
    path.write_text(js_program(ARMS, STATES) + '\nconsole.log(lines.join("\\n"));\n')
    return output([program("node"), str(path)]).splitlines()


@pytest.mark.parametrize("compiler", BUILDS)
def test_c_gives_the_bits_of_node(compiler, node_lines, tmp_path):
    sources = write_c(ARMS, tmp_path, STATES)
    (tmp_path / "print.c").write_text(C_PRINT)
    files = [*map(str, sources), "print.c", "-lm", "-o", "digests"]
    output([program(compiler), *BUILDS[compiler], *files], tmp_path)
    assert output([str(tmp_path / "digests")]).splitlines() == node_lines
    assert len(set(node_lines)) == 8


def test_chromium_gives_the_bits_of_node(browser, node_lines, tmp_path):
    page = tmp_path / "digests.html"
    page.write_text(f"<!doctype html><script>\n{js_program(ARMS, STATES)}\n</script>")
    browser.get(page.as_uri())
    assert browser.execute_script("return lines") == node_lines


def test_the_librarys_angles_have_other_bits(node_lines, tmp_path):
    """So a digest that agrees says something."""
    path = tmp_path / "libm.js"
    path.write_text(js_program(ARMS[:1], STATES, "libm") + '\nconsole.log(lines.join("\\n"));\n')
    lines = output([program("node"), str(path)]).splitlines()
    assert [line.split()[0] for line in lines] == [line.split()[0] for line in node_lines[:4]]
    assert not set(lines) & set(node_lines)
