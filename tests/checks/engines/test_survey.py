"""What engines lose of a small file with everything in it, and what restores it: found by loading, per engine."""

import numpy as np
import pytest

from lwr_dyn.checks.engines.engine import ENGINES, is_installed
from lwr_dyn.checks.engines.survey import survey
from tests.checks.engines.small_files import TWO
from tests.optional import need

pytestmark = pytest.mark.slow

VERDICTS = {
    "pinocchio": {
        "rotor inertia": "ignored",
        "viscous friction": "recorded, not in its torque",
        "Coulomb friction": "recorded, not in its torque",
        "effort limits": "recorded",
        "velocity limits": "recorded",
        "position limits": "recorded",
        "continuous joints": "recorded",
        "inertial rpy": "kept",
        "links without inertial": "kept",
        "shapes": "kept",
        "links behind fixed joints": "kept",
    },
    "mujoco": {
        "rotor inertia": "ignored",
        "viscous friction": "kept",
        "effort limits": "recorded",
        "velocity limits": "ignored",
        "position limits": "recorded",
        "continuous joints": "recorded",
        "inertial rpy": "kept",
        "links without inertial": "misread",
        "shapes": "misread",
        "links behind fixed joints": "merged",
    },
    "drake": {"rotor inertia": "kept", "viscous friction": "kept", "Coulomb friction": "ignored", "shapes": "kept"},
    "pybullet": {"rotor inertia": "ignored", "viscous friction": "kept", "links without inertial": "misread"},
    "yourdfpy": {"rotor inertia": "no dynamics", "effort limits": "recorded", "links behind fixed joints": "kept"},
}
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
def report(tmp_path_factory):
    path = tmp_path_factory.mktemp("two") / "two.urdf"
    path.write_text(TWO, encoding="utf-8")
    return survey(path, engines=[engine for engine in ENGINES.names if is_installed(engine)])


def rows(report, engine):
    need(ENGINES[engine].facts["package"])
    (found,) = [x for x in report.engines if x.engine == engine]
    assert found.note == ""
    return {loss.feature: loss for loss in found.losses}


@pytest.mark.parametrize("engine", VERDICTS)
def test_each_feature_has_its_verdict(report, engine):
    found = {name: row.verdict for name, row in rows(report, engine).items()}
    assert found | VERDICTS[engine] == found


@pytest.mark.parametrize(("engine", "feature"), RESTORED)
def test_what_restores_it(report, engine, feature):
    assert rows(report, engine)[feature].restored_by == RESTORED[engine, feature]


def test_the_torque_of_a_loss_is_that_of_the_feature(report):
    x, found = report.reference.states, rows(report, "pinocchio")
    rotor = 100.0**2 * 1e-5
    assert found["rotor inertia"].torque == pytest.approx(rotor * np.abs(x.ddq[:, 0]).max(), rel=1e-9)
    assert found["viscous friction"].torque == pytest.approx(0.7 * np.abs(x.dq[:, 0]).max(), rel=1e-9)
    assert found["Coulomb friction"].torque == pytest.approx(0.4, rel=1e-9)


def test_a_box_without_inertial_weighs_a_kilogram_in_mujoco(report):
    """Density 1000 kg/m^3 of 0.1 m cubed."""
    assert rows(report, "mujoco")["shapes"].detail == "shapes weigh 1 kg"


def test_the_poses_agree(report):
    for engine in report.engines:
        if engine.agreement is not None:
            assert engine.agreement.absolute["flange"] < (1e-6 if engine.engine == "pybullet" else 1e-12)
