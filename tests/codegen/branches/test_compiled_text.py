"""A closed form compiled: cold in an empty cache, warm from it, once for all arms of a kind."""

import os
import subprocess
import sys

import pytest

import lwr_dyn
from lwr_dyn.codegen.branches import compiled_text
from lwr_dyn.codegen.kernels import kernel
from lwr_dyn.kinematics.closed_forms.arm_numbers import numbers_of_solutions
from lwr_dyn.kinematics.six_joints.exact_arms import six_joint_form


def given(name):
    arm = lwr_dyn.load(name)
    form = six_joint_form(arm)
    return (*form.texts, "solutions", "solutions_six_joints"), {
        **form.numbers,
        **numbers_of_solutions(arm, form.texts[-1] == "three_parallel"),
    }


def test_arms_of_a_kind_share_their_code_and_other_kinds_do_not(monkeypatch, tmp_path):
    monkeypatch.setenv("LWR_DYN_CACHE", str(tmp_path))
    monkeypatch.setattr(kernel, "_codes", {})
    first = compiled_text.kept_machine_code(*given("ur10"))
    assert compiled_text.kept_machine_code(*given("ur5e")) is first
    (kept,) = tmp_path.glob("branches-*.kernel")
    monkeypatch.setattr(kernel, "_codes", {})
    monkeypatch.setattr(compiled_text, "machine_code", None)  # nothing is compiled again
    assert compiled_text.kept_machine_code(*given("ur10")) is not first
    kept.write_bytes(kept.read_bytes()[:-1])
    monkeypatch.setattr(kernel, "_codes", {})
    with pytest.raises(TypeError):
        compiled_text.kept_machine_code(*given("ur10"))


@pytest.mark.slow
def test_cold_and_warm_start(tmp_path):
    """In processor time, the packages imported before: at most 1 s cold; from the cache a fraction of it."""
    script = (
        "import time, lwr_dyn, llvmlite.binding\nimport lwr_dyn.kinematics.six_joints.exact_arms\n"
        "import lwr_dyn.codegen.branches.compiled_text\n"
        "arm = lwr_dyn.load('ur10')\nT = lwr_dyn.forward_kinematics(arm, [0.1, -1.0, 1.2, 0.3, 0.4, 0.5])\n"
        "start = time.process_time()\nassert len(lwr_dyn.inverse_kinematics(arm, T).solutions) > 100\n"
        "print(time.process_time() - start)\n"
    )
    given = {**os.environ, "LWR_DYN_CACHE": str(tmp_path)}
    cold, warm = (
        float(
            subprocess.run([sys.executable, "-c", script], env=given, capture_output=True, text=True, check=True).stdout
        )
        for _ in range(2)
    )
    assert cold < 1.0
    assert warm < cold / 4.0
