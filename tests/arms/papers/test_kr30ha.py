"""The KR 30 HA data file: what is estimated is reproduced by its method, and belongs to bodies that can exist."""

from importlib import resources

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.arms.papers.solids import COM_DIGITS, INERTIA_DIGITS, MASS_DIGITS, cylinder_body, solid_bodies
from lwr_dyn.arms.urdf.model_files import provenance_text
from lwr_dyn.foundation.errors import PaperError, RatingWarning
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.model.chain import with_payload
from lwr_dyn.model.file_layout import DrawnCylinder
from lwr_dyn.model.spatial import principal_moments

TEXT = resources.files("lwr_dyn.arms.papers").joinpath("kr30ha.toml").read_text(encoding="utf-8")
LEAST = np.array([0.211, 0.228, 0.178, 0.123, 0.030, 0.013, 0.001])
MOST = np.array([0.428, 0.328, 0.207, 0.146, 0.070, 0.031, 0.007])
"""Shares of the total, base to link 6: what a newer KR 30 and a uniform reading of a public mesh lie between."""
ARM, PAPER = lwr_dyn.load("kr30ha"), open_paper("kr30ha")


def test_the_numbers_in_the_file_are_those_of_the_method_whose_cylinder_is_the_textbooks():
    total = PAPER.columns["ratings.mass"].values[0]
    _, *bodies = solid_bodies(PAPER.solids, total).values()
    masses = [round(body.mass, MASS_DIGITS) for body in bodies]
    assert PAPER.columns["base.mass"].values[0] == round(total - sum(masses), MASS_DIGITS)  # what rounding leaves
    assert PAPER.columns["inertial.mass"].values == tuple(masses)
    for i, body in enumerate(bodies):
        assert PAPER.columns["inertial.com"].values[i] == tuple(np.round(body.com, COM_DIGITS))
        assert np.array_equal(PAPER.columns["inertial.inertia"].si()[i], np.round(body.inertia_com, INERTIA_DIGITS))
    body = cylinder_body(DrawnCylinder("link_1", (0, 0, -0.5), (0, 0, 0.5), 0.2, "grey"), 1000.0)
    mass = 1000.0 * np.pi * 0.04
    assert body.mass == pytest.approx(mass)
    assert np.diag(body.inertia_com) == pytest.approx([mass * (0.12 + 1) / 12] * 2 + [mass * 0.02])


def test_every_tensor_is_of_a_body_and_its_own_mirror_image_and_every_share_of_the_total_is_plausible():
    """The arm's plane at A = 0 is y = 0 in the base: what is odd in y must vanish."""
    frames = [np.eye(4)]
    for link in ARM.chain.links:
        frames.append(frames[-1] @ link.pose(0.0).matrix())
    for body, frame in zip(ARM.chain.bodies, frames[1:], strict=True):
        low, middle, high = principal_moments(body.inertia_com)
        assert low > 0.0
        assert low + middle > high
        seen = frame[:3, :3] @ body.inertia_com @ frame[:3, :3].T
        assert abs(seen[0, 1]) < 1e-12
        assert abs(seen[1, 2]) < 1e-12
        assert abs((frame @ [*body.com, 1.0])[1]) < 1e-12
    masses = np.array([ARM.ratings.base_mass, *(body.mass for body in ARM.chain.bodies)])
    assert masses.sum() == pytest.approx(665.0, abs=1e-9)
    assert ((masses / 665.0 >= LEAST) & (masses / 665.0 <= MOST)).all()


def test_estimates_are_marked_down_into_the_urdf():
    text = lwr_dyn.urdf_text(ARM)
    assert "estimated, not measured: mass of link_1, link_2" in text
    assert "estimated, not measured" not in lwr_dyn.urdf_text(lwr_dyn.load("lwr4plus"))
    assert '"kind": "estimated"' in provenance_text(ARM)
    assert "A1 effort" in text.split("unknown, written as stand-ins: ")[1].splitlines()[0]


def test_numbers_and_the_drawing_are_those_of_the_data_sheet():
    assert ARM.joint_names == ("A1", "A2", "A3", "A4", "A5", "A6")
    assert np.degrees(ARM.mastering) == pytest.approx([0, -90, 90, 0, 0, 0])
    assert (ARM.ratings.payload, ARM.ratings.reach, ARM.ratings.envelope_volume) == (30.0, 2.033, 27.24)
    assert np.degrees(ARM.velocity) == pytest.approx([140, 126, 140, 260, 245, 322])
    assert np.isinf(ARM.effort).all()
    assert {c.link for c in ARM.drawing.cylinders} == {"base", *(f"link_{i}" for i in range(1, 7))}
    flange = next(c for c in ARM.drawing.cylinders if c.link == "link_6")
    assert np.allclose(flange.end, ARM.flange().position)


def test_the_rated_payload_is_carried_and_more_is_warned_of():
    heavy = arm_with_payload(ARM, 30.0, (0, 0, 0.1))
    assert heavy.chain.bodies[5].mass == pytest.approx(ARM.chain.bodies[5].mass + 30.0)
    g = lwr_dyn.dynamics_of(heavy).gravity_vector(np.zeros(6)) - lwr_dyn.dynamics_of(ARM).gravity_vector(np.zeros(6))
    assert g[1] == pytest.approx(-30.0 * 9.81 * (2.19 + 0.1 - 0.35))
    assert np.abs(with_payload(ARM.chain, 30.0).bodies[5].com).max() < 0.01
    with pytest.warns(RatingWarning, match="kr30ha: a payload of 31 kg is over the rated 30 kg"):
        arm_with_payload(ARM, 31.0)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('link = "link_6"', 'link = "link_7"', r"drawing.solids.rows\[23\].link: 'link_7'; allowed: one of base, li"),
        ("radius = 80,", "radius = 0,", r"rows\[23\].radius: 0; allowed: a number above 0"),
        ("from = [0, 0, -40]", "from = [0, 0]", r"rows\[23\].from: \[0, 0\]; allowed: a list of 3 finite numbers"),
        ("from = [0, 0, -40]", "from = [0, 0, 0]", r"rows\[23\]: from and to are both"),
        ("from = [0, 0, -40]", "from = [0, 0, inf]", "a list of 3 finite numbers"),
        ('radius = 80, colour = "dark"', 'radius = 80, colour = "blue"', "colour: 'blue'; allowed: one of orange"),
        ('unit = "mm"\nwhere', 'unit = "kg"\nwhere', "drawing.solids.unit: 'kg'; allowed: m, mm"),
        ('kind = "estimated"\nrows', 'kind = "guess"\nrows', "drawing.solids.kind: 'guess'"),
        ("radius = 80,", "radius = 80, weight = 3,", r"rows\[23\].weight"),
        ("radius = 80, ", "", r"rows\[23\].radius: missing"),
        ('values = 27.24, unit = "m^3"', 'values = 0, unit = "m^3"', "envelope_volume.* 0.0; allowed: a number abo"),
        ('values = 2033, unit = "mm"', 'values = 2033, unit = "kg"', "ratings.reach.unit: 'kg'; allowed: m, mm"),
    ],
)
def test_a_broken_file_is_refused(old, new, said):
    assert old in TEXT
    with pytest.raises(PaperError, match=said):
        parse_paper(new.join(TEXT.rsplit(old, 1)), "kr30ha.toml")
