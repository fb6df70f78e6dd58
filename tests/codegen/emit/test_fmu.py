"""FMUs of plants and laws: beside `simulate` in a closed loop, and beside an adaptive integrator."""

import ctypes
import functools
import zipfile
from io import BytesIO
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lwr_dyn
from lwr_dyn.codegen.emit import fmu as module
from lwr_dyn.codegen.emit.fmu import controller_fmu, laws, plant_fmu
from lwr_dyn.foundation.errors import MissingDataError, MissingPackageError, OptionError, UnknownNameError
from lwr_dyn.model.friction import smooth_friction
from tests.agreement.test_foreign_arms import ARMS
from tests.codegen.emit.fmi_master import Instance

RATE, ROBOTS = 1000, ("lwr4plus", "wam7", "ur5")
LOAD = {"payload_mass": 2.0, "payload_com": [0.0, 0.01, 0.1]}


def loaded(robot):
    """An arm of ours, or a public URDF."""
    return ARMS[robot].load() if robot in ARMS else lwr_dyn.load(robot)


@functools.cache
def archive(robot, version, law=None):
    arm = loaded(robot)
    made = plant_fmu(arm, version) if law is None else controller_fmu(arm, law, version, RATE)
    return made.archive(binary=True)


@functools.cache
def task(robot):
    arm = lwr_dyn.load(robot)
    end = np.clip(np.linspace(0.3, -0.4, arm.n), arm.lower + 0.1, arm.upper - 0.1)
    return lwr_dyn.reference("point-to-point", arm, start=np.clip(0 * end, arm.lower, arm.upper), end=end, duration=0.2)


def instance(folder, robot, version, law=None):
    place = folder / f"{robot}_{version}_{law}"
    place.mkdir()
    return Instance(BytesIO(archive(robot, version, law)), place)


def loop(plant, law, motion, count, delay=0):
    """Positions (count, n) of a plant and a law stepped in turn, or in parallel, which delays by a sample."""
    h, rows, waiting = 1.0 / RATE, [], law.get("tau")
    for k in range(count):
        q, dq = plant.get("q"), plant.get("dq")
        rows.append(q)
        given = {"q": q, "dq": dq, "q_ref": motion.q[k], "dq_ref": motion.dq[k], "ddq_ref": motion.ddq[k]}
        for name, value in given.items():
            law.set(name, value)
        assert law.step(k * h, h) == 0
        plant.set("tau", waiting if delay else law.get("tau"))
        waiting = law.get("tau")
        assert plant.step(k * h, h) == 0
    return np.array(rows)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "law", "version", "delay"),
    [("lwr4plus", "inverse-dynamics", "3", 0), ("lwr4plus", "inverse-dynamics", "3", 1), ("wam7", "pid", "2", 0)],
)
def test_plant_and_law_are_the_loop_of_simulate(tmp_path, robot, law, version, delay):
    """Stepped in turn; in parallel, that with a delay of a sample."""
    arm, reference = lwr_dyn.load(robot), task(robot)
    friction = smooth_friction(arm.friction_models(), module.FRICTION_WIDTH) if arm.has_friction else "none"
    start = reference.sample(np.zeros(1)).q[0] + 0.002
    run, other = (
        lwr_dyn.simulate(
            arm, lwr_dyn.controller(law, arm), reference, rate=RATE, substeps=4, q0=start, friction=friction,
            payload=2.0, payload_com=LOAD["payload_com"], delay=k,
        )
        for k in (delay, 1 - delay)
    )  # fmt: skip
    plant, sampled = instance(tmp_path, robot, version), instance(tmp_path, robot, version, law)
    motion = reference.sample(run.t)
    plant.begin(q_start=start, step=0.25 / RATE, **LOAD)
    sampled.begin(q=start, q_ref=motion.q[0], dq_ref=motion.dq[0], ddq_ref=motion.ddq[0])
    q = loop(plant, sampled, motion, len(run.t), delay)
    assert np.abs(q - run.q).max() < 1e-12
    assert np.abs(q - other.q).max() > 1e-6


def swing(arm, start, tau, seconds=0.1):
    """(rates of a state, where a swing from rest ends), by the engine and an adaptive integrator."""
    n, engine = arm.n, lwr_dyn.dynamics_of(arm)

    def slope(_, x):
        return np.r_[x[n:], engine.forward_dynamics(x[:n], x[n:], tau)]

    ended = solve_ivp(slope, (0, seconds), np.r_[start, np.zeros(n)], "DOP853", rtol=1e-13, atol=1e-14)
    return slope, ended.y[:n, -1]


@pytest.mark.parametrize("version", ["2", "3"])
def test_derivatives_and_outputs(tmp_path, version):
    arm, plant = lwr_dyn.load("lwr4plus"), instance(tmp_path, "lwr4plus", version)
    start, tau = np.linspace(0.2, -0.5, 7), np.array([5.0, 300.0, 2, 1, 0, 0, 0])
    slope, exact = swing(arm, start, np.clip(tau, -arm.effort, arm.effort))
    plant.begin(q_start=start)
    plant.set("tau", tau)
    state = np.r_[start, np.linspace(-1, 1, 7)]
    assert np.abs(plant.derivatives(state) - slope(0.0, state)).max() < 1e-9
    assert np.abs(plant.get("tip").reshape(4, 4) - lwr_dyn.forward_kinematics(arm, start)).max() < 1e-12
    plant.call("Reset")
    plant.begin(q_start=start, step=1e-3)
    plant.set("tau", tau)
    assert plant.step(0.0, 0.1) == 0
    assert np.abs(plant.get("q") - exact).max() < 1e-8


@pytest.mark.parametrize("robot", ["lwr4plus", "ur5"])
def test_a_free_swing_converges_with_order_four(tmp_path, robot):
    arm, plant = loaded(robot), instance(tmp_path, robot, "2")
    start, errors = np.linspace(0.2, -0.5, arm.n), []
    _, exact = swing(arm, start, np.zeros(arm.n))
    for h in (0.01, 0.005, 0.0025):
        plant.call("Reset")
        plant.begin(q_start=start, step=h)
        assert plant.step(0.0, 0.1) == 0
        errors.append(np.abs(plant.get("q") - exact).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.abs(orders - 4.0).max() < 0.15, orders
    assert errors[-1] < 1e-8


def test_a_load_is_that_of_the_arm(tmp_path):
    plant, mass, com = instance(tmp_path, "lwr4plus", "3"), 2.0, [0.01, 0.02, 0.1]
    tensor = np.array([[0.02, 0.001, 0.002], [0.001, 0.03, 0.003], [0.002, 0.003, 0.025]])
    arm = lwr_dyn.load("lwr4plus", tool={"mass": mass, "com": com, "inertia": tensor.tolist()})
    plant.begin(payload_mass=mass, payload_com=com, payload_inertia=tensor[np.triu_indices(3)])
    state = np.random.default_rng(3).uniform(-1, 1, 14)
    expected = lwr_dyn.dynamics_of(arm).forward_dynamics(state[:7], state[7:], np.zeros(7))
    assert np.abs(plant.derivatives(state)[7:] - expected).max() < 1e-9


@pytest.mark.parametrize("version", ["2", "3"])
def test_states_are_kept_and_bad_calls_refused(tmp_path, version):
    plant = instance(tmp_path, "lwr4plus", version)
    plant.begin(q_start=np.full(7, 0.1))
    kept, word = ctypes.c_void_p(), {"2": "FMUstate", "3": "FMUState"}[version]
    assert plant.call(f"Get{word}", ctypes.byref(kept)) == 0
    before = plant.get("q")
    assert plant.step(0.0, 0.01) == 0
    after = plant.get("q")
    assert np.abs(after - before).max() > 0.0
    assert plant.call(f"Set{word}", kept) == 0
    assert np.array_equal(plant.get("q"), before)
    assert plant.step(0.0, 0.01) == 0
    assert np.array_equal(plant.get("q"), after)
    plant.call(f"Free{word}", ctypes.byref(kept))
    rows, count = (ctypes.c_double * 14)(), ctypes.c_size_t(14)
    for name, expected in (("Nominals", np.ones(14)), ("", np.r_[after, plant.get("dq")])):
        assert plant.call(f"Get{name + 'Of' * bool(name)}ContinuousStates", rows, count) == 0
        assert np.array_equal(rows, expected)
    assert plant.call("GetContinuousStates", rows, ctypes.c_size_t(13)) != 0
    plant.references["wrong"] = [(99_999, 1)]
    with pytest.raises(AssertionError):
        plant.get("wrong")
    assert plant.step(0.0, -1.0)
    plant.set("tau", np.full(7, np.nan))
    assert plant.step(0.0, 0.01)
    assert not plant.instantiated("another token")


@pytest.mark.parametrize("version", ["2", "3"])
def test_the_description_names_each_variable_its_unit_and_what_is_left_out(version):
    every_byte = archive("lwr4plus", version)
    assert version == "2" or plant_fmu(lwr_dyn.load("lwr4plus"), version).archive(binary=True) == every_byte
    with zipfile.ZipFile(BytesIO(every_byte)) as every:
        names, text = every.namelist(), every.read("modelDescription.xml")
        assert b"not in it: position stops" in every.read("documentation/index.html")
        assert all(b"Redistribution and use" in every.read(x) for x in names if x.startswith("sources/fmi"))
    tree = ElementTree.fromstring(text)
    for words in ("not in it: position stops and impacts", "reading physical"):
        assert words in tree.attrib["description"]
    variables = list(tree.find("ModelVariables"))
    inner = [x.find("Real") if version == "2" else x for x in variables]
    of = dict(enumerate(variables, 1)) if version == "2" else {int(x.attrib["valueReference"]): x for x in variables}
    states = {of[int(x.attrib["derivative"])].attrib["name"] for x in inner if "derivative" in x.attrib}
    scalars = {f"{x}[{i + 1}]" for x in ("q", "dq") for i in range(7)}
    assert states == (scalars if version == "2" else {"q", "dq"})
    units = {x.attrib["name"] for x in tree.find("UnitDefinitions")}
    assert {x.attrib["unit"] for x in inner if "unit" in x.attrib} == units


OTHER_LAWS = sorted({*laws()} - {"inverse-dynamics", "pid"})


@pytest.mark.parametrize(
    "law", ["pd-gravity", *(pytest.param(x, marks=pytest.mark.slow) for x in OTHER_LAWS if x != "pd-gravity")]
)
def test_every_law_can_be_written(law):
    made = controller_fmu(lwr_dyn.load("lwr4plus"), law, "2")
    assert zipfile.ZipFile(BytesIO(made.archive())).testzip() is None


@pytest.mark.parametrize(("robot", "version"), [pytest.param("wam7", "2", marks=pytest.mark.slow), ("lwr4plus", "3")])
def test_directional_derivatives_are_those_of_the_batch_and_of_differences(tmp_path, robot, version):
    arm, plant = lwr_dyn.load(robot), instance(tmp_path, robot, version)
    n, rng = arm.n, np.random.default_rng(8)
    q, dq, tau = rng.uniform(0.2, 0.6, (3, n))
    tau[1] = 2.0 * arm.effort[1]  # cut at its limit: it changes nothing there
    plant.begin(q_start=q, dq_start=dq, **({"friction_width": 0.5} if arm.has_friction else {}))
    plant.set("tau", tau)
    applied = np.clip(tau, -arm.effort, arm.effort)
    if arm.has_friction:
        applied = applied - smooth_friction(arm.friction_models(), 0.5)(dq)
    slopes = lwr_dyn.batch_dynamics(arm).forward_dynamics_derivatives(q, dq, applied)
    free = np.abs(tau) < arm.effort
    for known, matrix in (("q", slopes.by_q[0]), ("tau", slopes.by_tau[0] * free)):
        seed = rng.uniform(-1, 1, n)
        status, found = plant.directional("ddq", known, seed)
        assert status == 0
        assert np.abs(found - matrix @ seed).max() < 1e-9 * np.abs(matrix).max()
    h, seed = 1e-5, rng.uniform(-1, 1, n)
    ends = [plant.derivatives(np.r_[q, dq + side * h * seed])[n:] for side in (1.0, -1.0)]
    plant.derivatives(np.r_[q, dq])
    status, found = plant.directional("ddq", "dq", seed)
    assert np.abs(found - (ends[0] - ends[1]) / (2 * h)).max() < 1e-6 * np.abs(found).max()
    assert (plant.directional("der_q", "dq", seed)[1] == seed).all()
    pose = [lwr_dyn.forward_kinematics(arm, q + side * h * seed).ravel() for side in (1.0, -1.0)]
    assert np.abs(plant.directional("tip", "q", seed)[1] - (pose[0] - pose[1]) / (2 * h)).max() < 1e-8
    assert plant.directional("ddq", "gravity", np.ones(3))[0] != 0
    assert plant.directional("payload_mass", "q", seed)[0] != 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "version", "law"),
    [
        *((robot, version, None) for robot in ROBOTS for version in "23"),
        ("wam7", "2", "pid"), ("lwr4plus", "3", "inverse-dynamics"), ("ur5", "2", "pid"),
    ],
)  # fmt: skip
def test_fmpy_finds_no_fault_and_runs_it_as_we_do(tmp_path, robot, version, law):
    from fmpy import simulate_fmu
    from fmpy.validation import validate_fmu

    path, n, h, count = tmp_path / "x.fmu", loaded(robot).n, 1.0 / RATE, 50 if law is None else 10
    path.write_bytes(archive(robot, version, law))
    assert validate_fmu(str(path)) == []
    out, given = ("q", {"q_start": 0.2}) if law is None else ("tau", {"q": 0.2})
    (begin,) = given
    names = [f"{out}[{k + 1}]" for k in range(n)] if version == "2" else [out]
    start = {f"{begin}[{k + 1}]": 0.2 for k in range(n)} if version == "2" else {begin: [0.2] * n}
    run = simulate_fmu(
        path, stop_time=count * h, step_size=h, output_interval=h, fmi_type="CoSimulation", output=names,
        start_values=start,
    )  # fmt: skip
    ours = instance(tmp_path, robot, version, law)
    ours.begin(**{begin: np.full(n, 0.2)})
    assert [ours.step(k * h, h) for k in range(count)] == [0] * count
    theirs = np.hstack([np.ravel(run[name][-1]) for name in names])
    assert len(run) == count + 1
    assert np.abs(theirs - ours.get(out)).max() < 1e-12
    assert np.abs(theirs - (0.2 if law is None else 0.0)).max() > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("robot", ROBOTS)
def test_libcosim_runs_plant_and_law_in_parallel_as_we_do(tmp_path, robot):
    """The master of the Open Simulation Platform, on the FMI Library; its algorithm steps all FMUs at once."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    n, target, count = loaded(robot).n, np.linspace(0.2, -0.3, loaded(robot).n), 50
    execution = CosimExecution.from_step_size(1_000_000_000 // RATE)
    observer, places, values = CosimObserver.create_last_value(), {}, {}
    execution.add_observer(observer)
    for name, law in (("plant", None), ("law", "pid")):
        path = tmp_path / f"{name}.fmu"
        path.write_bytes(archive(robot, "2", law))
        places[name] = execution.add_local_slave(CosimLocalSlave(fmu_path=str(path), instance_name=name))
        values[name] = {x.name.decode(): x.reference for x in execution.slave_variables(places[name])}
    for k in range(n):
        execution.real_initial_value(places["law"], values["law"][f"q_ref[{k + 1}]"], float(target[k]))
        for x in ("q", "dq"):
            source, to = values["plant"][f"{x}[{k + 1}]"], values["law"][f"{x}[{k + 1}]"]
            execution.connect_real_variables(places["plant"], source, places["law"], to)
        source, to = values["law"][f"tau[{k + 1}]"], values["plant"][f"tau[{k + 1}]"]
        execution.connect_real_variables(places["law"], source, places["plant"], to)
    assert execution.simulate_until(count * 1_000_000_000 // RATE)
    theirs = observer.last_real_values(places["plant"], [values["plant"][f"q[{k + 1}]"] for k in range(n)])

    plant, law = instance(tmp_path, robot, "2"), instance(tmp_path, robot, "2", "pid")
    plant.begin()
    law.begin(q_ref=target)
    for k in range(count):
        for x in ("q", "dq"):
            law.set(x, plant.get(x))
        plant.set("tau", law.get("tau"))
        assert law.step(k / RATE, 1.0 / RATE) == 0
        assert plant.step(k / RATE, 1.0 / RATE) == 0
    assert np.abs(plant.get("q") - theirs).max() < 1e-12
    assert np.abs(plant.get("q")).max() > 1e-3


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda arm: controller_fmu(arm, "pd"), UnknownNameError, "no control law that can be written named 'pd'"),
        (lambda arm: controller_fmu(arm, "pid", rate=0.0), OptionError, r"--rate: 0\.0; allowed: a number above 0"),
        (lambda arm: plant_fmu(arm, "4"), OptionError, "--fmi: '4'; allowed: 2 or 3"),
        (lambda _: plant_fmu(lwr_dyn.load("lwr4")), MissingDataError, "lwr4"),
    ],
)
def test_bad_input_is_one_line(call, error, words):
    with pytest.raises(error, match=words):
        call(lwr_dyn.load("lwr4plus"))


def test_a_binary_needs_a_known_system_and_a_compiler_that_takes_the_sources(monkeypatch):
    made = module.Fmu("x", "3", {"sources/x.c": b"not C"}, ())
    assert zipfile.ZipFile(BytesIO(made.archive())).namelist() == ["sources/x.c"]
    with pytest.raises(OptionError, match="a compiler of C99"):
        made.archive(binary=True)
    for patched, name, value, error, words in (
        (module.platform, "system", "Plan9", OptionError, "--binary: Plan9"),
        (module.shutil, "which", None, MissingPackageError, "a C compiler"),
    ):
        with monkeypatch.context() as patch, pytest.raises(error, match=words):  # noqa: PT012
            patch.setattr(patched, name, lambda *_, value=value: value)
            made.archive(binary=True)
