"""The arm in a tree that branches: its tip, what is held, and the tips that are listed where there are several arms."""

import sys

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.urdf.parse import parse_urdf
from lwr_dyn.arms.urdf.reader import read_urdf
from lwr_dyn.arms.urdf.tree import build_tree, obvious_tip, with_held_joints
from lwr_dyn.foundation.errors import UnknownNameError, UrdfError
from tests.arms.urdf.small_files import LIMIT, LINK, joint, robot, saved_run, written

MIMIC = LIMIT + '<mimic joint="{}" multiplier="-2" offset="0.1"/>'


def chain(first, *links, kind="revolute"):
    """Joints of that kind from link to link, each named after its child."""
    return [joint(f"j_{child}", parent, child, kind) for parent, child in zip((first, *links), links, strict=False)]


def fixed(parent, *children):
    return [joint(f"f_{child}", parent, child, "fixed", "") for child in children]


def tree_of(tmp_path, joints, name="arm.urdf"):
    """The file of these joints and of the links that they name."""
    words = " ".join(joints).replace('link="', "\0").split("\0")[1:]
    links = dict.fromkeys(word.split('"')[0] for word in words)
    path = written(tmp_path, robot(*joints, **dict.fromkeys(links, LINK)), name)
    return path, build_tree(parse_urdf(path), {})


ARM = chain("base", *"abcdef")
FINGERS = [*chain("f", "left"), *chain("f", "right")]
CASES = {
    "one chain": (ARM, "f"),
    "one chain ends in a gripper": ([*ARM, *chain("f", "gripper")], "gripper"),
    "fingers": ([*ARM, *FINGERS], "f"),
    "fingers of three joints": ([*ARM, *chain("f", "l1", "l2", "l3"), *chain("f", "r1", "r2", "r3")], "f"),
    "fingers on a hand": ([*ARM, *fixed("f", "hand"), *chain("hand", "l"), *chain("hand", "r")], "hand"),
    "a tool frame": ([*ARM, *FINGERS, *fixed("f", "camera", "hand_tcp")], "hand_tcp"),
    "frames on the last link": ([*ARM, *fixed("f", "ee_link", "tool0")], "tool0"),
    "frames without a known name": ([*ARM, *fixed("f", "left", "right")], "f"),
    "one jaw beside a frame": ([*ARM, *fixed("f", "point"), *chain("f", "moving_jaw")], "f"),
    "one more joint beside a frame": ([*ARM, *fixed("f", "point"), *chain("f", "g")], "g"),
    "a head and wheels": ([*ARM, *chain("a", "pan", "tilt"), *chain("base", "wheel")], "f"),
    "an arm on a quadruped": ([*ARM, *(x for leg in "1234" for x in chain("base", f"h{leg}", f"k{leg}"))], "f"),
    "frames on the base": ([*ARM, *fixed("base", "lamp")], "f"),
    "fingers that follow": ([*ARM, *chain("f", "l"), joint("twin", "f", "r", "revolute", MIMIC.format("j_l"))], "f"),
    "a wrist that is called gripper": (
        [*chain("base", *"abcd"), *chain("d", "gripper", "f"), *fixed("base", "x")],
        "f",
    ),
    "a floating base": ([joint("free", "world", "base", "floating", ""), *ARM, *FINGERS], "f"),
    "a base on a plane": ([joint("drive", "world", "base", "planar", ""), *ARM], "f"),
}


@pytest.mark.parametrize("case", CASES)
def test_the_tip_of_the_one_obvious_arm(tmp_path, case):
    joints, tip = CASES[case]
    path, _ = tree_of(tmp_path, joints)
    arm = read_urdf(path)
    assert arm.n == 6 + (case in ("one chain ends in a gripper", "one more joint beside a frame"))
    assert arm.layout.tip == tip


FOUR, PAIR = chain("base", *"abcd"), ("l", "r")
BRANCHES = (  # joints, and the tip of the one arm, or how many arms and legs there are
    ([*FOUR, *chain("base", "u", "v")], "d"),  # twice as long as the other
    ([*FOUR, *chain("base", "u", "v", "w")], 2),
    ([*chain("base", *"abc"), *chain("base", "u")], 2),  # of fewer than four joints none is the arm
    ([*FOUR, *(x for f in PAIR for x in chain("d", f"{f}1", f"{f}2", f"{f}3"))], "d"),  # fingers shorter than the arm
    ([*FOUR, *(x for f in PAIR for x in chain("d", f"{f}1", f"{f}2", f"{f}3", f"{f}4"))], 2),
    ([*chain("base", *"abc"), *(x for f in PAIR for x in chain("c", f"{f}1", f"{f}2"))], 2),  # three joints are no arm
    ([*FOUR, *chain("d", "jaw", "tip")], "tip"),  # one finger has one joint
    ([x for k in range(12) for x in chain("base", f"w{k}")], 12),
)


@pytest.mark.parametrize(("joints", "found"), BRANCHES)
def test_where_joints_branch_off_lengths_decide(tmp_path, joints, found):
    _, tree = tree_of(tmp_path, joints)
    if isinstance(found, str):
        assert obvious_tip(tree) == found
        return
    with pytest.raises(UrdfError, match=rf"the tree has {found} arms or legs; .* joints?\)$"):
        obvious_tip(tree)


@pytest.mark.parametrize("count", [6, 7])
def test_a_note_names_six_other_ends(tmp_path, count):
    path, _ = tree_of(tmp_path, [*ARM, *(x for k in range(count) for x in chain("f", f"g{k}"))])
    ends = ", ".join(f"g{k}" for k in range(6)) + (" ..." if count > 6 else "")
    assert read_urdf(path).notes[0] == f"the arm ends at f; another end: --tip LINK, such as {ends}"


def test_several_arms_are_listed_with_what_to_type_and_an_unknown_tip_names_their_ends_first(tmp_path):
    joints = [*chain("base", "torso"), *chain("torso", *"abcdef"), *FINGERS, *chain("torso", *"uvwxyz")]
    joints += [*chain("torso", "pan", "tilt"), *chain("base", "k1", "k2", "k3"), *chain("base", "m1", "m2", "m3")]
    _, tree = tree_of(tmp_path, joints)
    with pytest.raises(UrdfError) as fault:
        obvious_tip(tree)
    listed = "f (7 joints), z (7 joints), tilt (3 joints), k3 (3 joints), m3 (3 joints)"
    assert str(fault.value) == f"arm.urdf: tip: the tree has 5 arms or legs; allowed: one of them by --tip: {listed}"
    _, tree = tree_of(tmp_path, [*fixed("base", "lamp"), *fixed("base", "arm"), *fixed("arm", "hand")])
    assert obvious_tip(tree) == "hand"  # nothing moves: the deepest end, and what it lacks is said when it is read
    _, tree = tree_of(tmp_path, [*chain("base", *"abcd"), *chain("d", *"efghi"), *chain("d", *"uvwxy")])
    with pytest.raises(UrdfError, match=r"2 arms or legs; .*: i \(9 joints\), y \(9 joints\)$"):
        obvious_tip(tree)
    path, _ = tree_of(tmp_path, [x for k in range(20) for x in chain("base", f"w{k}")])
    with pytest.raises(UrdfError, match=r"20 arms or legs; .*w11 \(1 joint\) \.\.\.$"):
        read_urdf(path)
    path, _ = tree_of(tmp_path, [*chain("base", "g", "h", "i", "k"), *ARM, *fixed("f", "tcp")])
    with pytest.raises(UnknownNameError, match=r"no link of .* named 'hand'; known: tcp, k, base, g, ") as fault:
        read_urdf(path, tip="hand")
    assert sorted(fault.value.known) == sorted(["base", *"abcdefghik", "tcp"])


@pytest.mark.slow
def test_a_deep_file_is_walked_without_recursion(tmp_path):
    links = [f"l{k}" for k in range(1200)]
    _, tree = tree_of(tmp_path, [*chain("base", *links), *chain("base", "other")])
    assert obvious_tip(tree) == "l1199"


def test_what_branches_off_is_held_and_said(tmp_path):
    above = '<limit lower="0.2" upper="2" effort="9" velocity="3"/>'
    twin = joint("twin", "f", "r", "revolute", MIMIC.format("j_l"))
    joints = [*ARM, joint("j_l", "f", "l", "prismatic", above), twin, *chain("base", "wheel")]
    path, tree = tree_of(tmp_path, joints)
    assert with_held_joints(tree, "f")[1] == {"j_l": 0.2, "twin": -2 * 0.2 + 0.1}
    arm, given = read_urdf(path), read_urdf(path, tip="f", lock={"j_l": 0.2})
    chosen = "the arm ends at f; another end: --tip LINK, such as l, r, wheel"
    assert arm.notes == (chosen, "held: j_l at 0.2, twin at -0.3; other values: --lock JOINT=VALUE")
    assert (given.notes, read_urdf(path, lock={"j_l": 0.5}).notes) == ((), (chosen,))
    q = np.linspace(0.1, 0.7, 6)
    assert np.array_equal(*(lwr_dyn.dynamics_of(x).mass_matrix(q) for x in (arm, given)))


def test_a_held_base_is_the_fixed_base(tmp_path):
    free, weld = (
        tree_of(tmp_path, [joint("free", "world", "base", kind, ""), *ARM], f"{kind}.urdf")[0]
        for kind in ("floating", "fixed")
    )
    q = np.linspace(0.1, 0.7, 6)
    poses = [lwr_dyn.forward_kinematics(read_urdf(path), q) for path in (free, weld)]
    assert np.array_equal(*poses)
    assert read_urdf(free).notes == ("held: free at 0; other values: --lock JOINT=VALUE",)


REFUSED = {
    "a mimic on the chain": (
        [*ARM, joint("twin", "f", "g", "revolute", MIMIC.format("j_f"))], "g",
        "joint 'twin': follows 'j_f' (mimic), in a chain of joints that move by themselves; "
        "allowed: a chain that ends before it: --tip f, or held: --lock twin=VALUE",
    ),
    "a mimic beside the chain": (
        [*ARM, joint("twin", "b", "g", "revolute", MIMIC.format("j_c"))], "f",
        "joint twin: off the chain, but a joint of the chain moves it (mimic); "
        "allowed: held at a value: --lock twin=VALUE",
    ),
    "a mimic on another branch of the root": (
        [*ARM, joint("twin", "base", "g", "revolute", MIMIC.format("j_c"))], "f",
        "joint twin: off the chain, but a joint of the chain moves it (mimic); allowed: held",
    ),
    "a floating joint in the chain": (
        [*ARM, joint("free", "f", "g", "floating", "")], "g",
        "joint 'free': type floating, in a chain of joints with one coordinate each; "
        "allowed: a chain that ends before it: --tip f, or",
    ),
    "a planar joint in the chain": (
        [*ARM, joint("slide", "f", "g", "planar", "")], "g", "joint 'slide': type planar, in a chain",
    ),
    "a held base without an arm": (
        [joint("free", "base", "a", "floating", ""), *fixed("base", "b")], None,
        "chain: no moving joint between root and tip, and free of type floating is held",
    ),
    "nothing moves": (fixed("base", "a", "b"), None, "chain: no moving joint between root and tip; allowed"),
    "a tip that does not move": (
        [*ARM, *chain("base", "g", "h", "i", "k"), *fixed("base", "foot")], "foot",
        "chain: no moving joint between root and tip; allowed: another tip: f (6 joints), k (4 joints); or fewer locks",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_chain_is_refused_with_what_to_type(tmp_path, case):
    joints, tip, message = REFUSED[case]
    path, _ = tree_of(tmp_path, joints)
    with pytest.raises(UrdfError) as fault:
        read_urdf(path, tip=tip)
    assert message in str(fault.value)


def test_commands_say_what_was_chosen_on_stderr(tmp_path, lwr_dyn_command):
    path, _ = tree_of(tmp_path, [*ARM, *FINGERS])
    code, out, err = lwr_dyn_command("fk", str(path), "--q", "0,0,0,0,0,0")
    assert not code
    assert "the arm ends" not in out
    assert err.splitlines() == [
        "note: the arm ends at f; another end: --tip LINK, such as left, right",
        "note: held: j_left at 0, j_right at 0; other values: --lock JOINT=VALUE",
    ]


MACROS = f"""<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="ends" default="b"/>
<xacro:macro name="link" params="name"><link name="${{name}}">{LINK}</link></xacro:macro>
<xacro:link name="base"/><xacro:link name="$(arg ends)"/>{joint("j", "base", "$(arg ends)")}</robot>"""


def test_a_xacro_is_expanded_with_its_arguments_and_those_without_a_name_are_refused(tmp_path, lwr_dyn_command):
    path = written(tmp_path, MACROS, "arm.urdf.xacro")
    arm = lwr_dyn.load(path, xacro_args={"ends": "tip"})
    assert arm.chain.links[0].link == "tip"
    assert lwr_dyn.load(path).chain.links[0].link == "b"
    code, out, _ = lwr_dyn_command("urdf", str(path), "--xacro-arg", "ends:=tool")
    assert not code
    assert '<link name="tool">' in out
    with pytest.raises(UrdfError, match="xacro"):
        lwr_dyn.load(written(tmp_path, MACROS.replace("${name}", "${nothing}"), "bad.xacro"))
    for text in ("ends=tool", ":=tool"):
        code, _, err = lwr_dyn_command("urdf", "x.xacro", "--xacro-arg", text)
        assert code == 2
        assert f"--xacro-arg: {text!r}; allowed: NAME:=VALUE" in err


def test_a_run_of_a_xacro_finds_its_arm_again(tmp_path):
    path = written(tmp_path, MACROS, "arm.urdf.xacro")
    arm = lwr_dyn.load(path, xacro_args={"ends": "tip"}, mount="wall")
    run = saved_run(tmp_path, arm, [0.1])
    lwr_dyn.replay(run, tmp_path / "x.html")
    path.write_text(MACROS.replace('value="2"', 'value="3"'), encoding="utf-8")
    with pytest.raises(OSError, match="has changed since the run was made"):
        lwr_dyn.replay(run, tmp_path / "x.html")


def test_without_the_package_one_line_says_how_to_install_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(ImportError, match=r"xacro is not installed; install it with: pip install 'lwr_dyn\[urdf\]'"):
        lwr_dyn.load(written(tmp_path, MACROS, "arm.xacro"))
