"""From a data file to an arm: conversions worked out by hand, rotors, motor maps, gains and friction; sources."""

from dataclasses import astuple

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.assembly import STANDARD_GRAVITY, arm_from_paper, dh_rows, require_plain_dh
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.foundation.errors import OptionError, PaperError
from lwr_dyn.model.chain import link_frames
from lwr_dyn.model.friction import Direction, JointFriction, symmetric
from lwr_dyn.model.spatial import steiner

GOOD = template("own.toml", "own", "RP", "standard")
PRODUCTS = "[[0.01, 0.002, 0], [0.002, 0.01, 0], [0, 0, 0.004]]"
ROW = "[[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.004]]"


def assembled(*changes):
    text = GOOD
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return arm_from_paper(parse_paper(text, "own.toml"))


def tensor(arm, link=0):
    return arm.chain.links[link].body.inertia_com


def test_dh_rows_are_in_si_and_products_of_the_integral_sign_are_negated():
    first, second = dh_rows(parse_paper(GOOD, "own.toml"))
    assert (first.alpha, first.d, second.alpha) == (np.pi / 2, 0.3, 0.0)
    frame = next(iter(link_frames(assembled().chain, np.zeros(2))))
    np.testing.assert_allclose(frame[:3, 3], [0.0, 0.0, 0.3], atol=1e-15)
    integral = 'products = "tensor"', 'products = "integral"'
    plain, negated = assembled((ROW, PRODUCTS)), assembled((ROW, PRODUCTS), integral)
    assert (tensor(plain)[0, 1], tensor(negated)[0, 1]) == (0.002, -0.002)
    np.testing.assert_array_equal(tensor(plain).diagonal(), tensor(negated).diagonal())


@pytest.mark.parametrize(("zero", "unit", "off"), [(-90, "deg", 0.0), (-np.pi / 2, "rad", 1e-15)])
def test_limits_move_by_the_printed_zero_without_rounding_where_units_are_the_same(zero, unit, off):
    column = f'zero = {{ values = [{zero!r}, 0], unit = ["{unit}", "m"], where = "p. 1", kind = "assumed" }}\n'
    arm = assembled(("lower = {", column + "lower = {"), ("[-170, 0]", "[210, 0]"), ("[170, 0.5]", "[300, 0.5]"))
    assert [arm.limits[0].lower, arm.limits[0].upper] == pytest.approx(np.radians([120.0, 210.0]), rel=0, abs=off)
    assert [s.cell for s in arm.sources["joint_1.lower"]] == ["limits.lower.values[0]", "limits.zero.values[0]"]


def test_a_tensor_is_brought_to_the_centre_of_mass_what_is_left_out_is_unknown_and_gravity_the_standard_one():
    gravity = next(line for line in GOOD.splitlines() if line.startswith("gravity ="))
    effort = next(line for line in GOOD.splitlines() if line.startswith("effort ="))
    arm = assembled((gravity, ""), (effort, ""))
    assert tuple(arm.chain.gravity) == STANDARD_GRAVITY
    assert [limit.effort for limit in arm.limits] == [None, None]
    assert arm.limits[0].velocity == pytest.approx(np.radians(120.0))
    assert arm.sources["joint_1.effort"] == ()
    arm = assembled(('about = "com"', 'about = "origin"'))
    moved = tensor(assembled()) - steiner(2.0, np.array([0.0, 0.0, -0.05]))
    np.testing.assert_allclose(tensor(arm), moved, rtol=1e-14)
    cells = [source.cell for source in arm.sources["link_1.inertia"]]
    assert cells == ["inertial.inertia.values[0]", "inertial.mass.values[0]", "inertial.com.values[0]"]


def column(name, values, unit):
    units = "[" + ", ".join(f'"{u}"' for u in unit) + "]" if isinstance(unit, tuple) else f'"{unit}"'
    return f'{name} = {{ values = {values}, unit = {units}, where = "page 1", kind = "assumed" }}\n'


FORCE, DAMPING, SPEED = ("N m", "N"), ("N m s/rad", "N s/m"), ("rad/s", "m/s")
DIRECTED = "[friction]\n" + "".join(
    column(f"{side}_{name}", *row)
    for side, name, *row in (
        ("positive", "coulomb", [1.0, 2.0], FORCE), ("positive", "viscous", [0.1, -0.2], DAMPING),
        ("negative", "coulomb", [3.0, 4.0], FORCE), ("negative", "viscous", [0.3, 0.4], DAMPING),
    )
)  # fmt: skip
MAP = "[transmission]\n" + column("ratio", [10, 20], "1") + column("stage", [1, 2], "1")
PAIR = column("signs", [[1, -1], [1, 1]], "1")
GAINS = "[gains]\n" + column("kp", [5, 6], ("N m/rad", "N/m")) + column("kd", [1, 2], DAMPING)

SPRINGS = "[elasticity]\n" + column("stiffness", [5, 6], ("N m/rad", "N/m")) + column("damping", [0.5, 0], DAMPING)


def loaded(tmp_path, more):
    path = tmp_path / "own.toml"
    path.write_text(GOOD.replace("[joints]", more + "[joints]", 1), encoding="utf-8")
    return lwr_dyn.load(path)


def test_friction_per_direction_with_all_its_columns(tmp_path):
    more = (
        column("positive_static", [1.5, 2.0], FORCE)
        + column("positive_stribeck_velocity", [0.1, 0.01], SPEED)
        + column("offset", [0.0, -0.5], FORCE)
        + column("covered", [0.4, 0.2], SPEED)
    )
    arm = loaded(tmp_path, DIRECTED + more)
    assert arm.friction == (
        JointFriction(Direction(1.0, 0.1, 1.5, 0.1), Direction(3.0, 0.3), 0.0, 0.4),
        JointFriction(Direction(2.0, -0.2, 2.0, 0.01), Direction(4.0, 0.4), -0.5, 0.2),
    )
    assert [s.cell for s in arm.sources["joint_2.friction.offset"]] == ["friction.offset.values[1]"]


def test_one_pair_both_ways_stays_with_the_limits_and_in_the_urdf(tmp_path):
    arm = loaded(tmp_path, "[friction]\n" + column("coulomb", [1.0, 2.0], FORCE))
    assert (arm.friction, arm.friction_models()) == ((), (symmetric(1.0, 0.0), symmetric(2.0, 0.0)))
    assert '<dynamics friction="1.0"/>' in lwr_dyn.urdf_text(arm)


def test_gains_reflected_rotors_and_a_motor_map_of_signs_times_ratio_over_stage(tmp_path):
    assert loaded(tmp_path, "").transmission is None
    arm = loaded(tmp_path, MAP + PAIR + GAINS + "[rotors]\n" + column("armature", [0.1, 0.2], ("kg m^2", "kg")))
    assert arm.transmission.matrix.tolist() == [[10, -10], [10, 10]]
    gains = arm.gains
    assert (gains.Kp.tolist(), gains.Kd.tolist(), gains.Ki, gains.effort) == ([5, 6], [1, 2], None, None)
    assert arm.armature.tolist() == [0.1, 0.2]
    assert arm.chain.links[0].rotor.reflected
    assert not any(f"joint_1.{part}" in lwr_dyn.load("lwr4plus").sources for part in ("gains.kp", "motors"))


def test_springs_and_dampers_of_the_gears_with_their_sources(tmp_path):
    arm = loaded(tmp_path, SPRINGS)
    assert (arm.elasticity.stiffness.tolist(), arm.elasticity.damping.tolist()) == ([5, 6], [0.5, 0])
    assert arm.elasticity.source == "assumed, page 1"
    assert [s.cell for s in arm.sources["joint_2.stiffness"]] == ["elasticity.stiffness.values[1]"]
    assert loaded(tmp_path, "").elasticity is None
    lwr = lwr_dyn.load("lwr4plus")
    names = [f"{joint}.{x}" for joint in lwr.joint_names for x in ("stiffness", "damping")]
    assert {source.kind for name in names for source in lwr.sources[name]} == {"assumed"}
    assert np.array_equal(lwr.elasticity.damping, 1e-3 * lwr.elasticity.stiffness)


def test_a_file_beyond_a_dh_table_is_refused_where_a_plain_one_is_needed():
    require_plain_dh(parse_paper(GOOD, "own.toml"), "a page")
    beyond = GOOD.replace("[dh]", "[dh]\n" + column("beta", [0, 0], "deg"), 1)
    with pytest.raises(OptionError, match=r"a page of own.toml: dh.beta; allowed: a DH table without it"):
        require_plain_dh(parse_paper(beyond, "own.toml"), "a page")
    placed = column("xyz", [0.1, 0.2, 0.3], "m") + column("rpy", [0, 0, 90], "deg")
    arm = assembled(("[base]\n", "[base]\n" + placed))
    np.testing.assert_allclose(arm.chain.links[0].before.matrix(), [[0, -1, 0, 0.1], [1, 0, 0, 0.2], [0, 0, 1, 0.3],
                                                                    [0, 0, 0, 1]], atol=1e-15)  # fmt: skip
    assert arm.chain.links[1].before.is_identity()
    assert [s.cell for s in arm.sources["joint_1.dh"]][-2:] == ["base.xyz.values", "base.rpy.values"]
    assert not any("base" in s.cell for s in arm.sources["joint_2.dh"])


def gears(*ratios):
    return "[rotors]\n" + column("gear_ratio", list(ratios), "1") + column("inertia", [1e-4, 2e-4], "kg m^2")


MOTOR = '[friction]\nside = "motor"\n'


def test_friction_of_the_motors_is_seen_at_the_joints_by_the_gear_ratio(tmp_path):
    """Levels by |r|, slopes by its square, speeds by its inverse; a gear that reverses swaps the directions."""
    more = column("positive_static", [1.5, 2.0], FORCE) + column("positive_stribeck_velocity", [0.1, 0.5], SPEED)
    more += column("offset", [0.2, -0.5], FORCE) + column("covered", [4.0, 2.0], SPEED)
    arm = loaded(tmp_path, DIRECTED.replace("[friction]\n", MOTOR) + more + gears(10, -4))
    wanted = (
        JointFriction(Direction(10.0, 10.0, 15.0, 0.01), Direction(30.0, 30.0), 2.0, 0.4),
        JointFriction(Direction(16.0, 6.4), Direction(8.0, -3.2, 8.0, 0.125), 2.0, 0.5),
    )
    for one, other in zip(arm.friction, wanted, strict=True):
        parts = [(*astuple(x.positive), *astuple(x.negative), x.offset, x.covered) for x in (one, other)]
        assert parts[0] == pytest.approx(parts[1])
    speed = np.array([0.03, 0.2])
    at_motors = [1.0 + 0.1 * 0.3 + 0.5 * np.exp(-9.0) + 0.2, -(4.0 + 0.4 * 0.8) - 0.5]
    seen = [model.torque(v) for model, v in zip(arm.friction, speed, strict=True)]
    np.testing.assert_allclose(seen, np.array(at_motors) * [10, -4], rtol=1e-12)
    levels = MOTOR + column("coulomb", [1.0, 2.0], FORCE)
    pair = loaded(tmp_path, levels + column("viscous", [0.1, 0.2], DAMPING) + gears(10, -4))
    assert [(x.coulomb, x.viscous) for x in pair.limits] == [(10.0, pytest.approx(10.0)), (8.0, pytest.approx(3.2))]
    assert pair.sources["joint_1.viscous"][0].conversion == "from the motor to the joint by the gear ratio"
    apart = MAP + column("signs", [[1, 0], [0, -1]], "1")
    assert [x.coulomb for x in loaded(tmp_path, levels + apart).limits] == [10.0, 20.0]
    matrix = "[transmission]\n" + column("matrix", [[3.0, 0.0], [0.5, -7.0]], "1")
    assert loaded(tmp_path, matrix).transmission.matrix.tolist() == [[3.0, 0.0], [0.5, -7.0]]
    for more, message in (
        ("", "friction.side: 'motor' without gear ratios; allowed: rotors.gear_ratio of every joint"),
        (MAP + PAIR, "friction.side: 'motor' with motors that drive several joints; allowed: joint"),
    ):
        with pytest.raises(PaperError, match=message):
            loaded(tmp_path, levels + more)


@pytest.mark.parametrize(
    ("side", "seen"), [("joint", [(1, 3, 0.1), (2, 4, 0.2)]), ("motor", [(10, 30, 0.01), (8, 16, -0.05)])]
)
def test_a_sigmoid_of_the_motors_is_seen_at_the_joints(side, seen):
    rows = (("level", [1.0, 2.0], "N m"), ("slope", [3.0, 4.0], "s/rad"), ("shift", [0.1, 0.2], "rad/s"))
    more = f'[friction]\nside = "{side}"\n' + "".join(column(f"sigmoid_{name}", *row) for name, *row in rows)
    text = template("own.toml", "own", "RR", "standard").replace("[joints]", more + gears(10, -4) + "[joints]", 1)
    arm = arm_from_paper(parse_paper(text, "own.toml"))
    assert [astuple(model.sigmoid) for model in arm.friction] == [pytest.approx(x) for x in seen]
    assert all(model.breakaway == (0.0, 0.0) for model in arm.friction)


@pytest.mark.parametrize("side", ["joint", "motor"])
def test_a_share_of_the_load_is_the_same_at_motor_and_joint_and_is_said_to_be_left_out(side):
    given = DIRECTED.replace("[friction]", f'[friction]\nside = "{side}"') + column("load", [0.0, 0.12], "1")
    text = GOOD.replace("[joints]", given + gears(10, -4) + "[joints]", 1)
    arm = arm_from_paper(parse_paper(text, "own.toml"))
    assert [model.load for model in arm.friction] == [0.0, 0.12]
    assert arm.sources["joint_2.friction.load"][0].value == 0.12
    assert arm.friction_with_load == "left out: friction that grows with the load, 0.12 of it at joint_2"
    assert arm.caveat().endswith(arm.friction_with_load)
    assert "left out" not in arm.caveat(used=("masses",))
    assert "left out" not in assembled(("[joints]", DIRECTED + "[joints]")).caveat()


def test_an_inertia_with_unknown_numbers_names_the_parameters_that_are_open():
    """Mass, first moments, then the tensor about the origin xx xy xz yy yz zz: what no number of the file fixes."""
    masses = next(line for line in GOOD.splitlines() if line.startswith("mass ="))
    whole = assembled()
    assert [body.unknown for body in whole.chain.bodies] == [(), ()]
    text = GOOD.replace(ROW, '[[0.01, 0, "unknown"], [0, 0.01, 0], ["unknown", 0, 0.004]]', 1)
    arm = arm_from_paper(parse_paper(text, "own.toml"))
    assert arm.chain.bodies[0].unknown == (6,)
    assert arm.chain.bodies[0].inertia_com[0, 2] == 0.0
    massless = arm_from_paper(parse_paper(GOOD.replace(masses, masses.replace("2.0", '"unknown"', 1), 1), "own.toml"))
    assert massless.chain.bodies[0].unknown == (0, 3, 4, 7)
    assert arm.sources["link_1.inertia"][0].value[0][2] == "unknown"


@pytest.mark.parametrize(
    ("more", "message"),
    [  # the faults of columns that are there are those of `test_columns.py`
        (DIRECTED + column("sideways_coulomb", [1, 1], FORCE), "friction.sideways_coulomb: unknown field"),
        (MAP + column("signs", [[1, -1, 0], [1, 1, 0]], "1"), r"signs.values\[0\]: 3 entries; allowed: a list of 2"),
        (SPRINGS.partition("damping")[0], "elasticity.damping: missing"),
        (SPRINGS.replace("[5, 6]", "[5, 0]"), r"elasticity.stiffness.values\[1\]: 0.0; allowed: a number above 0"),
        (SPRINGS.replace("[0.5, 0]", "[-1, 0]"), r"elasticity.damping.values\[0\]: -1.0; allowed: a number of at le"),
        (SPRINGS.replace('"N/m"', '"N m/rad"'), "elasticity.stiffness.unit: 'N m/rad' for joint_2; allowed: a unit of"),
        (GAINS.replace("kd", "kv"), "gains.kd: missing"),
        (GAINS.replace("[5, 6]", "[5, 0]"), r"gains.kp.values\[1\]: 0.0; allowed: a number above 0"),
        (GAINS.replace('"N m/rad", ', '"N m", '), "gains.kp.unit: 'N m'; allowed: N m/rad, N/m"),
    ],
)
def test_what_cannot_be_meant_is_refused(more, message):
    with pytest.raises(PaperError, match=f"^own.toml: .*{message}"):
        parse_paper(GOOD.replace("[joints]", more + "[joints]", 1), "own.toml")
