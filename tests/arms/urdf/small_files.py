"""Files written by tests: URDFs of a robot with one or two joints, link by link, and runs."""

import numpy as np

import lwr_dyn

LINK = (
    '<inertial><origin xyz="0.1 0 0.2" rpy="0.3 -0.2 0.1"/><mass value="2"/>'
    '<inertia ixx="0.02" iyy="0.03" izz="0.04"/></inertial>'
)
LIMIT = '<limit lower="-2" upper="2" effort="9" velocity="3"/>'


def joint(name, parent, child, kind="revolute", inside=LIMIT, axis="0 0 1"):
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="0.1 -0.2 0.3" rpy="0.4 0.5 -0.6"/><parent link="{parent}"/>'
        f'<child link="{child}"/><axis xyz="{axis}"/>{inside}</joint>'
    )


def robot(*joints, **links):
    """A URDF with the links given by name, each with what stands in it."""
    described = [f'<link name="{name}">{inside}</link>' for name, inside in links.items()]
    return "".join(['<robot name="r">', *described, *joints, "</robot>"])


HEAD = '<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">'


def xacro_file(folder, body):
    """A xacro file with this in its robot."""
    return written(folder, f"{HEAD}{body}</robot>", "x.urdf.xacro")


def written(tmp_path, text, name="arm.urdf"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def saved_run(folder, arm, q):
    """A run of the arm that begins at q, written and read again."""
    hold = lwr_dyn.reference("hold", arm, q=q, duration=0.01)
    lwr_dyn.simulate(arm, lambda *_: np.zeros(arm.n), hold).save(folder / "run.npz")
    return lwr_dyn.Run.load(folder / "run.npz")


def assert_indented(text):
    """Each line after the header is one tag, indented by its depth."""
    depth = 0
    for line in text.partition("-->\n")[2].splitlines():
        tag = line.lstrip()
        depth -= tag.startswith("</")
        assert line == "  " * depth + tag
        depth += "</" not in tag and not tag.endswith(("/>", "-->"))
    assert depth == 0
