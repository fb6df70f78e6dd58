"""An arm as meshcat commands: each shape once, links where forward kinematics has them, colours of the runs."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.urdf.geometry import Primitive, floor_height, primitives
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.chain import ends_of
from lwr_dyn.model.run import Event
from lwr_dyn.model.spatial import Pose, from_rpy
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.drawn_shapes import drawn_shapes
from lwr_dyn.pages.replay.look import tokens
from lwr_dyn.pages.replay.replay_page import column_major, cylinder, page_data, pose_commands, run_record
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, replayed_runs
from tests.pages.replay.test_replay_page_content import unpacked
from tests.random_arms import random_arm


def replayed(arm, q):
    """The arm at q, in as much of a run as the scene needs."""
    pose = np.eye(4)[None]
    return ReplayedRun(type("R", (), {"q": np.array([q])})(), arm, "x", 1, pose, pose)


def objects_of(arm, q):
    return [c for c in replay_page.arm_commands(replayed(arm, q), 0) if c["type"] == "set_object"]


@pytest.mark.parametrize("seed", range(4))
def test_scene_names_each_shape_once(seed):
    arm = random_arm(seed)
    paths = [c["path"] for c in objects_of(arm, np.zeros(arm.n))]
    assert len(paths) == len(set(paths)) == len(primitives(arm))


def test_transforms_of_the_links_multiply_to_the_pose_of_the_flange(arm):
    q = np.linspace(-1.0, 1.0, arm.n)
    pose, path = np.eye(4), "/arms/run_2/link_0"
    commands = list(pose_commands(arm, q, 2))
    for i, command in enumerate(commands, start=1):
        path += f"/link_{i}"
        assert (command["type"], command["path"]) == ("set_transform", path)
        pose = pose @ np.reshape(command["matrix"], (4, 4)).T
    assert len(commands) == arm.n + 1
    np.testing.assert_allclose(pose, flange_pose(arm.chain, q), atol=1e-12)
    assert list(replay_page.arm_commands(replayed(arm, q), 2))[-arm.n - 1 :] == commands


def test_a_cylinder_stands_along_its_z_axis_with_its_sizes_and_colour():
    """Along y in three.js: R (0 1 0) = R_shape (0 0 1)."""
    pose = Pose(from_rpy((0.3, 0.2, 0.1)), np.array([1.0, 2.0, 3.0]))
    shape = Primitive("link_1", pose, 0.05, 0.4, "grey")
    command = cylinder("/a/b", shape, "run2")
    made = command["object"]
    matrix = np.reshape(made["object"].pop("matrix"), (4, 4)).T
    np.testing.assert_allclose(matrix[:3, :3], pose.rotation @ [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-15)
    np.testing.assert_array_equal(matrix[:3, 3], [1.0, 2.0, 3.0])
    assert command == {"type": "set_object", "path": "/a/b", "object": {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": [{"uuid": "/a/b#geometry", "type": "CylinderGeometry", "radiusTop": 0.05, "radiusBottom": 0.05,
                        "height": 0.4, "radialSegments": 40}],
        "materials": [{"uuid": "/a/b#material", "type": "MeshPhongMaterial", "color": int(tokens()["housing"][1:], 16),
                       "specular": 0x2A2A2A, "shininess": 35}],
        "object": {"uuid": "/a/b", "type": "Mesh", "geometry": "/a/b#geometry", "material": "/a/b#material",
                   "userData": {"token": "housing"}},
    }}  # fmt: skip


@pytest.mark.parametrize(
    ("link", "colour", "length", "token"),
    [
        ("link_1", "orange", 0.1, "limb"), ("link_1", "dark", 0.71, "joint"), ("link_1", "dark", 0.7, "run2"),
        ("base", "dark", 0.1, "joint"), ("flange", "dark", 0.1, "run2"),
    ],
)  # fmt: skip
def test_bodies_are_grey_and_only_bands_have_the_colour_of_their_run(link, colour, length, token):
    shape = Primitive(link, Pose.identity(), 1.0, length, colour)
    assert cylinder("/a", shape, "run2")["object"]["object"]["userData"] == {"token": token}


@pytest.mark.parametrize(("place", "token"), [(0, "run1"), (3, "run4"), (4, "run5"), (9, "run5")])
def test_shapes_are_below_their_links_and_those_of_the_ends_are_moved_with_them(place, token):
    arm = lwr_dyn.load("lwr4plus", mount="ceiling", tool={"xyz": [0.0, 0.1, 0.2]})
    commands = [c for c in replay_page.arm_commands(replace(replayed(arm, np.zeros(7)), place=place), 3)
                if c["type"] == "set_object"]  # fmt: skip
    links = ["base", *(link.link for link in arm.chain.links), "flange"]
    base, tool = ends_of(arm.installation)
    for k, (command, shape) in enumerate(zip(commands, drawn_shapes(arm), strict=True)):
        below = "/".join(f"link_{i}" for i in range(links.index(shape.link) + 1))
        assert command["path"] == f"/arms/run_3/{below}/shape_{k}"
        moved = {"base": base, "flange": tool}.get(shape.link, Pose.identity()) @ shape.pose
        found = np.reshape(command["object"]["object"]["matrix"], (4, 4)).T
        np.testing.assert_allclose(found[:3, 3], moved.position, atol=1e-12)
    worn = {c["object"]["object"]["userData"]["token"] for c in commands}
    assert worn <= {"housing", "limb", "joint", token}
    assert token in worn


def test_the_record_of_a_run_is_what_the_player_draws(arm, two_runs):
    """With each second sample and the last one; the drawn path is thinned to 1500 points by itself."""
    events = tuple(Event(0.1 * k, "torque limit", k % 7) for k in range(401))
    run = replace(two_runs[0], events=events, meta={**two_runs[0].meta, "task": "wave"})
    (shown,) = replayed_runs([run], arm, ["mine"])
    record = run_record(shown, 2)
    kept, drawn = np.arange(0, 3001, 2), np.union1d(np.arange(0, 3001, 3), [3000])
    packed = {"t": run.t[kept], "q": run.q[kept], "q_ref": run.q_ref[kept], "tip_error": shown.tip_error[kept],
              "reference": shown.reference_path[drawn]}  # fmt: skip
    for name, values in packed.items():
        np.testing.assert_allclose(unpacked(record[name]), values, atol=1e-8)
    np.testing.assert_allclose(unpacked(record["trace"]["t"]), run.t[drawn], atol=1e-8)
    np.testing.assert_allclose(unpacked(record["trace"]["points"]), shown.pose[drawn, :3, 3], atol=1e-8)
    assert record["events"] == [[e.t, "torque limit", e.joint] for e in events[:400]]
    assert record["facts"] == [
        ["robot", "lwr4plus"],
        ["reading", "physical"],
        ["controller", "pd-gravity"],
        ["task", "wave"],
    ]
    assert {name: record[name] for name in ("label", "place", "samples", "floor", "caveat", "stops")} == {
        "label": "mine", "place": 1, "samples": [1501, 3001], "floor": floor_height(arm), "caveat": "", "stops": "",
    }  # fmt: skip
    assert record["joints"] == [
        {"name": j.name, "kind": "revolute", "origin": column_major(j.origin)} for j in arm.joints()
    ]
    assert (record["flange"], record["base"]) == (column_major(arm.flange()), column_major(Pose.identity()))
    assert record["native"] == [column_major(link.after) for link in arm.chain.links]
    named = replayed_runs([run], arm, ["pd-gravity"])[0]
    assert ["controller", "pd-gravity"] not in run_record(named)["facts"]


@pytest.mark.parametrize(
    ("rate", "budget", "kept"),
    [(100.0, 4_300_000, 601), (500.0, 4_300_000, 3001), (99.0, 4_300_000, 601), (125.0, 4_300_000, 751),
     (500.0, 128_000, 1001), (500.0, 256_100, 3001), (500.0, 255_000, 1501)],
)  # fmt: skip
def test_samples_are_as_many_as_asked_for_and_fit_the_page(arm, two_runs, monkeypatch, rate, budget, kept):
    """Of 3001 samples at 500 Hz with 16 numbers of 16/3 bytes each: 256 085 bytes."""
    monkeypatch.setattr(replay_page, "SERIES_BUDGET", budget)
    data = page_data(replayed_runs(two_runs[:1], arm), rate)
    assert data["runs"][0]["samples"] == [kept, 3001]
    assert len(data["scene"]) == len(drawn_shapes(arm)) + arm.n + 1
