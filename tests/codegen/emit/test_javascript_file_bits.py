"""C by two compilers, JavaScript in two engines and a Cortex-M7 give the same bits of every result."""

import pytest

from lwr_dyn.codegen.emit.javascript_file import javascript_source
from tests.codegen.emit.cortex import linked, run_lines
from tests.codegen.emit.digests import C_PRINT, JS_TOOLS, c_functions, c_main, js_program
from tests.codegen.emit.emitted_robots import ARMS, DYNAMICS, emitted_robot
from tests.codegen.emit.programs import output, program

pytestmark = pytest.mark.slow

STATES = 3000
FLAGS = ["-std=c99", "-O2", "-fno-tree-slp-vectorize"]


@pytest.fixture(scope="module")
def robots():
    return [emitted_robot(name) for name in ARMS]


@pytest.fixture(scope="module")
def node_lines(robots, tmp_path_factory):
    """The digests of node, one line a function."""
    path = tmp_path_factory.mktemp("node") / "digests.js"
    path.write_text(js_program(robots, STATES) + '\nconsole.log(lines.join("\\n"));\n')
    return output([program("node"), str(path)]).splitlines()


@pytest.fixture(scope="module")
def sources(robots, tmp_path_factory):
    """C files: the arms', the program and what prints."""
    folder = tmp_path_factory.mktemp("c")
    texts = {robot.name: c_functions(robot) for robot in robots}
    texts |= {"main": c_main(robots, STATES), "print": C_PRINT}
    for name, text in texts.items():
        (folder / f"{name}.c").write_text(text)
    return folder


def test_each_function_has_a_digest_of_its_own(node_lines):
    assert [line.split()[0] for line in node_lines] == [f"{arm}_{name}" for arm in ARMS for name in DYNAMICS]
    assert len({line.split()[1] for line in node_lines}) == len(node_lines)


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_c_gives_the_bits_of_node(compiler, sources, node_lines):
    found = program(compiler)
    out = sources / compiler
    output([found, *FLAGS, *(str(sources / f"{name}.c") for name in (*ARMS, "main", "print")), "-o", str(out), "-lm"])
    assert output([str(out)]).splitlines() == node_lines


def test_chromium_gives_the_bits_of_node(browser, robots, node_lines, tmp_path):
    page = tmp_path / "digests.html"
    page.write_text(f"<!doctype html><script>\n{js_program(robots, STATES, is_compact=True)}\n</script>")
    browser.get(page.as_uri())
    assert browser.execute_script("return lines") == node_lines


def test_a_cortex_m7_gives_the_bits_of_node(sources, node_lines, tmp_path):
    """One arm, as compiling takes seconds; all arms in the soak."""
    assert cortex_m7_lines(sources, ARMS[:1], tmp_path) == [line for line in node_lines if ARMS[0] in line]


def cortex_m7_lines(sources, arms, folder):
    """What a Cortex-M7 prints for some arms."""
    program("qemu-system-arm")
    main = folder / "cortex_main.c"
    main.write_text(c_main([emitted_robot(name) for name in arms], STATES))
    files = [*(sources / f"{name}.c" for name in arms), main]
    return run_lines(linked(files, folder / "cortex.elf", "-ffp-contract=off"))


def test_a_law_with_memory_and_friction_have_the_same_bits(tmp_path):
    """Exponentials of the friction's smooth form among them."""
    robot = emitted_robot("wam7", ("friction_torque", "smooth_friction_torque", "step_pid"))
    c, js, made = tmp_path / "laws.c", tmp_path / "laws.js", tmp_path / "laws"
    c.write_text("\n".join([c_functions(robot), C_PRINT, c_main([robot], STATES)]))
    js.write_text(js_program([robot], STATES) + '\nconsole.log(lines.join("\\n"));\n')
    output([program("gcc"), *FLAGS, str(c), "-o", str(made), "-lm"])
    assert output([str(made)]) == output([program("node"), str(js)])


def test_the_librarys_sines_have_other_bits(node_lines, tmp_path):
    """So a digest that agrees says something."""
    robot = emitted_robot(ARMS[0])
    path = tmp_path / "libm.js"
    text = javascript_source(robot.functions, robot.name, sincos="libm")
    path.write_text("\n".join([JS_TOOLS, text, f"digests({robot.name}, 100);", "console.log(lines[0]);"]))
    own = tmp_path / "own.js"
    own.write_text(js_program([robot], 100) + "\nconsole.log(lines[0]);")
    assert output([program("node"), str(path)]) != output([program("node"), str(own)])
