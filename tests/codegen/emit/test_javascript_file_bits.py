"""C by two compilers, JavaScript in two engines and a Cortex-M7 give the same bits of every result."""

from functools import partial

import pytest

from lwr_dyn.codegen.emit.closed_form import NAME as IK
from lwr_dyn.codegen.emit.javascript_file import javascript_source
from tests.codegen.emit import closed_form_digests
from tests.codegen.emit.cortex import linked, run_lines
from tests.codegen.emit.digests import C_PRINT, JS_TOOLS, c_functions, c_main, js_program
from tests.codegen.emit.emitted_robots import ARMS, DYNAMICS, emitted_robot
from tests.codegen.emit.programs import output, program

pytestmark = pytest.mark.slow

STATES, POSES = 3000, 1000
FLAGS = ["-std=c99", "-O2", "-fno-tree-slp-vectorize"]
CLOSED_FORMS = ("lwr4plus", "kr30ha", "ur10")
"""The WAM has the text of the LWR 4+; it and 500 states on a Cortex-M7: soak.py emitted_bits."""


def dynamics_js(**options):
    return js_program([emitted_robot(name) for name in ARMS], STATES, **options)


def dynamics_c(folder):
    robots = [emitted_robot(name) for name in ARMS]
    texts = {robot.name: c_functions(robot) for robot in robots} | {"main": c_main(robots, STATES)}
    for name, text in texts.items():
        (folder / f"{name}.c").write_text(text)
    return [folder / f"{name}.c" for name in texts]


BRANCHES = ("", "_near", "_arm_angle", "_intervals")
PROGRAMS = {
    "dynamics": (dynamics_js, dynamics_c, FLAGS, [f"{arm}_{name}" for arm in ARMS for name in DYNAMICS]),
    "inverse kinematics": (
        partial(closed_form_digests.js_program, CLOSED_FORMS, POSES),
        lambda folder: closed_form_digests.write_c(CLOSED_FORMS, folder, POSES),
        ["-O2", "-std=c99", "-march=native"],
        [f"{arm}_{IK}{x}" for arm in CLOSED_FORMS for x in (BRANCHES if arm == "lwr4plus" else BRANCHES[:2])],
    ),
}
"""JavaScript, C, how clang builds it, what is shown. clang contracts products and sums of one statement where the
processor can, if the file does not forbid it."""


def node_lines(text, folder, shown='lines.join("\\n")'):
    """What a script shows in node."""
    (folder / "digests.js").write_text(f"{text}\nconsole.log({shown});\n")
    return output([program("node"), "digests.js"], folder).splitlines()


@pytest.fixture(scope="module", params=PROGRAMS)
def made(request, tmp_path_factory):
    """A program, and the digests of node, one line a function."""
    js, *others = PROGRAMS[request.param]
    return node_lines(js(), tmp_path_factory.mktemp("node")), js, *others


def test_each_function_has_a_digest_of_its_own(made):
    lines, _, _, _, names = made
    assert [line.split()[0] for line in lines] == names
    assert len({line.split()[1] for line in lines}) == len(lines)


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_c_gives_the_bits_of_node(compiler, made, tmp_path):
    lines, _, write_c, clang, _ = made
    (tmp_path / "print.c").write_text(C_PRINT)
    files = [*map(str, write_c(tmp_path)), "print.c", "-lm", "-o", "digests"]
    output([program(compiler), *(clang if compiler == "clang" else FLAGS), *files], tmp_path)
    assert output([str(tmp_path / "digests")]).splitlines() == lines


def test_chromium_gives_the_bits_of_node(browser, made, tmp_path):
    lines, js, *_ = made
    page = tmp_path / "digests.html"
    page.write_text(f"<!doctype html><script>\n{js(is_compact=True)}\n</script>")
    browser.get(page.as_uri())
    assert browser.execute_script("return lines") == lines


def test_a_cortex_m7_gives_the_bits_of_node(tmp_path):
    """One arm, as compiling takes seconds; all arms in the soak."""
    program("qemu-system-arm")
    robots, main = [emitted_robot(ARMS[0])], tmp_path / "main.c"
    main.write_text(c_main(robots, STATES))
    (tmp_path / "arm.c").write_text(c_functions(robots[0]))
    shown = run_lines(linked([tmp_path / "arm.c", main], tmp_path / "cortex.elf", "-ffp-contract=off"))
    assert shown == node_lines(js_program(robots, STATES), tmp_path)


def test_a_law_with_memory_and_friction_have_the_same_bits(tmp_path):
    """Exponentials of the friction's smooth form among them."""
    robot = emitted_robot("wam7", ("friction_torque", "smooth_friction_torque", "step_pid"))
    (tmp_path / "laws.c").write_text("\n".join([c_functions(robot), C_PRINT, c_main([robot], STATES)]))
    output([program("gcc"), *FLAGS, "laws.c", "-o", "laws", "-lm"], tmp_path)
    assert output([str(tmp_path / "laws")]).splitlines() == node_lines(js_program([robot], STATES), tmp_path)


def test_the_librarys_sines_and_angles_have_other_bits(tmp_path):
    """So a digest that agrees says something."""
    robot = emitted_robot(ARMS[0])
    text = javascript_source(robot.functions, robot.name, sincos="libm")
    text = "\n".join([JS_TOOLS, text, f"digests({robot.name}, 100);"])
    assert node_lines(text, tmp_path, "lines[0]") != node_lines(js_program([robot], 100), tmp_path, "lines[0]")
    own, libm = (
        node_lines(closed_form_digests.js_program(CLOSED_FORMS[:1], POSES, kind), tmp_path) for kind in ("own", "libm")
    )
    assert [line.split()[0] for line in libm] == [line.split()[0] for line in own]
    assert not set(libm) & set(own)
