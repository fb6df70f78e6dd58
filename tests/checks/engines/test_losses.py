"""Committed models weigh and move in other engines as in ours; `scripts/soak.py parity` does it with more states."""

import re
from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.checks.engines import losses
from lwr_dyn.checks.engines.child_process import Loaded
from lwr_dyn.checks.engines.engine import ENGINES
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from tests.checks.engines.committed import COUPLED, MODELS, Pair, committed_models, compared, pairs
from tests.optional import need

STATES = 5
PAIRS = {str(pair): pair for pair in pairs()}


@pytest.mark.parametrize("name", PAIRS)
def test_an_engine_reads_the_file_as_we_do(name):
    need(ENGINES[PAIRS[name].engine].facts["package"])
    assert compared(PAIRS[name], STATES)[1] == []


def test_every_committed_model_is_weighed():
    assert set(committed_models()) == {*MODELS.rglob("*.urdf"), *MODELS.rglob("*.xml")}
    coupled = {path for name in COUPLED for path in MODELS.glob(f"{name}/*.urdf")}
    assert {pair.path for pair in PAIRS.values() if pair.engine == "pinocchio"} == {*MODELS.rglob("*.urdf")} - coupled


ZEROS = re.compile(r'<inertial>\s*<origin[^>]*/>\s*<mass value="0.0"/>\s*<inertia[^>]*/>\s*</inertial>')
FAULTS = {
    "urdf: shapes of the flange weigh": (".urdf", lambda t: ZEROS.sub("", t), {"mass", "B", "g"}),
    "urdf: a rotated tensor": (".urdf", lambda t: t.replace('ixy="9.9e-07"', 'ixy="-9.9e-07"'), {"B"}),
    "xml: a rotor is lost": (".xml", lambda t: re.sub(' armature="[^"]+"', "", t, count=1), {"B", "torque"}),
    "xml: a link weighs more": (".xml", lambda t: t.replace('mass="2.7782"', 'mass="2.7783"', 1), {"mass"}),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_in_a_file_is_seen(tmp_path, name):
    ending, fault, seen = FAULTS[name]
    path = MODELS / "lwr4plus" / f"lwr4plus{ending}"
    broken = tmp_path / path.name
    broken.write_text(fault(path.read_text(encoding="utf-8")), encoding="utf-8")
    pair = Pair(broken, committed_models()[path], "mujoco")
    assert seen <= set(compared(pair, STATES)[1])
    moved = replace(pair, arm=replace(pair.arm, chain=replace(pair.arm.chain, links=pair.arm.chain.links[::-1])))
    assert "flange" in compared(replace(moved, path=path), STATES)[1]


def exactly(reference, links=("base", "upper", "lower", "tool"), rotors=True):
    """What an engine has that computes as we do, with or without rotors."""
    x, dynamics = reference.states, newton_euler_dynamics(reference.arm.chain)
    gravity = dynamics.gravity_vector(x.q)
    rotor = 0.0 if rotors else reference.arm.armature * x.ddq
    return Loaded(
        3.0, reference.flange(), reference.held(), links, dynamics.mass_matrix(x.q),
        dynamics.bias_torque(x.q, x.dq) - gravity, gravity, reference.torque() - rotor,
    )  # fmt: skip


@pytest.fixture(scope="module")
def reference(kept):
    return losses.reference_of(kept, None, {})


def test_an_engine_that_computes_as_we_do_agrees_and_one_part_in_a_billion_is_seen(reference):
    exact = exactly(reference)
    found = losses.agreement("mujoco", exact, reference)
    assert (found.engine, found.mass, found.beyond()) == ("mujoco", 3.0, [])
    assert set(found.absolute.values()) == set(found.relative.values()) == {0.0}
    fields = {"B": "mass_matrix", "C dq": "velocity_torque", "g": "gravity_torque", "torque": "torque"}
    assert list(found.relative) == list(fields)
    for name, field in fields.items():
        ours = getattr(exact, field)
        off = losses.agreement("pybullet", replace(exact, **{field: ours * (1.0 + 1e-9)}), reference)
        assert off.relative[name] == pytest.approx(1e-9, rel=1e-5)
        assert off.absolute[name] == pytest.approx(1e-9 * np.abs(ours).max(), rel=1e-5)
        assert off.beyond() == (["g"] if name == "g" else [])  # its others are allowed 1e-8 and 1e-4
        assert replace(off, engine="mujoco").beyond() == [name]
    moved = losses.agreement("mujoco", replace(exact, flange=exact.flange + 1e-9), reference)
    assert moved.beyond() == ["flange"]
    assert replace(moved, engine="pybullet").beyond() == []
    assert losses.agreement("mujoco", replace(exact, torque=np.zeros(0)), reference).relative == {}
    no_rotors = losses.agreement("mujoco", exact, reference, rotors=False)
    assert no_rotors.absolute["B"] == pytest.approx(0.1)  # 100^2 x 1e-5 kg m^2
    assert no_rotors.absolute["g"] == 0.0


def test_the_shares_of_rotor_and_friction_in_a_torque_are_those_put_in(reference):
    x, none = reference.states, exactly(reference, rotors=False).torque - reference.friction(reference.arm)
    parts = np.array([0.1, 0.0]) * x.ddq, np.array([0.7, 0.0]) * x.dq, np.array([0.4, 0.0]) * np.sign(x.dq)
    shares, rest = losses.shares_of(none + 0.5 * parts[0] + 0.25 * parts[1] - parts[2], reference)
    assert shares == pytest.approx({"rotor inertia": 0.5, "viscous friction": 0.25, "Coulomb friction": -1.0})
    assert rest < 1e-13
    assert losses.shares_of(none + 2.0 * np.eye(2)[1] * x.dq, reference)[1] > 0.1


def test_what_happened_to_a_feature_is_told_from_torques_and_records(reference):
    whole, x = exactly(reference), reference.states
    rotor = np.array([0.1, 0.0]) * x.ddq
    ours = whole.torque, whole.torque - rotor
    without = replace(whole, torque=ours[1])

    def of(feature, *loaded, expected=ours):
        return losses.feature_loss("mujoco", feature, loaded, expected, reference)

    turn, share = np.abs(rotor).max(), np.abs(rotor).max() / np.abs(whole.torque).max()
    half = replace(whole, mass=3.5), replace(whole, torque=whole.torque - 0.5 * rotor)
    bare, silent = replace(whole, held={}), replace(whole, torque=np.zeros(0))
    for found, verdict, detail in (
        (of("rotor inertia", whole, without), "kept", ""), (of("rotor inertia", whole, whole), "ignored", ""),
        (of("rotor inertia", *half), "misread", "+0.5 kg with it"),
        (of("rotor inertia", silent, silent), "no dynamics", ""),
        (of("viscous friction", whole, whole), "recorded, not in its torque", ""),
        (of("viscous friction", bare, bare), "ignored", ""),
        (of("effort limits", whole, whole, expected=(ours[0], ours[0])), "recorded", ""),
        (of("zero inertials", whole, replace(whole, mass=4.0)), "kept", f"without them {turn:.2g} N m: +1 kg without"),
        (of("position limits", silent, silent, expected=None), "recorded", ""),
    ):  # fmt: skip
        assert (found.verdict, found.detail) == (verdict, detail)
        assert found.is_loss == (verdict in ("ignored", "misread", "recorded, not in its torque"))
    lost = [(x.torque, x.relative) for x in (of("rotor inertia", whole, whole), of("rotor inertia", *half))]
    assert lost == [pytest.approx((turn, share)), pytest.approx((0.5 * turn, 0.5 * share))]
    for name, value, says in (("upper", 1.5, "upper of j1: 1.5 for 2"), ("lower", -1.0, "lower of j1: -1 for -2")):
        changed = replace(silent, held=whole.held | {name: np.array([value, np.inf])})
        wrong = of("position limits", changed, changed)
        assert (wrong.verdict, wrong.detail) == ("misread", says)
    twice = replace(silent, held=whole.held | {"effort": np.array([0.0, 0.0])})
    assert of("effort limits", twice, twice).detail == "effort of j1: 0 for 50 and 1 more"
    for end, verdict in ((np.inf, "recorded"), (0.0, "recorded"), (1e6, "recorded"), (3.14, "misread")):
        held = whole.held | {"upper": np.array([2.0, end]), "lower": np.array([-2.0, -end])}
        assert of("continuous joints", replace(silent, held=held), silent).verdict == verdict
    endless = replace(silent, held={"upper": np.full(2, np.inf), "lower": np.full(2, -np.inf)})
    assert of("position limits", endless, endless).verdict == "ignored"


def test_shapes_that_weigh_and_links_that_are_gone(reference):
    whole = exactly(reference)
    bare = replace(whole, mass=2.0, torque=0.9 * whole.torque)
    assert losses.shapes_loss("mujoco", whole, whole, reference).verdict == "kept"
    found = losses.shapes_loss("mujoco", whole, bare, reference)
    assert (found.verdict, found.detail, found.relative) == ("misread", "shapes weigh 1 kg", pytest.approx(0.1))
    assert found.torque == pytest.approx(0.1 * np.abs(whole.torque).max())
    assert losses.shapes_loss("mujoco", replace(whole, torque=np.zeros(0)), bare, reference).verdict == "no dynamics"
    assert losses.merged_loss("mujoco", whole, whole.links).verdict == "kept"
    for count, says in ((3, "a0, a1, a2"), (4, "a0, a1, a2 and 1 more"), (6, "a0, a1, a2 and 3 more")):
        merged = losses.merged_loss("mujoco", whole, ["base", *(f"a{k}" for k in range(count)), "a0"])
        assert (merged.verdict, merged.detail) == ("merged", f"{says}: no longer there by name")


def test_the_first_way_that_has_what_is_lost_restores_it(reference, kept, tmp_path):
    whole, without = exactly(reference), exactly(reference, rotors=False)
    links = whole.links
    ways = {engine: losses.candidates(engine, kept, reference, tmp_path / engine) for engine in ENGINES.names}
    srdf, written, mjcf = ".srdf by loadRotorParameters", "the .urdf that lwr-dyn urdf writes", ".xml (MJCF)"
    assert {engine: [way.label for way in found] for engine, found in ways.items()} == {
        "pinocchio": [srdf, written],
        "mujoco": ['compiler option fusestatic="false"', written, mjcf],
        "drake": [written, mjcf],
        "pybullet": ["changeDynamics(linearDamping=0, angularDamping=0)", written],
        "yourdfpy": [],
    }
    assert [way.job.options for way in ways["pybullet"]] == [{"still": True}] * 2
    assert ways["pinocchio"][0].job.options == {"rotors": str(tmp_path / "pinocchio" / "written.srdf")}
    assert ways["drake"][1].job.scope.tip == "flange"
    lost = losses.Loss("mujoco", "rotor inertia", "ignored", 0.1, 0.01)

    def by(loss, *loaded):
        return losses.restored_by(loss, list(zip(ways["mujoco"], loaded, strict=False)), reference, links)

    assert by(lost, without, "refused", whole) == mjcf
    assert by(lost, without, whole, whole) == written
    assert by(lost, without, without) == by(replace(lost, verdict="kept"), whole) == ""
    near = replace(whole, torque=without.torque + 1.0009 * (whole.torque - without.torque))
    assert by(lost, near) != ""
    far = replace(whole, torque=without.torque + 1.0011 * (whole.torque - without.torque))
    assert by(lost, far) == ""
    merged = losses.merged_loss("mujoco", replace(whole, links=links[:3]), links)
    assert by(merged, replace(whole, links=links[:3]), whole) == written
    limits = losses.Loss("mujoco", "velocity limits", "ignored")
    assert by(limits, replace(whole, held={}), whole) == written
    assert by(replace(limits, feature="drag of its own", detail="an option"), whole) == "an option"
    tensor = losses.Loss("mujoco", "inertial rpy", "misread", 0.1, 0.01)
    assert by(tensor, replace(whole, torque=whole.torque + 1e-3), whole) == written
    # what stands for a link without mass in our MJCF shows a little
    stand_in = replace(whole, torque=whole.torque * (1.0 + 5e-10))
    assert by(replace(tensor, feature="moments without mass"), stand_in, whole) == 'compiler option fusestatic="false"'
    assert by(tensor, stand_in, whole) == written
