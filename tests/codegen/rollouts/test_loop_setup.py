"""Rollouts in other conditions than tracking: a free swing, saturation, stops, several references, delay, noise."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters
from lwr_dyn.codegen.rollouts.kernel import room_for_record
from lwr_dyn.codegen.rollouts.kernel_task import plan_of, task_of
from lwr_dyn.codegen.rollouts.law_forms import INVERSE_DYNAMICS, NoKernelFormError
from lwr_dyn.codegen.rollouts.loop_setup import (
    arm_of_run,
    kept_values,
    loop_setup,
    mass_matrices,
    parameter_shapes,
    run_parameters,
)
from lwr_dyn.codegen.rollouts.result import figures_of
from lwr_dyn.foundation import errors
from lwr_dyn.model.chain import first_links
from lwr_dyn.model.friction import Direction, JointFriction, symmetric
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Loop
from lwr_dyn.trajectory.references.joint_moves import point_to_point
from tests.codegen.rollouts.beside import first_joints
from tests.codegen.rollouts.test_rollouts import ARM, IST, OWN, perturbed
from tests.random_arms import random_arm

LAW = lwr_dyn.controller("inverse-dynamics", ARM, omega_n=50.0)
RUBBING = replace(ARM, friction=(symmetric(1.0, 0.5),) * 7)


def differences(done, i, plant=ARM, **options):
    """Metric -> largest difference between the kernel's and those of `simulate`."""
    found = figures_of(done.run(i), plant, **options)
    assert found.keys() == done.metrics.keys()
    return {name: float(np.abs(np.subtract(done.metrics[name][i], x)).max()) for name, x in found.items() if _known(x)}


def _known(value):
    return np.isfinite(value).all()


@pytest.mark.slow
def test_a_free_swing_is_followed_for_a_second():
    """An arm that swings freely is chaotic: nothing can be asked after 6 s."""
    rest = lwr_dyn.reference("hold", ARM, q=IST.sample(np.zeros(1)).q[0], duration=1.0)
    given = {"effort": np.zeros(2), "inertia": perturbed(2)}
    done = lwr_dyn.rollouts(ARM, LAW, rest, parameters=given, record=1, position_limits=False)
    assert done.flags == ("", "")
    assert (done.metrics["limit_margin"] < 0.0).any()  # beyond limits that are off
    run = done.run(1)
    assert np.abs(run.q[-1] - run.q[0]).max() > 1.0
    assert np.abs(done.q[1] - run.q).max() < 1e-9  # rounding that has grown: 5e-11 on one processor, 1e-12 on another


@pytest.mark.slow
def test_cut_torques_and_their_time_are_those_of_simulate():
    own = {"inertia": [OWN]}
    effort = 0.98 * lwr_dyn.rollouts(ARM, LAW, IST, parameters=own, duration=1.0).metrics["peak_torque"]
    given = own | {"effort": effort}
    done = lwr_dyn.rollouts(ARM, LAW, IST, parameters=given, duration=1.0, tolerance=1e-5)
    assert done.flags == ("",)
    assert done.metrics["saturated_s"].max() > 0.002
    found = differences(done, 0, arm_of_run(ARM, {"effort": effort[0]}), tolerance=1e-5)
    assert found.pop("saturated_s") < 1e-15
    assert max(found.values()) < 1e-9  # the moment of a cut hangs on rounding: 1.3e-10 on one processor
    free = lwr_dyn.rollouts(ARM, LAW, IST, parameters=given, duration=1.0, saturate=False)
    assert (free.metrics["peak_torque"] > effort).any()
    assert differences(free, 0, arm_of_run(ARM, {"effort": effort[0]}))["saturated_s"] < 1e-15
    assert free.metrics["saturated_s"].max() > 0.002


def test_a_run_that_meets_a_stop_is_that_of_simulate_and_the_others_stay_in_the_kernel():
    rest = lwr_dyn.reference("hold", ARM, q=[0.0, 1.9, 0.0, 0.5, 0.0, 0.5, 0.0], duration=0.3)
    given = {"effort": ARM.effort * [[1.0], [0.05]], "inertia": [OWN, OWN]}
    options = {"record": 10, "tolerance": 1e-3, "quantiles": (0.9,)}
    done = lwr_dyn.rollouts(ARM, LAW, rest, parameters=given, **options)
    assert done.flags == ("", "stop")
    assert repr(done).startswith("Rollouts(2 runs, flags: 1 stop, 1 of them by simulate, ")
    assert done.simulated.tolist() == [False, True]
    run = done.run(1)
    assert any(event.kind == "stop" for event in run.events)
    found = figures_of(run, arm_of_run(ARM, {"effort": given["effort"][1]}), 1e-3, (0.9,))
    assert all(np.array_equal(done.metrics[name][1], value) for name, value in found.items())
    assert np.array_equal(done.q[1], run.q[::10])
    left = lwr_dyn.rollouts(ARM, LAW, rest, parameters=given, hand_over=False, **options)
    assert left.flags == done.flags
    assert not left.simulated.any()
    assert all(np.isnan(values[1]).all() for values in left.metrics.values())
    assert all(np.array_equal(values[0], done.metrics[name][0]) for name, values in left.metrics.items())


def test_each_run_has_the_reference_that_it_names():
    moves = [
        lwr_dyn.reference("point-to-point", ARM, start=[0.1] * 7, end=[end] * 7, duration=0.5) for end in (0.3, -0.2)
    ]
    own = np.tile(OWN, (3, 1))
    both = lwr_dyn.rollouts(ARM, LAW, moves, parameters={"reference": [1, 0, 1], "inertia": own}, record=1)
    assert not both.simulated.any()
    for i, which in enumerate((1, 0, 1)):
        alone = lwr_dyn.rollouts(ARM, LAW, moves[which], parameters={"inertia": own[:1]}, record=1)
        assert np.array_equal(both.q[i], alone.q[0])
        assert max(differences(both, i).values()) < 1e-10


FOUR = replace(first_joints(4), friction=ARM.friction)
"""Its first joints, for loops of their own, which compile faster."""
PHYSICAL = replace(FOUR, chain=first_links(lwr_dyn.load("lwr4plus", reading="physical").chain, 4))
MOVE = point_to_point(FOUR, [[0.3, -1.2, 0.2, 0.9], [0.9, -0.7, -0.3, 1.5]], [1.0])


@pytest.mark.slow
def test_loads_armature_start_friction_and_substeps_are_those_of_simulate():
    start = MOVE.sample(np.zeros(1)).q[0]
    friction = np.tile([[3.0], [1.0], [2.0], [0.5], [0.1]], (2, 1, 4)) * [[[1.0]], [[0.0]]]
    given = {
        "payload": [0.0, 3.0], "payload_com": [[0.0, 0.0, 0.0], [0.02, -0.01, 0.1]], "armature": [0.2, 0.05],
        "q0": np.add(start, [[0.0], [0.01]]), "dq0": [0.0, 0.1], "model_payload": [0.0, 2.0], "friction": friction,
    }  # fmt: skip
    done = lwr_dyn.rollouts(
        FOUR, lwr_dyn.controller("inverse-dynamics", FOUR, omega_n=50.0), MOVE, parameters=given, friction="smooth",
        friction_width=0.05, substeps=3, duration=0.5, plant=PHYSICAL,
    )  # fmt: skip
    assert not done.simulated.any()
    for i in range(2):
        assert differences(done, i, FOUR)["tip_max"] < 1e-12
        assert max(differences(done, i, FOUR).values()) < 1e-9


@pytest.mark.slow
def test_an_arm_with_sliding_joints_moves_as_in_simulate():
    arm = random_arm(5, "RPR")
    law = lwr_dyn.controller("inverse-dynamics", arm, omega_n=20.0)
    move = lwr_dyn.reference("point-to-point", arm, start=[0.1] * 3, end=[0.3, 0.2, -0.2], duration=0.5)
    own = inertial_parameters(arm.chain).ravel()
    done = lwr_dyn.rollouts(arm, law, move, parameters={"inertia": own * [[1.0], [1.1]]}, record=1)
    assert done.flags == ("", "")
    assert np.abs(done.run(1).q - done.q[1]).max() < 1e-12
    assert max(differences(done, 1, arm).values()) < 1e-10


PLAN = {
    "substeps": 1, "varies_plant": False, "varies_model": False, "friction_width": None, "pole": None, "noise": "none",
    "most_delay": 0,
}  # fmt: skip
SILENT, NOISY = Encoder(1e-4, 0.0, 50.0), Encoder(1e-4, 1e-5, 50.0)
POLE = SILENT.velocity_filter(500.0).pole


@pytest.mark.parametrize(
    ("options", "given", "differs"),
    [
        ({}, ["Kp", "effort", "q0", "armature"], {}), ({}, ["inertia"], {"varies_plant": True}),
        ({}, ["payload"], {"varies_plant": True}), ({}, ["model_inertia"], {"varies_model": True}),
        ({}, ["model_payload"], {"varies_model": True}), ({"delay": 1}, [], {"most_delay": 8}),
        ({}, ["delay"], {"most_delay": 8}), ({"substeps": 3}, [], {"substeps": 3}),
        ({"friction": "smooth"}, [], {"friction_width": 0.07}), ({"encoder": SILENT}, [], {"pole": POLE}),
        ({"encoder": NOISY}, [], {"pole": POLE, "noise": "philox"}),
        ({"encoder": SILENT}, ["noise"], {"pole": POLE, "noise": "philox"}),
        ({}, ["resolution"], {"pole": Encoder().velocity_filter(500.0).pole}),
        ({}, ["noise"], {"pole": Encoder().velocity_filter(500.0).pole, "noise": "philox"}),
    ],
)  # fmt: skip
def test_a_plan_depends_on_which_parameters_are_given(options, given, differs):
    setup = loop_setup(RUBBING, LAW, IST, Loop(rate=500.0, duration=0.01, **{"friction": "none"} | options), 0.07)
    plan = plan_of(setup, INVERSE_DYNAMICS.of(LAW, RUBBING), dict.fromkeys(given))
    assert {name: getattr(plan, name) for name in PLAN} == PLAN | differs
    assert (plan.rate, plan.arm, plan.plant) == (500.0, RUBBING, RUBBING)


@pytest.mark.parametrize("saturate", [True, False])
def test_numbers_of_the_loop_and_of_its_runs_stand_in_their_slots(saturate):
    moves = [IST, lwr_dyn.reference("hold", ARM, q=np.full(7, 0.1), duration=0.01)]
    given = {
        "reference": np.array([1.0, 0.0, 1.0]), "effort": np.arange(21.0).reshape(3, 7), "Kp": np.ones((3, 7)),
        "delay": np.array([0.0, 2.0, 5.0]), "dq0": np.full((3, 7), 0.5), "payload": np.array([0.0, 1.0, 2.0]),
    }  # fmt: skip
    loop = Loop(rate=500.0, duration=0.01, delay=3, encoder=NOISY, saturate=saturate, seed=9, friction="none")
    setup = loop_setup(ARM, LAW, moves, loop)
    plan = plan_of(setup, INVERSE_DYNAMICS.of(LAW, ARM), given)
    kernel, limit = SimpleNamespace(slots=plan.slots), ARM.effort if saturate else np.full(7, 1e300)
    task = task_of(setup, plan, kernel, given, 3, 0.02, (0.5,), 4, 11)
    start = IST.sample(np.zeros(1))
    common = {
        "q": start.q[0], "dq": start.dq[0], "armature": ARM.armature, "effort": limit, "rating": ARM.effort,
        "lower": ARM.lower, "upper": ARM.upper, "tolerance": 4e-4, "last": 5.0, "delay": 3.0, "resolution": 1e-4,
        "noise": 1e-5, "gain Kp": LAW.Kp, "gain Kd": LAW.Kd, "margin": np.inf, "violation": np.inf, "saturated": 0.0,
    }  # fmt: skip
    for name, value in common.items():
        wanted = np.broadcast_to(value, plan.slots.widths[name])
        np.testing.assert_array_equal(task.common[plan.slots.places(name)], wanted, err_msg=name)
    runs = np.tile(task.common, (3, 1))
    for row, values in zip(runs, task.given, strict=True):
        row[task.places.astype(int)] = values
    q = [np.full(7, 0.1), start.q[0], np.full(7, 0.1)]
    of_run = {
        "q": q, "dq": given["dq0"], "gain Kp": given["Kp"], "delay": given["delay"], "rating": given["effort"],
        "effort": given["effort"] if saturate else np.full((3, 7), 1e300), "gain Kd": np.tile(LAW.Kd, (3, 1)),
        "plant": kept_values(ARM.chain, None, given["payload"], None),
    }  # fmt: skip
    for name, value in of_run.items():
        np.testing.assert_array_equal(runs[:, plan.slots.places(name)], np.reshape(value, (3, -1)), err_msg=name)
    assert (task.seed, task.first_run, task.stride, task.quantiles) == (9, 11, 4, (0.5,))
    assert task.which.tolist() == [1, 0, 1]
    assert task.reference.shape == (2, 6, 24)


class Mine(Encoder):
    def sensor(self, q0, dq0, samples, rate, seed):
        return lambda q, dq: (q, dq)


def test_the_shapes_of_a_runs_values():
    bodies = dict.fromkeys(("inertia", "model_inertia"), (20,))
    of_joints = dict.fromkeys(("armature", "effort", "q0", "dq0"), (2,)) | bodies
    single = dict.fromkeys(("payload", "model_payload", "delay", "resolution", "noise", "reference"), ())
    places = dict.fromkeys(("payload_com", "model_payload_com"), (3,))
    expected = of_joints | single | places | {"friction": (5, 2), "Kp": (2,)}
    assert parameter_shapes(2, {"Kp": (2,)}) == expected


def test_rows_may_be_flat_have_an_axis_of_links_or_stand_for_all_joints():
    shapes, rng = parameter_shapes(3, {"Kp": (3,)}), np.random.default_rng(0)
    bodies, friction, gains = rng.uniform(size=(4, 3, 10)), rng.uniform(size=(4, 5, 3)), rng.uniform(size=4)
    flat = {"inertia": bodies.reshape(4, 30), "friction": friction.reshape(4, 15), "Kp": gains, "payload": gains}
    axes = {"inertia": bodies, "friction": friction, "Kp": gains[:, None], "payload": gains[:, None]}
    wanted = {"inertia": flat["inertia"], "friction": friction, "Kp": np.tile(gains[:, None], 3), "payload": gains}
    for given in (flat, axes, wanted):
        count, found = run_parameters(given, None, shapes)
        assert (count, found.keys()) == (4, wanted.keys())
        for name, array in wanted.items():
            np.testing.assert_array_equal(found[name], array)
    for name in ("inertia", "payload_com"):
        with pytest.raises(errors.ShapeError, match=name):
            run_parameters({"payload": gains, name: gains[:, None]}, None, shapes)


def test_smooth_friction_is_looked_at_before_anything_is_computed():
    dip = replace(ARM, friction=(JointFriction(*[Direction(1.0, 0.5, 2.0, 0.1)] * 2),) * 7)
    for arm, width, words in (
        (dip, 0.1, "Stribeck"),
        (RUBBING, np.inf, "friction_width: inf; allowed: a speed above 0"),
    ):
        with pytest.raises(errors.OptionError, match=words):
            loop_setup(arm, LAW, IST, Loop(friction="smooth", duration=0.01), width)


def rows(**given):
    return {"runs": None, "parameters": given}


START = IST.sample(np.zeros(1)).q[0]
BAD = {
    errors.UnknownNameError: [
        (rows(inertias=[OWN]), "did you mean inertia"), (rows(Kpp=[1.0]), "known: inertia.*Kp, Kd"),
        ({"controller": "inverse-dynamic"}, "did you mean inverse-dynamics"),
    ],
    errors.ShapeError: [
        (rows(inertia=[OWN[:69]]), r"\(1, 70\)"), (rows(inertia=[3.0]), r"\(1, 70\)"),
        (rows(inertia=[OWN.reshape(7, 10).T]), r"\(1, 10, 7\)"), (rows(friction=np.zeros((1, 7, 5))), r"\(1, 5, 7\)"),
        (rows(payload=2.0), "a single number"), (rows(payload=np.full(3, np.nan)), "finite"),
        (rows(payload=[1.0, 2.0], Kp=[100.0]), "1 rows; allowed: 2 rows"), (rows(Kp=["a"]), "numbers"),
        ({"plant": lwr_dyn.load("kr30ha")}, r"shape \(101, 7\); allowed: \(101, 6\)"),
    ],
    errors.OptionError: [
        (rows(inertia=[OWN, -OWN]), "a mass of -.* kg in run 1, link 1; allowed: masses from 0 on"),
        (rows(friction=np.zeros((1, 5, 7))), "'smooth'"), (rows(payload=[]), "from 1 to"),
        (rows(payload=[0.0, -1.0]), "payload: -1 in run 1; allowed: numbers from 0 on"),
        (rows(payload_com=[[0.0, 0.0, 0.1]]), "without payload"), (rows(delay=[0.5]), "whole numbers"),
        (rows(delay=[0, 9]), "9 in run 1; allowed: whole numbers from 0 to 8"), (rows(reference=[1]), "from 0 to 0"),
        (rows(effort=[-1.0]), "from 0 on"), (rows(q0=[START, [9.0] * 7]), "q0 of run 1"), ({"runs": None}, "not given"),
        *(({"runs": x}, "from 1 to 10000000") for x in (0, 2.0, True)), ({"rate": 0.0}, "above 0"),
        ({"duration": 0.0}, "above 0"), ({"substeps": 0}, "from 1"), ({"delay": 9}, "from 0 to 8"),
        ({"friction": "stick"}, "none, smooth"), ({"quantiles": (1.0,)}, "between 0 and 1"),
        ({"friction": "smooth", "friction_width": 0.0}, "friction_width: 0.0; allowed: a speed above 0"),
        ({"quantiles": 0.95}, "a sequence"), *(({"tolerance": x}, "a length above 0") for x in (-1.0, 0.0, np.inf)),
        ({"record": -1}, "from 0"), ({"threads": 0}, "from 1"), *(({"seed": x}, "seed.*from 0") for x in (-1, 1.5)),
        *(({"first_run": x}, "from 0") for x in (-1, 2**53 + 1)), ({"seed": 2**64}, "below 2"),
        ({"encoder": Mine()}, "encoder: Mine, with a sensor of its own; allowed: an Encoder"),
        ({"reference": None}, "a Reference"), ({"reference": []}, "empty sequence"), ({"arm": "lwr4plus"}, "an arm"),
        ({"arm": RUBBING, "friction": "set-valued"}, "no true stick; allowed: friction 'smooth'"),
        ({"arm": RUBBING, "friction": "smooth", "substeps": 1}, "substeps from"),
    ],
    NoKernelFormError: [({"controller": lambda t, q, dq, q_ref, dq_ref, ddq_ref: -dq}, "no form")],
    (errors.MissingDataError, errors.NotPhysicalError): [({"plant": lwr_dyn.load("lwr4")}, "lwr4")],
}  # fmt: skip
BAD_ROWS = [(given, error, words) for error, cases in BAD.items() for given, words in cases]


@pytest.mark.parametrize(("given", "error", "words"), BAD_ROWS)
def test_what_cannot_be_is_refused(given, error, words):
    given = {"arm": ARM, "controller": LAW, "reference": IST, "runs": 1, "duration": 0.1} | given
    with pytest.raises(error, match=words):
        lwr_dyn.rollouts(given.pop("arm"), given.pop("controller"), given.pop("reference"), **given)


def test_a_record_that_memory_does_not_hold_is_refused():
    with pytest.raises(errors.OptionError, match="record: 1000000 runs of 1000000 samples, "):
        room_for_record(1_000_000, 1_000_000, 21)


def test_time_beyond_a_torque_limit_that_is_not_known_is_not_zero():
    arm = lwr_dyn.load("kr30ha")
    hold = lwr_dyn.reference("hold", arm, q=[0.0, -1.0, 1.0, 0.0, 0.3, 0.0], duration=0.01)
    law = lwr_dyn.controller("inverse-dynamics", arm)
    unknown = lwr_dyn.rollouts(arm, law, hold, runs=1)
    assert np.isnan(unknown.metrics["saturated_s"]).all()
    assert np.isnan(figures_of(unknown.run(0), arm)["saturated_s"]).all()
    known = lwr_dyn.rollouts(arm, law, hold, parameters={"effort": [[1e5] * 6]})
    assert (known.metrics["saturated_s"] == 0.0).all()


def test_friction_too_stiff_for_one_light_arm_is_refused():
    """The arm itself is slow enough: RK4 of 1 ms is stable below 2700 1/s."""
    table = np.zeros((5, 7))
    table[[0, 2]] = 0.02 * ARM.effort
    B = lwr_dyn.dynamics_of(ARM).mass_matrix(IST.sample(np.zeros(1)).q[0])
    own = np.linalg.eigvals(np.linalg.solve(B, np.diag(table[0]))).real.max()
    given = {"friction": [table, table], "armature": [ARM.armature, 0.5 * ARM.armature]}
    options = {"friction": "smooth", "friction_width": own / 2690.0, "substeps": 1, "duration": 0.01}
    with pytest.raises(errors.OptionError, match=r"run 1.*substeps"):
        lwr_dyn.rollouts(ARM, LAW, IST, parameters=given, **options)


@pytest.mark.parametrize("arm", [lwr_dyn.load("lwr4plus"), random_arm(5, "RPRP")])
def test_mass_matrices_are_those_of_each_runs_arm(arm):
    rng = np.random.default_rng(0)
    q = rng.normal(size=arm.n)
    given = {
        "inertia": (inertial_parameters(arm.chain) * rng.uniform(0.8, 1.2, (3, arm.n, 1))).reshape(3, -1),
        "payload": np.array([0.0, 1.0, 2.0]), "payload_com": rng.normal(size=(3, 3)),
        "armature": rng.uniform(0.0, 1.0, (3, arm.n)),
    }  # fmt: skip
    for i, found in enumerate(mass_matrices(arm.chain, q, given)):
        plant = arm_of_run(arm, {name: rows[i] for name, rows in given.items()})
        expected = lwr_dyn.dynamics_of(plant).mass_matrix(q)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-13 * np.abs(expected).max())
    np.testing.assert_allclose(mass_matrices(arm.chain, q, {})[0], lwr_dyn.dynamics_of(arm).mass_matrix(q), atol=1e-12)
