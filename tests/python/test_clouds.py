"""Meshes, clouds and CT volumes as arrays."""

import gc
import os
from typing import Any

import numpy as np
import pytest
from conftest import box_arrays, write_obj

import cloudcontact as cc

BOX = [0.02, 0.016, 0.012]


def test_a_box_has_its_volume_mass_and_inertia(box_cloud):
    mass = box_cloud.mass_properties(7800)
    volume = np.prod(BOX)
    assert mass.volume == pytest.approx(volume, rel=1e-6)
    assert mass.mass == pytest.approx(7800 * volume, rel=1e-6)
    np.testing.assert_allclose(mass.center_of_mass, 0, atol=1e-9)
    x, y, z = np.square(BOX)
    np.testing.assert_allclose(np.diag(mass.inertia), mass.mass / 12 * np.array([y + z, x + z, x + y]), rtol=1e-3)


def test_arrays_files_and_meshes_give_the_same_cloud(box, box_cloud, tmp_path):
    write_obj(tmp_path / "box.obj", *box_arrays(np.array(BOX) * 1000))
    from_file = cc.digitize(tmp_path / "box.obj", 0.001, unit="mm")
    from_arrays = cc.digitize(box_arrays(BOX), 0.001)
    for other in (from_file, from_arrays):
        np.testing.assert_array_equal(other.coverage, box_cloud.coverage)
        np.testing.assert_allclose(other.origin, box_cloud.origin, atol=1e-12)
    one = cc.digitize(box, 0.001, threads=1)
    np.testing.assert_array_equal(one.coverage, box_cloud.coverage)


def test_writing_through_vertices_moves_the_mesh():
    mesh = cc.Mesh(*box_arrays(BOX))
    mesh.vertices[:, 0] *= 2
    assert cc.inspect(mesh).volume == pytest.approx(2 * np.prod(BOX))
    assert cc.digitize(mesh, 0.001).mass_properties(1).volume == pytest.approx(2 * np.prod(BOX), rel=1e-6)
    assert np.shares_memory(mesh.vertices, mesh.vertices)
    assert np.shares_memory(mesh.triangles, mesh.triangles)


def test_arrays_outlive_what_they_show():
    mesh = cc.Mesh(*box_arrays(BOX))
    vertices, expected = mesh.vertices, mesh.vertices.copy()
    cloud = cc.digitize(mesh, 0.001)
    bricks, bricks_expected = cloud.bricks, cloud.bricks.copy()
    del mesh, cloud
    gc.collect()
    junk = [np.full(100_000, 7.0) for _ in range(50)]
    np.testing.assert_array_equal(vertices, expected)
    np.testing.assert_array_equal(bricks, bricks_expected)
    assert len(junk) == 50


def test_bricks_share_the_clouds_memory(box_cloud):
    bricks, table, dense = box_cloud.bricks, box_cloud.brick_table, box_cloud.coverage
    assert np.shares_memory(bricks, box_cloud.translated([1, 0, 0]).bricks)  # copies share voxels
    assert not bricks.flags.writeable
    with pytest.raises(ValueError):
        bricks[0, 0, 0, 0] = 1
    for at in np.ndindex(*table.shape):
        block = dense[tuple(slice(8 * i, 8 * i + 8) for i in at)]
        number = table[at]
        expected = {-1: 0, -2: 255}.get(number)
        np.testing.assert_array_equal(block, bricks[number] if expected is None else np.full((8, 8, 8), expected))


def test_an_array_of_voxels_comes_back():
    coverage = np.random.default_rng(5).integers(0, 256, (11, 7, 19), dtype=np.uint8)
    material = np.random.default_rng(6).integers(0, 3, coverage.shape, dtype=np.uint8)
    cloud = cc.Cloud.from_array(coverage, 0.002, [1, 2, 3], material, ["bone", "pulp", "enamel"])
    inner = tuple(slice(8, 8 + n) for n in coverage.shape)
    np.testing.assert_array_equal(cloud.coverage[inner], coverage)
    held = coverage > 0
    np.testing.assert_array_equal(cloud.material[inner][held], material[held])
    assert cloud.coverage.sum(dtype=int) == coverage.sum(dtype=int)
    np.testing.assert_allclose(cloud.center(8, 8, 8), np.array([1, 2, 3]) + 0.001)
    assert cloud.materials == ["bone", "pulp", "enamel"]
    assert cloud.voxels == held.sum()


@pytest.mark.parametrize("kind", [bool, np.float32, np.float64, np.uint8])
def test_shares_booleans_and_bytes_mean_the_same(kind):
    full = {np.uint8: 255}.get(kind, 1)
    cloud = cc.Cloud.from_array(np.full((8, 8, 8), full, kind), 0.001)
    assert cloud.mass_properties(1).volume == pytest.approx(512e-9)


def test_fields_of_arrays_equal_those_of_meshes(box_cloud, box_field):
    again = cc.Cloud.from_array(box_cloud.coverage, 0.001, box_cloud.origin)
    field = cc.SurfaceField(again)
    points = np.random.default_rng(1).uniform(-0.011, 0.011, (500, 3))
    depth, normal = field.at(points)
    expected, expected_normal = box_field.at(points)
    near = np.abs(expected) < 0.001  # beyond the band the two grids end at different places
    assert near.sum() > 50
    np.testing.assert_allclose(depth[near], expected[near], atol=2e-8)
    np.testing.assert_allclose(normal[near], expected_normal[near], atol=1e-4)


def test_a_ct_volume_shares_its_values_and_becomes_a_ball():
    n, spacing = 40, 0.0005
    at = (np.indices((n, n, n)) + 0.5) * spacing - n * spacing / 2
    distance = np.sqrt((at**2).sum(axis=0))
    volume = cc.CtVolume(np.zeros((n, n, n)), [spacing] * 3, [-n * spacing / 2] * 3)
    with pytest.raises(ValueError, match="air"):
        cc.digitize_volume(volume, 500)
    # Written into the volume's own memory.
    volume.values[...] = 1000 * np.clip((0.008 - distance) / spacing + 0.5, 0, 1)
    cloud = cc.digitize_volume(volume, 500)
    mass = cloud.mass_properties(1)
    assert mass.volume == pytest.approx(4 / 3 * np.pi * 0.008**3, rel=0.01)
    np.testing.assert_allclose(mass.center_of_mass, 0, atol=1e-6)
    two = cc.digitize_volume(volume, {"soft": 200, "hard": 900})
    assert two.materials == ["soft", "hard"]


def test_cloud_files(box_cloud, tmp_path):
    box_cloud.save(tmp_path / "box.cloud")
    again = cc.Cloud.load(tmp_path / "box.cloud")
    np.testing.assert_array_equal(again.coverage, box_cloud.coverage)
    np.testing.assert_array_equal(cc.digitize(tmp_path / "box.cloud").coverage, box_cloud.coverage)
    raw = bytearray((tmp_path / "box.cloud").read_bytes())
    raw[len(raw) // 2] ^= 1
    (tmp_path / "bad.cloud").write_bytes(raw)
    with pytest.raises(RuntimeError, match="bad.cloud"):
        cc.Cloud.load(tmp_path / "bad.cloud")


def test_cuts_and_pieces():
    cloud = cc.digitize(box_arrays([0.02, 0.004, 0.004]), 0.001)
    dense = cloud.coverage
    middle = np.argwhere(dense > 0)
    middle = middle[middle[:, 0] == dense.shape[0] // 2]
    pieces = cloud.cut(middle).pieces()
    assert len(pieces) == 2
    left = sum(p.mass_properties(1).volume for p in pieces)
    assert left == pytest.approx(0.019 * 0.004 * 0.004, rel=1e-6)
    with pytest.raises(IndexError):
        cloud.cut([[10_000, 0, 0]])


def test_parts_become_materials():
    outer, inner = cc.Mesh(*box_arrays([0.02] * 3)), cc.Mesh(*box_arrays([0.01] * 3))
    cloud = cc.digitize({"shell": outer, "core": inner}, 0.001)
    assert cloud.materials == ["shell", "core"]
    mass = cloud.mass_properties([1000, 3000]).mass
    assert mass == pytest.approx(1000 * (8e-6 - 1e-6) + 3000 * 1e-6, rel=1e-6)


def test_the_device_gives_the_same_bits(box, box_cloud):
    if not cc.opencl_devices():
        pytest.skip("no OpenCL device")
    np.testing.assert_array_equal(cc.digitize(box, 0.001, backend="opencl").coverage, box_cloud.coverage)


def test_numbers_of_numpy_are_numbers():
    cloud = cc.digitize({"a": box_arrays(BOX)}, 0.001)
    numbers: Any = (np.float32(500), np.int64(500), np.float64(500))
    for density in numbers:
        assert cloud.mass_properties(density).mass == cloud.mass_properties(500).mass
    voxel: Any = np.float32(0.001)
    assert cc.digitize(box_arrays(BOX), voxel).voxel == float(voxel)


def test_names_of_files_that_are_no_text_are_told(tmp_path):
    name = os.path.join(tmp_path, os.fsdecode(b"\xff.cloud"))
    readers: Any = (cc.Cloud.load, cc.SurfaceField.load, cc.load_mesh, cc.Scene.load, lambda f: cc.digitize(f, 0.001))
    for read in readers:
        with pytest.raises((RuntimeError, ValueError)) as raised:
            read(name)
        assert name in str(raised.value)
    cc.digitize(box_arrays(BOX), 0.001).save(name)
    assert cc.digitize(name).voxels == cc.Cloud.load(name).voxels


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda: cc.Mesh([[0, 0, 0]], [[0, 1, 2]]), ValueError, "out of range|vertex|index"),
        (lambda: cc.Mesh([0, 0], [[0, 0, 0]]), ValueError, r"vertices: .*\(n, 3\)"),
        (lambda: cc.Mesh([[np.nan, 0, 0]], [[0, 0, 0]]), ValueError, "finite|NaN"),
        (lambda: cc.digitize("missing.stl", 0.001), ValueError, "missing.stl: no such file"),
        (lambda: cc.load_mesh("missing.stl"), RuntimeError, "missing.stl"),
        (lambda: cc.digitize(box_arrays(BOX), -1), ValueError, "voxel"),
        (lambda: cc.digitize(box_arrays(BOX), 1e-6, max_bytes=1000), ValueError, "voxel"),
        (lambda: cc.digitize(box_arrays(BOX), 0.001, unit="ell"), ValueError, "unit"),
        (lambda: cc.digitize(box_arrays(BOX), 0.001, backend="abacus"), ValueError, "backend"),
        (lambda: cc.digitize({}, 0.001), ValueError, "no mesh"),
        (lambda: cc.digitize(box_arrays(BOX), 0.001, shell=1e-3), ValueError, "shell"),
        (lambda: cc.digitize("sphere:0.01", 0), ValueError, "voxel"),
        (lambda: cc.digitize("sphere:0.01", 1e-4, max_bytes=1000), ValueError, "max_bytes"),
        (lambda: cc.digitize("sphere:0.01", 1e-3, thresholds={"a": 1}), ValueError, "thresholds"),
        (lambda: cc.digitize_volume(cc.CtVolume(np.ones((4, 4, 4)), [1, 1, 1]), np.nan), ValueError, "NaN"),
        (lambda: cc.digitize_volume(cc.CtVolume(np.ones((4, 4, 4)), [1, 1, 1]), "0"), TypeError, "thresholds"),  # type: ignore[arg-type]
        (lambda: cc.digitize(box_arrays(BOX), 0.001).mass_properties("light"), TypeError, "density|wrong type"),  # type: ignore[arg-type]
        (lambda: cc.digitize(3), TypeError, "digitize"),  # type: ignore[arg-type]
        (lambda: cc.Cloud.from_array(np.zeros((2, 2, 2)), 1), ValueError, "no voxel has material"),
        (lambda: cc.Cloud.from_array(np.full((2, 2, 2), 2.0), 1), ValueError, "0..1"),
        (lambda: cc.Cloud.from_array(np.ones((2, 2)), 1), ValueError, r"\(nx, ny, nz\)"),
        (lambda: cc.Cloud.from_array(np.ones((2, 2, 2)), -1), ValueError, "voxel"),
        (lambda: cc.Cloud.from_array(np.ones((2, 2, 2)), 1, material=np.ones((2, 2, 2)), materials=["a"]),
         ValueError, "material"),
        (lambda: cc.Cloud.from_array(np.ones((1, 1, 1)), 1, material=[[[256]]], materials=["a"]), ValueError, "0..255"),
        (lambda: cc.Mesh(box_arrays(BOX)[0], box_arrays(BOX)[1] + 0.5), ValueError, "triangles: .*whole"),
        (lambda: cc.Mesh(box_arrays(BOX)[0], box_arrays(BOX)[1] + 2**32), ValueError, "triangles: .*too large"),
        (lambda: cc.CtVolume(np.zeros(3), [1, 1, 1]), ValueError, r"\(nx, ny, nz\)"),
    ],
)  # fmt: skip
def test_bad_input_is_named(call, error, words):
    with pytest.raises(error, match=words):
        call()
