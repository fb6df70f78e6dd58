"""Committed models weigh and move in other engines as in ours; `scripts/soak.py parity` does it with more states."""

import re

import numpy as np
import pytest

from tests.parity.comparison import MODELS, committed_models, pairs, parity
from tests.parity.engine import ENGINES

STATES = 5
PAIRS = {f"{path.name}-{engine.name}": (path, arm, engine) for path, arm, engine in pairs()}


@pytest.mark.parametrize("pair", PAIRS)
def test_an_engine_reads_the_file_as_we_do(pair):
    path, arm, engine = PAIRS[pair]
    if not engine.installed():
        pytest.skip(f"{engine.name} is not installed: pip install '.[parity]'")
    assert parity(path, arm, engine, STATES).beyond() == {}


def test_every_committed_model_is_weighed():
    assert set(committed_models()) == {*MODELS.rglob("*.urdf"), *MODELS.rglob("*.xml")}
    assert {path for path, _, engine in PAIRS.values() if engine.name == "pinocchio"} == set(MODELS.rglob("*.urdf"))


ZEROS = re.compile(r'<inertial>\s*<origin[^>]*/>\s*<mass value="0.0"/>\s*<inertia[^>]*/>\s*</inertial>')
FAULTS = {
    "urdf: shapes of the flange weigh": (".urdf", lambda t: ZEROS.sub("", t), {"mass", "B", "g"}),
    "urdf: a rotated tensor": (".urdf", lambda t: t.replace('ixy="9.9e-07"', 'ixy="-9.9e-07"'), {"B"}),
    "xml: a rotor is lost": (".xml", lambda t: t.replace('armature="0.00160325"', "", 1), {"B"}),
    "xml: a link weighs more": (".xml", lambda t: t.replace('mass="2.7782"', 'mass="2.7783"', 1), {"mass"}),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_in_a_file_is_seen(tmp_path, name):
    ending, fault, seen = FAULTS[name]
    path = MODELS / "lwr4plus" / f"lwr4plus{ending}"
    broken = tmp_path / path.name
    broken.write_text(fault(path.read_text(encoding="utf-8")), encoding="utf-8")
    assert seen <= set(parity(broken, committed_models()[path], ENGINES["mujoco"], STATES).beyond())


def test_drake_finds_a_motor_for_each_joint():
    pytest.importorskip("pydrake", reason="drake is not installed: pip install '.[parity]'")
    for path, arm, engine in pairs():
        if engine.name == "drake":
            assert engine.load(path, np.array(arm.chain.gravity)).actuators == arm.n
