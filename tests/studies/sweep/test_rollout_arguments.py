"""Values of a study become the plants, gains and references that they say; a run with them is that of `simulate`."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import FRICTION, inertial_parameters
from lwr_dyn.codegen.rollouts.law_forms import law_form
from lwr_dyn.codegen.rollouts.rollouts import rollouts
from lwr_dyn.codegen.rollouts.step import MOST_DELAY
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.chain import Body, with_bodies, with_payload
from lwr_dyn.model.friction import smooth_friction, symmetric
from lwr_dyn.studies.sweep.read_study import study_of_text
from lwr_dyn.studies.sweep.rollout_arguments import (
    _largest_inertias,
    _references,
    controller_of_run,
    plant_parameters,
    rollout_arguments,
    rows_of,
)
from lwr_dyn.studies.sweep.sampling import VariedParameter
from lwr_dyn.studies.sweep.sweep_study import (
    SweepStudy,
    arm_of_study,
    controller_of_study,
    references_of_study,
    task_choices,
)
from lwr_dyn.studies.sweep.vocabulary import METRICS, PATHS

HEAD = """
robot = "lwr4plus"
reading = "physical"
controllers = ["inverse-dynamics", "robust", "pid"]
[task]
name = "hold"
from-deg = [0, 30, 0, -60, 0, 30, 0]
duration = 0.05
[sampling]
runs = 8
"""
BODIES = {
    "arm.mass": "low = 0.8\nhigh = 1.2",
    "arm.inertia.3": "low = 0.5\nhigh = 2",
    "arm.com": "low = -0.01\nhigh = 0.01",
}


def study_of(tmp_path, parameters, head=HEAD):
    text = head + "".join(f'[[parameter]]\npath = "{path}"\n{rest}\n' for path, rest in parameters.items())
    return study_of_text(text, tmp_path / "s.toml")


def arguments(study, text="inverse-dynamics"):
    values = study.values(0, study.runs)
    return values, rollout_arguments(study, text, values)


def plant(arm, mass, shift, third):
    """An arm with other bodies, written out."""
    bodies = []
    for i, body in enumerate(arm.chain.bodies):
        factor = third if i == 2 else 1.0
        bodies.append(Body(mass[i] * body.mass, body.com + shift[3 * i : 3 * i + 3], factor * body.inertia_com))
    return with_bodies(arm.chain, bodies)


def test_masses_centres_and_tensors_are_those_of_arms_written_out(tmp_path):
    study = study_of(tmp_path, BODIES)
    arm, (values, given) = arm_of_study(study), arguments(study)
    assert list(given["parameters"]) == ["inertia"]
    for i, row in enumerate(given["parameters"]["inertia"]):
        chain = plant(arm, values["arm.mass"][i], values["arm.com"][i], values["arm.inertia.3"][i])
        np.testing.assert_allclose(row.reshape(7, 10), inertial_parameters(chain), rtol=1e-13, atol=1e-15)


def test_paths_for_all_for_one_and_for_an_axis_fill_their_numbers():
    values = {
        "arm.com.all": np.array([[1.0, 2.0, 3.0]]), "arm.mass.2": np.array([5.0]), "arm.mass.7": np.array([6.0]),
        "payload.com.z": np.array([0.1]), "limits.torque": np.arange(7.0)[None],
    }  # fmt: skip
    np.testing.assert_array_equal(rows_of(values, "arm.com", (7, 3), 0.0)[0], [[1, 2, 3]] * 7)
    np.testing.assert_array_equal(rows_of(values, "arm.mass", (7,), 1.0)[0], [1, 5, 1, 1, 1, 1, 6])
    np.testing.assert_array_equal(rows_of(values, "payload.com", (3,), 0.0)[0], [0, 0, 0.1])
    np.testing.assert_array_equal(rows_of(values, "limits.torque", (7,), 1.0)[0], np.arange(7))
    np.testing.assert_array_equal(rows_of({"arm.com.4.y": np.array([9.0])}, "arm.com", (7, 3), 0.0)[0, 3], [0, 9, 0])
    assert rows_of(values, "arm.inertia", (7,), 1.0) is None


def test_friction_limits_rotors_sensors_and_delay(tmp_path):
    study = study_of(
        tmp_path,
        {
            "friction.coulomb.all": "low = 0\nhigh = 0.05", "friction.viscous.2": "low = 0\nhigh = 1",
            "limits.torque.all": "values = [0.5, 1]", "arm.armature": "low = 0.9\nhigh = 1.1",
            "sensor.noise": "low = 0\nhigh = 1e-5", "sensor.resolution": "value = 1e-4",
            "loop.delay": "values = [0, 3]",
        },
        "assumed_friction = 0.01\n" + HEAD + "[loop]\nfriction_width = 0.02\ncutoff_hz = 50\n",
    )  # fmt: skip
    arm, (values, given) = arm_of_study(study), arguments(study)
    rows = given["parameters"]
    for side in ("positive", "negative"):
        coulomb, viscous = (rows["friction"][:, FRICTION.index(f"{side}_{name}")] for name in ("coulomb", "viscous"))
        np.testing.assert_allclose(coulomb, values["friction.coulomb.all"][:, None] * arm.effort)
        np.testing.assert_allclose(viscous, values["friction.viscous.2"][:, None] * (np.arange(7) == 1))
    np.testing.assert_allclose(rows["effort"], values["limits.torque.all"][:, None] * arm.effort)
    np.testing.assert_allclose(rows["armature"], values["arm.armature"] * arm.armature)
    np.testing.assert_array_equal(rows["noise"], values["sensor.noise"])
    np.testing.assert_array_equal(rows["resolution"], 1e-4)
    np.testing.assert_array_equal(rows["delay"], values["loop.delay"])
    assert (given["encoder"].cutoff_hz, given["friction"], given["friction_width"]) == (50.0, "smooth", 0.02)
    assert (given["seed"], given["rate"], given["tolerance"], given["quantiles"]) == (0, 1000.0, None, ())


def test_one_row_of_friction_leaves_the_other_to_the_arm(tmp_path):
    study = study_of(tmp_path, {"friction.viscous.all": "low = 0\nhigh = 1"}, "assumed_friction = 0.01\n" + HEAD)
    table = arguments(study)[1]["parameters"]["friction"]
    np.testing.assert_allclose(table[:, 0], 0.01 * arm_of_study(study).effort[None].repeat(8, axis=0))


def test_a_known_payload_is_in_the_models_that_have_none_of_their_own(tmp_path):
    paths = {"payload.mass": "low = 1\nhigh = 7", "payload.known": "values = [0, 0.5]", "payload.com.z": "value = 0.1"}
    study = study_of(tmp_path, paths)
    values, given = arguments(study)
    rows = given["parameters"]
    np.testing.assert_array_equal(rows["payload"], values["payload.mass"])
    np.testing.assert_array_equal(rows["payload_com"], [[0, 0, 0.1]] * 8)
    np.testing.assert_array_equal(rows["model_payload"], values["payload.known"] * values["payload.mass"])
    np.testing.assert_array_equal(rows["model_payload_com"], rows["payload_com"])
    assert set(arguments(study, "robust")[1]["parameters"]) == {"payload", "payload_com"}


def test_a_reading_of_the_plant_brings_its_bodies(tmp_path):
    study = study_of(tmp_path, {"reading": 'values = ["printed", "physical"]', "arm.mass.all": "value = 2"})
    values, given = arguments(study)
    for name, row in zip(values["reading"], given["parameters"]["inertia"], strict=True):
        arm = lwr_dyn.load("lwr4plus", reading=str(name))
        bodies = [replace(body, mass=2 * body.mass) for body in arm.chain.bodies]
        np.testing.assert_allclose(row.reshape(7, 10), inertial_parameters(with_bodies(arm.chain, bodies)), atol=1e-14)


SLOW = [pytest.param(text, marks=pytest.mark.slow) for text in ("pid", "robust")]


@pytest.mark.parametrize("text", ["inverse-dynamics", *SLOW])
def test_gains_are_those_of_controllers_made_one_by_one(text, tmp_path):
    study = study_of(tmp_path, {"controller.omega_n": "values = [20, 60]"})
    values, given = arguments(study, text)
    arm = arm_of_study(study)
    fixed = {"inertia": _largest_inertias(arm)} if text == "pid" else {}  # its search once is enough
    for i in (int(np.flatnonzero(values["controller.omega_n"] == omega_n)[0]) for omega_n in (20.0, 60.0)):
        options = {"omega_n": values["controller.omega_n"][i], **fixed}
        alone = law_form(controller_of_study(study, text, options), arm).values()
        assert set(given["parameters"]) == set(alone)
        for name, value in alone.items():
            np.testing.assert_array_equal(given["parameters"][name][i], value)


def test_an_option_that_is_no_gain_is_refused(tmp_path):
    head = HEAD.replace('["inverse-dynamics", "robust", "pid"]', '["pid"]')
    study = study_of(tmp_path, {"controller.omega_n": "low = 1\nhigh = 20"}, head)
    with pytest.raises(OptionError, match=r"omega_n: -1\.0; allowed: a number above 0"):
        rollout_arguments(study, "pid", {"controller.omega_n": np.array([10.0, -1.0])})


def test_tasks_are_numbered_in_the_order_of_the_references(tmp_path):
    head = HEAD.replace('"hold"', '"point-to-point"').replace("duration = 0.05", "to-deg = [0, 40, 0, -60, 0, 30, 0]")
    study = study_of(tmp_path, {"task.duration": "values = [0.5, 0.25, 1]"}, head)
    values, given = arguments(study)
    chosen = given["parameters"]["reference"].astype(int)
    durations = [references_of_study(study)[k].duration for k in chosen]
    np.testing.assert_array_equal(durations, values["task.duration"])


def test_tasks_of_two_options_are_numbered_with_the_last_fastest():
    options = {"task.a": (5.0, 6.0, 7.0), "task.b": (1.0, 2.0)}
    parameters = tuple(VariedParameter(path, "choice", (path,), values=x) for path, x in options.items())
    study = SweepStudy("s", "lwr4plus", "", ("pid",), "hold", parameters=parameters)
    values = {"task.a": np.array([5.0, 6.0, 7.0, 7.0]), "task.b": np.array([2.0, 1.0, 1.0, 2.0])}
    chosen = _references(study, values)
    assert chosen.tolist() == [1, 2, 4, 5]
    choices = task_choices(study)
    assert [choices[int(k)] for k in chosen] == [
        {"a": a, "b": b} for a, b in zip(values["task.a"], values["task.b"], strict=True)
    ]  # fmt: skip


def test_an_unknown_torque_limit_is_a_large_one_and_nothing_of_the_plant_varies_with_the_law_alone():
    study = SweepStudy("s", "kr30ha", "", ("pid",), "hold", loop={"friction": "none"})
    found = plant_parameters(study, {"reading": np.array(["kuka", "kuka"])})
    assert (set(found), found["effort"].tolist()) == ({"inertia", "armature", "effort"}, [[1e9] * 6] * 2)
    assert plant_parameters(study, {}) == {}


def test_the_longest_delay_is_that_of_the_kernel():
    assert PATHS["loop.delay"].most == MOST_DELAY


@pytest.mark.slow
def test_a_run_of_a_study_is_that_of_simulate_with_the_same_plant(tmp_path):
    paths = BODIES | {
        "payload.mass": "low = 1\nhigh = 7", "payload.known": "value = 0.5", "friction.coulomb": "low = 0\nhigh = 0.01",
        "loop.delay": "values = [1, 2]", "controller.omega_n": "values = [20, 30]",
    }  # fmt: skip
    head = HEAD.replace('"hold"', '"point-to-point"').replace("duration = 0.05", "to-deg = [0, 40, 0, -60, 0, 30, 0]")
    head = head.replace(
        "[sampling]", "duration = 0.25\n[metrics]\nquantiles = [0.95]\n[loop]\nfriction_width = 0.02\n[sampling]"
    )
    study = study_of(tmp_path, paths, head)
    values, given = arguments(study)
    arm, (reference,) = arm_of_study(study), references_of_study(study)
    rolls = rollouts(arm, controller_of_study(study, "inverse-dynamics"), reference, **given)
    assert set(rolls.metrics) == {*METRICS, "tip_q95"}
    assert all((rolls.metrics[name].ndim == 2) is row.per_joint for name, row in METRICS.items())
    i = 5
    chain = plant(arm, values["arm.mass"][i], values["arm.com"][i], values["arm.inertia.3"][i])
    models = [
        symmetric(share * limit, 0.0) for share, limit in zip(values["friction.coulomb"][i], arm.effort, strict=True)
    ]
    known = arm.with_chain(with_payload(arm.chain, 0.5 * values["payload.mass"][i]))
    run = lwr_dyn.simulate(
        arm, lwr_dyn.controller("inverse-dynamics", known, omega_n=values["controller.omega_n"][i]), reference,
        plant=arm.with_chain(with_payload(chain, values["payload.mass"][i])), delay=int(values["loop.delay"][i]),
        friction=smooth_friction(models, 0.02),
    )  # fmt: skip
    tip = lwr_dyn.forward_kinematics(arm, run.q)[:, :3, 3] - lwr_dyn.forward_kinematics(arm, run.q_ref)[:, :3, 3]
    assert rolls.metrics["tip_max"][i] == pytest.approx(np.linalg.norm(tip, axis=1).max(), abs=1e-12)
    np.testing.assert_allclose(rolls.metrics["peak_torque"][i], np.abs(run.tau_applied).max(axis=0), rtol=1e-10)


def test_a_controller_in_a_file_gets_its_options_and_its_payload(tmp_path):
    (tmp_path / "mine.py").write_text(
        "def make(arm, dynamics, gain=1.0):\n"
        "    def controller(t, q, dq, q_ref, dq_ref, ddq_ref):\n"
        "        return gain * dynamics.gravity_vector(q)\n"
        "    return controller\n",
        encoding="utf-8",
    )
    head = HEAD.replace('"inverse-dynamics", "robust", "pid"', '"mine.py"')
    paths = {
        "controller.gain": "low = 0\nhigh = 2", "payload.mass": "low = 0\nhigh = 7", "payload.known": "values = [0, 1]",
    }  # fmt: skip
    for more in ({}, {"payload.com.x": "low = 0.1\nhigh = 0.2"}):
        study = study_of(tmp_path, paths | more, head)
        values, given = arguments(study, "mine.py")
        assert set(given["parameters"]) == {"payload", *(["payload_com"] if more else [])}
        arm, q = arm_of_study(study), np.full(7, 0.3)
        for i in (0, 5):
            com = [values["payload.com.x"][i] if more else 0.0, 0.0, 0.0]
            chain = with_payload(arm.chain, values["payload.known"][i] * values["payload.mass"][i], com)
            expected = values["controller.gain"][i] * lwr_dyn.dynamics_of(arm.with_chain(chain)).gravity_vector(q)
            torque = controller_of_run(study, "mine.py", values, i)(0.0, q, q, q, q, q)
            np.testing.assert_allclose(torque, expected, rtol=1e-12)
