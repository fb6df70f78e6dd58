"""The texts as Python: loops written out, choices, floors, and the bits of C for whole closed forms."""

import math

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.emit.closed_form import NAME
from lwr_dyn.codegen.emit.emission import emitted_arm
from lwr_dyn.kinematics.closed_forms.python_text import python_text
from lwr_dyn.kinematics.closed_forms.runners import python_names, whole_numbers
from lwr_dyn.kinematics.closed_forms.text_parser import parsed
from lwr_dyn.kinematics.closed_forms.texts import closed_form_text, used_functions, with_own_angles
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.six_joints.exact_arms import six_joint_form
from tests.codegen.emit.shared_library import SharedLibrary


def made(text, **names):
    exec(python_text(parsed(text, {})), names)
    return names["f"]


def test_a_short_loop_is_written_out_with_a_number_set_once_and_a_long_one_stays():
    loop = "void f(double *a)\n{\n    for (int i = 0; i < COUNT; i++) {\n        a[2 * i + 1] = LIST[i];\n    }\n}\n"
    text = python_text(parsed(loop, {"COUNT": 3}))
    assert "a[5] = LIST_2" in text
    assert "for" not in text
    assert "for i in range(0, 999, 1):" in python_text(parsed(loop, {"COUNT": 999}))
    loop = "for (int i = 1; i < 4; i++) {\n t = t * x + A[i];\n}"
    text = f"double f(double x)\n{{\n double t = A[0];\n {loop}\n t = t + t;\n return t;\n}}\n"
    written = python_text(parsed(text, {}))
    assert written.count("t = ") == 2
    assert made(text, A_0=1.0, A_1=2.0, A_2=3.0, A_3=4.0)(0.5) == 2.0 * (((1.0 * 0.5 + 2.0) * 0.5 + 3.0) * 0.5 + 4.0)


@pytest.mark.parametrize("x", [-2.0, -0.5, -0.0, 0.5, 7.0, math.nan])
def test_floor_choice_and_not(x):
    f = made("double f(double x)\n{\n    return !(x > 0.0) ? floor(x) : x > 1.0 && x < 9.0 ? -x : fabs(x);\n}\n")
    wanted = math.nan if x != x else math.floor(x) if x <= 0.0 else -x if x > 1.0 else x
    assert math.isnan(f(x)) if x != x else f(x) == wanted
    assert x != 0.0 or math.copysign(1.0, f(x)) == -1.0
    kept = made(
        "double f(double from)\n{\n    const double is = from + 1.0;\n    return is;\n}\n"
    )  # Python's own names
    assert kept(2.0) == 3.0


def test_known_zeros_and_ones_are_left_out():
    """Of arrays alone: what the text itself says stays."""
    text = "double f(double x, double y)\n{\n    return x * A[0] + y * A[1] + x * A[2] + 0.0 * y;\n}\n"
    written = python_text(parsed(text, {}), {"A_0": 1.0, "A_1": 0.0, "A_2": -1.0})
    assert "return (x - x) + (0.0 * y)" in written
    choice = "double f(double x)\n{\n    if (A[0] > 0.0) {\n        return x;\n    }\n    return -x;\n}\n"
    assert "if" not in python_text(parsed(choice, {}), {"A_0": 1.0})
    assert "return -x" in python_text(parsed(choice, {}), {"A_0": 0.0})
    one = "double f(double x)\n{\n    return COUNT == 2 ? x : -x;\n}\n"
    assert [f"return {'-' * (k != 2)}x" in python_text(parsed(one, {"COUNT": k})) for k in (2, 3)] == [True, True]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["kr30ha", "ur10"])
def test_the_bits_of_c(name, tmp_path):
    arm = lwr_dyn.load(name)
    library, form = SharedLibrary(emitted_arm(arm, [NAME]), tmp_path), six_joint_form(arm)
    q = np.random.default_rng(8).uniform(-3.0, 3.0, (200, 6))
    q[::7, 4], q[1::7, 2] = 0.0, 0.0
    T = np.ascontiguousarray(flange_pose(arm.chain, q))
    T[::10, :3, 3] *= 1.7
    names = python_names(form.numbers)
    text = used_functions(with_own_angles(closed_form_text(*form.texts)), (NAME,))
    exec(python_text(parsed(text, dict(whole_numbers(form.numbers)))), names)
    for pose in T:
        ours, theirs = [0.0] * 48, np.zeros((8, 6))
        assert names[NAME](pose.ravel().tolist(), ours) == library.call(NAME, pose, theirs)
        assert np.array(ours).tobytes() == theirs.tobytes() or np.isnan(theirs).any()
        assert np.array_equal(np.array(ours).reshape(8, 6), theirs, equal_nan=True)
