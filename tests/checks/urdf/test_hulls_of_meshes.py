import os
import stat

import numpy as np
import pytest
import trimesh

from lwr_dyn.checks.urdf import hulls
from lwr_dyn.checks.urdf.hulls import MeshPointsError, folder, keep_points, kept_points, mesh_points, solid_hull

SIZE = (0.2, 0.3, 0.5)


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("LWR_DYN_CACHE", str(tmp_path / "cache"))
    hulls._points.cache_clear()


def box_file(tmp_path, ending, scale=1.0):
    path = tmp_path / f"box{ending}"
    box = trimesh.creation.box(SIZE)
    box.apply_scale(scale)
    content = box.export(file_type=ending[1:].lower())
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


@pytest.mark.parametrize("ending", [".stl", ".obj", ".STL"])
def test_a_box_in_each_format(tmp_path, ending):
    hull = solid_hull(mesh_points(box_file(tmp_path, ending)).points)
    assert hull.volume == pytest.approx(np.prod(SIZE), rel=1e-6)  # STL: single precision
    assert hull.covariance == pytest.approx(np.diag(np.square(SIZE)) / 12.0, rel=1e-6, abs=1e-8)


def dae(unit: str) -> str:
    points = trimesh.creation.box(SIZE)
    numbers = " ".join(str(v) for v in points.vertices.ravel())
    faces = " ".join(str(v) for v in points.faces.ravel())
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{unit}<up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="24">{numbers}</float_array>
<technique_common><accessor source="#pa" count="8" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="12"><input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><matrix>1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


@pytest.mark.parametrize(("unit", "size"), [("", 1.0), ('<unit name="millimeter" meter="0.001"/>', 1e-3)])
def test_a_dae_is_read_in_its_unit_and_with_its_scene(tmp_path, unit, size):
    path = tmp_path / "box.dae"
    path.write_text(dae(unit))
    hull = solid_hull(mesh_points(path).points)
    assert hull.volume == pytest.approx(np.prod(SIZE) * size**3, rel=1e-6)
    assert hull.centroid == pytest.approx([5.0 * size, 0.0, 0.0], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.stl", b"solid x\nfacet nonsense", "without points"),
        ("a.stl", b"", "without points"),
        ("a.obj", b"v 1 2 oops\nf 1 1 1\n", "OBJ"),
        ("a.dae", b"<COLLADA><unclosed>", "DAE"),
        ("a.glb", b"glTF", "format .glb"),
        ("a", b"x", "without an ending"),
    ],
)
def test_what_is_no_mesh_says_so(tmp_path, name, content, said):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(MeshPointsError, match=said):
        mesh_points(path)
    with pytest.raises(MeshPointsError):
        mesh_points(tmp_path / "absent.stl")


def test_points_are_kept_by_content_and_a_changed_file_is_read_again(tmp_path, monkeypatch):
    path = box_file(tmp_path, ".stl")
    first, again = mesh_points(path), tmp_path / "copy.stl"
    again.write_bytes(path.read_bytes())
    hulls._points.cache_clear()
    with monkeypatch.context() as patch:
        patch.setattr(hulls, "_read", None)  # reading again would fail
        assert np.array_equal(mesh_points(again).points, first.points)
        assert mesh_points(again).digest == first.digest
    box_file(tmp_path, ".stl", scale=2.0)
    os.utime(path, ns=(1, 1))
    assert np.ptp(mesh_points(path).points, axis=0) == pytest.approx(2.0 * np.ptp(first.points, axis=0))


DAMAGE = (b"", b"\x80\x04pickle", b"lwr_dyn hull 1\n" + b"\0" * 32 + b"\1" * 24, None)


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_file_of_the_cache_and_one_of_another_mesh_are_built_again(tmp_path, damage):
    path = box_file(tmp_path, ".stl")
    good, other = mesh_points(path), mesh_points(box_file(tmp_path, ".obj", scale=3.0))
    kept = folder() / f"{good.digest}.points"
    content = kept.read_bytes()
    kept.write_bytes((folder() / f"{other.digest}.points").read_bytes() if damage is None else damage)
    hulls._points.cache_clear()
    assert np.array_equal(mesh_points(path).points, good.points)
    assert kept.read_bytes() == content


def test_without_a_folder_to_write_every_process_reads_for_itself(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("LWR_DYN_CACHE", str(blocked))
    assert len(mesh_points(box_file(tmp_path, ".stl")).points) == 8


def test_a_link_among_the_points_is_neither_read_nor_written_through(tmp_path):
    keep_points("a", np.eye(3))
    file = folder() / "a.points"
    file.rename(tmp_path / "elsewhere")
    file.symlink_to(tmp_path / "elsewhere")
    assert kept_points("a") is None
    (tmp_path / "elsewhere").write_bytes(b"mine")
    keep_points("a", np.eye(3))
    assert (tmp_path / "elsewhere").read_bytes() == b"mine"
    assert np.array_equal(kept_points("a"), np.eye(3))


def test_the_folder_that_kernels_share_is_open_to_its_user_alone(tmp_path):
    before = os.umask(0o002)
    try:
        keep_points("a", np.eye(3))
    finally:
        os.umask(before)
    assert np.array_equal(kept_points("a"), np.eye(3))
    assert [stat.S_IMODE(path.stat().st_mode) for path in (tmp_path / "cache", folder())] == [0o700, 0o700]
