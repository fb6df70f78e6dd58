"""Committed models weigh and move in other engines as in ours; `scripts/soak.py parity` does it with more states."""

import re
from dataclasses import replace

import pytest

from lwr_dyn.checks.engines.engine import ENGINES
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
