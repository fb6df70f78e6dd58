"""The WAM's data file: what its readings and errata claim, recomputed; what a URDF cannot hold is in the sidecar."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.model.chain import Body, is_physical

ABOUT_ORIGIN = {  # the same sheet's tensors about the frame origins, tensor convention [kg m^2]: moments, products
    1: ((0.294863503, 0.113500168, 0.25065343), {"xy": 0.007950225}),
    2: ((0.0260684, 0.014722017, 0.019348137), {}),
    3: ((0.13671601, 0.005883535, 0.139513702), {"xy": 0.016804342}),
    4: ((0.057192689, 0.05716471, 0.003004404), {}),
    5: ((5.59e-5, 7.82e-5, 6.59e-5), {}),
    6: ((9.31067e-4, 4.98334e-4, 5.74835e-4), {"yz": 2.21618e-4}),
    7: ((3.85e-5, 3.88e-5, 7.41e-5), {}),
}
SHEET = 1e-6
"""[kg m^2] The two tables differ in the last digits that the coarser one prints."""


def bodies(reading=None):
    return lwr_dyn.load("wam7", reading).chain.bodies


def test_products_as_integral_are_those_of_the_sheets_tensors_about_the_origins():
    for i, (moments, products) in ABOUT_ORIGIN.items():
        tensor = bodies()[i - 1].inertia_origin()
        assert np.diag(tensor) == pytest.approx(moments, abs=SHEET)
        for axes, value in products.items():
            r, c = ("xyz".index(x) for x in axes)
            assert tensor[r, c] == pytest.approx(value, abs=SHEET), f"link {i} {axes}"
            printed = bodies("printed")[i - 1].inertia_origin()[r, c]
            assert abs(printed - value) > 50 * SHEET, "the sign would not show"


def test_the_triangle_inequality_cannot_decide_the_sign_and_gravity_cannot_either():
    assert all(is_physical(b) for reading in lwr_dyn.readings("wam7") for b in bodies(reading))
    q = np.random.default_rng(0).uniform(-1, 1, (20, 7))
    g = [lwr_dyn.dynamics_of(lwr_dyn.load("wam7", r)).gravity_vector(q) for r in ("manual", "printed")]
    np.testing.assert_array_equal(*g)
    change = max(np.abs(a.inertia_com - b.inertia_com).max() for a, b in zip(bodies(), bodies("printed"), strict=True))
    assert change == pytest.approx(2 * 0.00249612)


@pytest.mark.parametrize(("reading", "links"), [("manual", {1, 3, 4, 6}), ("revised_wrist", {1, 3, 4, 5, 6})])
def test_read_about_the_frame_origins_links_could_not_exist(reading, links):
    paper = open_paper("wam7", reading)
    assert paper.inertia_about == "com"
    ids = {"lspb-velocity", "figure4-acceleration", "table1-negative-viscous", "rotor-inertia-conflict"}
    assert ids <= {e.id for e in paper.errata}
    lost = set()
    for i, b in enumerate(bodies(reading), start=1):
        moved = b.inertia_com - (b.inertia_origin() - b.inertia_com)
        lost |= set() if is_physical(Body(b.mass, b.com, moved)) else {i}
    assert lost == links


def test_masses_and_the_gravity_torques_that_are_published():
    assert sum(b.mass for b in bodies()) == pytest.approx(19.45546, abs=5e-6)
    assert sum(b.mass for b in bodies("revised_wrist")) == pytest.approx(19.459, abs=5e-4)
    for a, b in zip(bodies()[:3], bodies("revised_wrist")[:3], strict=True):
        np.testing.assert_array_equal(a.inertia_com, b.inertia_com)
    g = lwr_dyn.dynamics_of(lwr_dyn.load("wam7")).gravity_vector(np.array([0, np.pi / 2, 0, 0, 0, 0, 0]))
    assert abs(g[1]) == pytest.approx(27.9, abs=0.05)
    assert abs(g[1]) / 9.81 == pytest.approx(2.848, abs=5e-4)
    b = bodies()  # grouped first moment of link 2
    distal = sum(x.mass for x in b[3:])
    grouped = b[1].mass * b[1].com[2] + b[2].mass * (0.55 - b[2].com[1]) + distal * 0.55
    assert grouped == pytest.approx(2.333, abs=5e-4)
    assert 2.3828 / grouped - 1 == pytest.approx(0.021, abs=5e-4)


def test_limits_speeds_and_gains_and_friction_over_stiffness_at_the_levels_of_figure_7():
    arm = lwr_dyn.load("wam7")
    assert arm.lower.tolist() == [-2.6, -2.0, -2.8, -0.9, -4.76, -1.6, -3.0]
    assert arm.upper.tolist() == [2.6, 2.0, 2.8, 3.1, 1.24, 1.6, 3.0]
    assert np.degrees(arm.velocity) == pytest.approx([90, 60, 120, 120, 240, 240, 60])
    assert arm.effort.tolist() == [77.3, 160.6, 95.6, 29.4, 11.6, 11.6, 2.7]
    assert arm.armature.tolist() == [0.201, 0.182, 0.067, 0.034, 0.0033224, 0.0033224, 0.000466939]
    gains = arm.gains
    assert gains.Kp.tolist() == [900, 2500, 600, 500, 50, 50, 8]
    assert gains.Ki.tolist() == [2.5, 5, 2, 0.5, 0.5, 0.5, 0.1]
    assert gains.Kd.tolist() == [10, 20, 5, 2, 0.5, 0.5, 0.05]
    assert gains.effort.tolist() == [25, 20, 15, 15, 5, 5, 5]
    assert not any(x.flags.writeable for x in (gains.Kp, gains.Ki, gains.Kd, gains.effort))
    arm = lwr_dyn.load("wam7")
    cruise = 0.5 / 6
    levels = [1e3 * f.torque(cruise).item() / kp for f, kp in zip(arm.friction, arm.gains.Kp, strict=True)]
    assert levels == pytest.approx([5.10, 1.17, 2.95, 2.63, 5.27, 11.05, 17.86], abs=0.006)
    assert [f.covered for f in arm.friction] == [0.4] * 7


def test_what_a_urdf_cannot_hold_is_in_the_sidecar_and_noted_in_the_header():
    arm = lwr_dyn.load("wam7")
    files = model_files(arm)
    text, side = files["wam7.urdf"], json.loads(files["wam7.provenance.json"])
    assert "<dynamics" not in text
    assert "friction differs by direction, which a URDF and an MJCF cannot hold: none is written here; it is " in text
    for joint, model in zip(arm.joint_names, arm.friction, strict=True):
        block = side["friction"][joint]
        unknown = {"static": None, "stribeck_velocity": None}
        for name in ("positive", "negative"):
            one = getattr(model, name)
            assert block.pop(name) == {"coulomb": one.coulomb, "viscous": one.viscous, **unknown}
        assert block == {"offset": 0.0, "covered": 0.4}
        for quantity in ("positive_coulomb", "negative_viscous", "covered"):
            assert side["quantities"][f"{joint}.friction.{quantity}"][0]["where"].startswith(("Table 1", "Figure 6"))
        assert side["quantities"][f"{joint}.gains.kp"][0]["unit"] == "N m/rad"
    assert side["transmission"]["motors_by_joints"] == arm.transmission.matrix.tolist()
    assert side["gains"]["Kd"] == arm.gains.Kd.tolist()


def test_reflected_rotors_reach_every_dialect_and_make_no_spin_couplings():
    arm = lwr_dyn.load("wam7")
    files = model_files(arm)
    assert files["wam7.srdf"].count('gear_ratio="1.0"') == 7
    assert "gear ratios are stand-ins of 1: joint_1" in files["wam7.urdf"]
    full, plain = (lwr_dyn.dynamics_of(arm, "newton-euler", rotors=r) for r in ("full", "armature"))
    q, dq, ddq = np.random.default_rng(0).normal(size=(3, 7))
    np.testing.assert_array_equal(full.inverse_dynamics(q, dq, ddq), plain.inverse_dynamics(q, dq, ddq))
