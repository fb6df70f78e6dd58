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


@pytest.mark.parametrize(
    ("axis", "unit"),
    [*((f"{x} 0 0", "1 0 0") for x in ("1e200", "1e-160", "1e308", "5e-324")), ("-1e200 0 0", "-1 0 0"),
     *((f"{x} {x} 0", "1 1 0") for x in ("1e200", "1e-160", "1e308")), ("-1e200 -1e200 0", "-1 -1 0")],
)  # fmt: skip
def test_an_axis_of_any_length_is_its_direction(axis, unit, tmp_path):
    there, here = (
        lwr_dyn.load(written(tmp_path, robot(joint("j", "a", "b", axis=x), a="", b=LINK))) for x in (axis, unit)
    )
    assert np.abs(lwr_dyn.forward_kinematics(there, Q) - lwr_dyn.forward_kinematics(here, Q)).max() < 1e-14
    for engine in ("pinocchio", "newton-euler"):
        g = [lwr_dyn.dynamics_of(arm, engine).gravity_vector(Q)[0] for arm in (there, here)]
        assert abs(g[0] - g[1]) < 1e-12


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("</robot>", "<x>" * 3000 + "</x>" * 3000 + "</robot>", "nested .* deep; allowed: at most 100"),
        ("</robot>", "<origin>" * 300 + "</origin>" * 300 + "</robot>", "nested .* deep; allowed: at most 100"),
        ('"j"', f'"{"j" * 10_000_001}"', "XML"),  # libxml2 refuses it; its recovering parser would leave it out
    ],
    ids=("tags", "origins", "a name of ten million characters"),
)
def test_elements_and_names_without_end_are_refused(old, new, says, tmp_path):
    with pytest.raises(UrdfError, match=says):
        parse_urdf(written(tmp_path, ARM.replace(old, new)))


def test_what_the_second_parser_refuses_is_refused_and_not_guessed_at(tmp_path, monkeypatch):
    """yourdfpy reads on with a parser that leaves out what it does not understand."""
    half = b'<robot name="r"><axis gr&#246;="1"/>'
    monkeypatch.setattr("lwr_dyn.arms.urdf.parse.ElementTree.tostring", lambda *_, **__: half)
    with pytest.raises(UrdfError, match=r"arm\.urdf: XML: .*; allowed: a well-formed URDF"):
        parse_urdf(written(tmp_path, ARM))
