"""What engines lose of a small file with everything in it, and what restores it: found by loading, per engine."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.arms.urdf.parse import parse_xml
from lwr_dyn.arms.urdf.reader import read_urdf
from lwr_dyn.checks.engines import survey as survey_module
from lwr_dyn.checks.engines.child_process import Job, Loaded
from lwr_dyn.checks.engines.engine import ENGINES, is_installed, tolerance
from lwr_dyn.checks.engines.losses import FileReference, Loss, Way
from lwr_dyn.checks.engines.survey import (
    agreement_table,
    document,
    kept_lines,
    loss_table,
    markdown,
    matrix,
    notes,
    survey,
)
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from tests.json_schemas import faults
from tests.optional import need

LIMITS = dict.fromkeys(("effort limits", "velocity limits", "position limits", "continuous joints"), "recorded")
KEPT = dict.fromkeys(("inertial rpy", "links without inertial", "shapes", "links behind fixed joints"), "kept")
FRICTION = dict.fromkeys(("viscous friction", "Coulomb friction"), "recorded, not in its torque")
VERDICTS = {
    "pinocchio": {"rotor inertia": "ignored", **FRICTION, **LIMITS, **KEPT},
    "mujoco": {
        **LIMITS, "rotor inertia": "ignored", "viscous friction": "kept", "velocity limits": "ignored",
        "inertial rpy": "kept", "links without inertial": "misread", "shapes": "misread",
        "links behind fixed joints": "merged",
    },
    "drake": {"rotor inertia": "kept", "viscous friction": "kept", "Coulomb friction": "ignored", "shapes": "kept"},
    "pybullet": {"rotor inertia": "ignored", "viscous friction": "kept", "links without inertial": "misread"},
    "yourdfpy": {"rotor inertia": "no dynamics", "effort limits": "recorded", "links behind fixed joints": "kept"},
}  # fmt: skip
RESTORED = {
    ("pinocchio", "rotor inertia"): ".srdf by loadRotorParameters",
    ("mujoco", "rotor inertia"): ".xml (MJCF)",
    ("mujoco", "links without inertial"): "the .urdf that lwr-dyn urdf writes",
    ("mujoco", "shapes"): "the .urdf that lwr-dyn urdf writes",
    ("mujoco", "links behind fixed joints"): 'compiler option fusestatic="false"',
    ("pybullet", "links without inertial"): "the .urdf that lwr-dyn urdf writes",
    ("pybullet", "drag of its own"): "changeDynamics(linearDamping=0, angularDamping=0)",
}


@pytest.fixture(scope="module")
def report(kept):
    return survey(kept, engines=[engine for engine in ENGINES.names if is_installed(engine)])


def rows(report, engine):
    need(ENGINES[engine].facts["package"])
    (found,) = [x for x in report.engines if x.engine == engine]
    assert found.note == ""
    return {loss.feature: loss for loss in found.losses}


@pytest.mark.slow
@pytest.mark.parametrize("engine", VERDICTS)
def test_each_feature_has_its_verdict_and_what_restores_it(report, engine):
    found = rows(report, engine)
    verdicts = {name: row.verdict for name, row in found.items()}
    assert verdicts | VERDICTS[engine] == verdicts
    restored = {key: found[key[1]].restored_by for key in RESTORED if key[0] == engine}
    assert restored == {key: way for key, way in RESTORED.items() if key[0] == engine}
    (agreement,) = [x.agreement for x in report.engines if x.engine == engine]
    assert agreement.absolute["flange"] < (1e-6 if engine == "pybullet" else 1e-12)


@pytest.mark.slow
def test_the_torque_of_a_loss_is_that_of_the_feature(report):
    """A box of 0.1 m without inertial weighs a kilogram in MuJoCo: its density is 1000 kg/m^3."""
    x, found = report.reference.states, rows(report, "pinocchio")
    torques = [found[name].torque for name in ("rotor inertia", "viscous friction", "Coulomb friction")]
    expected = (100.0**2 * 1e-5 * np.abs(x.ddq[:, 0]).max(), 0.7 * np.abs(x.dq[:, 0]).max(), 0.4)
    assert torques == pytest.approx(expected, rel=1e-9)
    assert rows(report, "mujoco")["shapes"].detail == "shapes weigh 1 kg"


def without_rotors(engine, jobs, states, seconds):
    """In this process: what an engine has that computes as we do but knows rotors only from a sidecar."""
    out = []
    for job in jobs:
        arm = read_urdf(job.path, tip=None if job.path.name.startswith("written") else job.scope.tip)
        one, dynamics = FileReference(arm, job.scope, states), newton_euler_dynamics(arm.chain)
        links = tuple(x.get("name") for x in parse_xml(job.path.read_bytes(), "x").findall("link"))
        rotor = 0.0 if "rotors" in job.options else arm.armature * states.ddq
        gravity = dynamics.gravity_vector(states.q)
        out.append(
            Loaded(sum(body.mass for body in arm.chain.bodies), one.flange(), one.held(), links,
                   dynamics.mass_matrix(states.q), dynamics.bias_torque(states.q, states.dq) - gravity, gravity,
                   one.torque() - rotor)
        )  # fmt: skip
    return out


@pytest.fixture(scope="module")
def imitated(kept):
    """The survey of the small file by an engine that loses the rotors alone, and of one that is not installed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(survey_module, "load_all", without_rotors)
        patch.setattr(survey_module, "is_installed", lambda engine: engine == "pinocchio")
        return survey(kept, engines=["pinocchio", "drake"])


def test_an_engine_that_loses_the_rotors_alone_is_found_out(imitated):
    ours, drake = imitated.engines
    assert (drake.agreement, drake.losses, drake.note) == (None, (), "not installed: pip install drake")
    assert (ours.note, ours.agreement.mass) == ("", 3.0)
    lost = [x for x in ours.losses if x.is_loss]
    rotor = 0.1 * np.abs(imitated.reference.states.ddq[:, 0]).max()
    scale = np.abs(imitated.reference.torque()).max()
    assert [(x.feature, x.verdict, x.restored_by) for x in lost] == [
        ("rotor inertia", "ignored", ".srdf by loadRotorParameters")
    ]
    assert (lost[0].torque, lost[0].relative) == (pytest.approx(rotor), pytest.approx(rotor / scale))
    assert ours.agreement.absolute["torque"] == pytest.approx(rotor)
    assert {x for x, value in ours.agreement.relative.items() if value > 1e-12} == {"torque"}
    assert kept_lines(imitated) == [
        "pinocchio: kept viscous friction, Coulomb friction, inertial rpy, links without inertial, shapes, "
        "links behind fixed joints; recorded effort limits, velocity limits, position limits, continuous joints"
    ]
    assert notes(imitated) == ["drake: not installed: pip install drake"]
    assert notes(replace(imitated, unwritten="a thing")) == [*notes(imitated), "all formats: a thing"]


@pytest.mark.parametrize(("off", "lost"), [(1.0, []), (1.0 + 1e-9, ["drag of its own"]), (-2.0, ["drag of its own"])])
def test_a_drag_is_what_is_gone_with_it_turned_off(imitated, two, off, lost):
    """Of two ways that turn it off, the first that loads; a difference within the tolerance is none."""
    allowed = tolerance("pybullet", "torque")
    still, bare = (Loaded(1.0, np.eye(4)[None], {}, (), torque=np.array([[x, 1.0]])) for x in (0.0, off * allowed))
    ways = [Way(name, Job(two, imitated.reference.scope, options)) for name, options in
            (("a", {}), ("b", {"still": True}), ("c", {"still": True}))]  # fmt: skip
    found = survey_module._drag("pybullet", bare, list(zip(ways, (still, "no", still), strict=True)))
    assert [(x.feature, x.detail) for x in found] == [(name, "c") for name in lost]
    assert all((x.torque, x.relative) == (abs(off) * allowed,) * 2 for x in found)


def test_what_was_found_is_said_in_tables_and_for_programs(imitated):
    ours = imitated.engines[0]
    size, share = ours.losses[0].torque, ours.losses[0].relative
    lines = agreement_table(imitated).text().splitlines()
    assert lines[0] == "two.urdf: largest difference from ours over 20 random states, as each engine loads it"
    head = "engine mass [kg] B [relative] C dq [relative] g [relative] torque [relative] torque [N m] flange [m]"
    assert lines[1].split() == head.split()
    assert lines[3].split() == f"pinocchio 3 0.0e+00 0.0e+00 0.0e+00 {share:.1e} {size:.2g} 0.0e+00".split()
    assert lines[4:] == ["torque: B ddq + C dq + g with rotors and friction, as the engine's own motion needs it"]
    assert "verdict torque [N m] share" in " ".join(loss_table(imitated).text().splitlines()[1].split())
    (row,) = loss_table(imitated).record()
    assert list(row.values()) == [
        "pinocchio", "rotor inertia", "ignored", size, share, ".srdf by loadRotorParameters", ""
    ]  # fmt: skip
    nothing = replace(ours, losses=(replace(ours.losses[0], restored_by=""),))
    assert loss_table(replace(imitated, engines=(nothing,))).record()[0]["restored_by"] == "nothing that was tried"
    merged = replace(ours, engine="b", losses=(Loss("b", "shapes", "merged", 0.0, 0.0), Loss("b", "x", "no dynamics")))
    both = replace(imitated, engines=(nothing, merged))
    assert kept_lines(both)[1] == "b: "
    table = matrix([both, replace(imitated, file="b.urdf")])
    assert markdown(table).splitlines() == [
        "| file | feature | pinocchio | b | drake |", "| --- | --- | --- | --- | --- |",
        f"| two.urdf | rotor inertia | ignored, {size:.2g} N m | - | - |", "| two.urdf | shapes | - | merged | - |",
        "| two.urdf | x | - | no dynamics | - |",
        f"| b.urdf | rotor inertia | ignored, {size:.2g} N m; .srdf by loadRotorParameters | - | - |",
        *(f"| b.urdf | {x.feature} | {x.verdict} | - | - |" for x in ours.losses[1:]),
    ]  # fmt: skip
    found = document([imitated])
    assert faults("parity", {"caveats": [], **found.record()}) == []
    (model,) = found.record()["models"]
    assert (model["file"], model["unwritten"], len(model["engines"])) == ("two.urdf", "", 2)
    assert model["engines"][1] == {"engine": "drake", "note": imitated.engines[1].note, "features": []}
    first = model["engines"][0]
    assert (first["mass"], first["absolute"], first["relative"]) == (
        3.0, ours.agreement.absolute, ours.agreement.relative
    )  # fmt: skip
    assert [x["feature"] for x in first["features"]] == [x.feature for x in ours.losses]
    text = found.text()
    assert text.index("largest difference") < text.index("What is lost") < text.index("pinocchio: kept")
    assert "largest difference" not in document([replace(imitated, engines=imitated.engines[1:])]).text()
