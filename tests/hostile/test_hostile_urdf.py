"""URDFs that are hostile: read as they are written, or refused; never guessed at."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.urdf.parse import parse_urdf
from lwr_dyn.foundation.errors import UrdfError
from tests.arms.urdf.small_files import LINK, joint, robot, written

ARM = robot(joint("j", "a", "b", axis="0 1 0"), a="", b=LINK)
Q = [0.7]


@pytest.mark.parametrize(
    "place", ["<axis", "<origin", "<limit", "<mass", "<inertia", "<joint", "<parent", "<child", "<link", "<robot"]
)
def test_an_attribute_with_a_name_beyond_ascii_changes_nothing(place, tmp_path):
    plain = lwr_dyn.load(written(tmp_path, ARM))
    other = lwr_dyn.load(written(tmp_path, ARM.replace(f"{place} ", f'{place} größe="1" 名="2" '), "other.urdf"))
    assert np.array_equal(lwr_dyn.forward_kinematics(other, Q), lwr_dyn.forward_kinematics(plain, Q))
    assert other.limits == plain.limits
    assert other.chain.links[0].body.mass == plain.chain.links[0].body.mass == 2.0


@pytest.mark.parametrize("inside", ["<空/>", "<größe a='1'>x</größe>", "<a:b xmlns:a='u'/>", "<!-- 空 -->", "<?空 x?>"])
def test_an_element_with_a_name_beyond_ascii_changes_nothing(inside, tmp_path):
    plain = lwr_dyn.forward_kinematics(lwr_dyn.load(written(tmp_path, ARM)), Q)
    for mark in ("<link", "<joint", "<axis", "<mass"):
        arm = lwr_dyn.load(written(tmp_path, ARM.replace(mark, inside + mark, 1), "other.urdf"))
        assert np.array_equal(lwr_dyn.forward_kinematics(arm, Q), plain)


@pytest.mark.parametrize("length", ["1e200", "1e-160", "1e308", "5e-324", "-1e200"])
def test_an_axis_of_any_length_is_its_direction(length, tmp_path):
    for axis in (f"{length} 0 0", f"{length} {length} 0"):
        if "324" in length and axis.count(length) > 1:
            continue
        sign = -1.0 if length.startswith("-") else 1.0
        unit = " ".join(str(sign * (x != "0")) for x in axis.split())
        there, here = (
            lwr_dyn.load(written(tmp_path, robot(joint("j", "a", "b", axis=x), a="", b=LINK))) for x in (axis, unit)
        )
        assert np.abs(lwr_dyn.forward_kinematics(there, Q) - lwr_dyn.forward_kinematics(here, Q)).max() < 1e-14
        for engine in ("pinocchio", "newton-euler"):
            g = [lwr_dyn.dynamics_of(arm, engine).gravity_vector(Q)[0] for arm in (there, here)]
            assert abs(g[0] - g[1]) < 1e-12


@pytest.mark.parametrize("inside", ["<x>" * 3000 + "</x>" * 3000, "<origin>" * 300 + "</origin>" * 300])
def test_elements_nested_without_end_are_refused(inside, tmp_path):
    with pytest.raises(UrdfError, match=r"nested .* deep; allowed: at most 100"):
        parse_urdf(written(tmp_path, ARM.replace("</robot>", inside + "</robot>")))


def test_what_the_second_parser_refuses_is_refused_and_not_guessed_at(tmp_path, monkeypatch):
    """yourdfpy reads on with a parser that leaves out what it does not understand."""
    half = b'<robot name="r"><axis gr&#246;="1"/>'
    monkeypatch.setattr("lwr_dyn.arms.urdf.parse.ElementTree.tostring", lambda *_, **__: half)
    with pytest.raises(UrdfError, match=r"arm\.urdf: XML: .*; allowed: a well-formed URDF"):
        parse_urdf(written(tmp_path, ARM))


def test_a_name_of_ten_million_characters_is_refused(tmp_path):
    """libxml2 refuses it, and its recovering parser would leave it out."""
    with pytest.raises(UrdfError, match="XML"):
        parse_urdf(written(tmp_path, ARM.replace('"j"', f'"{"j" * 10_000_001}"')))
