"""Values go to other processes, and come back equal."""

import concurrent.futures
import copy
import multiprocessing
import pickle

import numpy as np
import pytest
from conftest import box_arrays

import cloudcontact as cc

VALUES = [
    cc.KelvinVoigt(1e5, 20),
    cc.Foundation(1e9, 3),
    cc.Rigid(),
    cc.Maxwell(1e5, 20),
    cc.StandardLinearSolid(1e4, 2e4, 5),
    cc.HalfSpace((1, 2, 3), 0.1),
    cc.Sphere(0.1),
    cc.Box((1, 2, 3)),
    cc.Ellipsoid((1, 2, 3)),
    cc.Capsule(0.1, 0.2),
    cc.Cylinder(0.1, 0.2),
    cc.Cone(0.1, 0.2),
    cc.Pose((1, 2, 3), (0.1, 0.2, 0.3, 0.7)),
]


def passed(value):
    return pickle.loads(pickle.dumps(value))


def parts(value):
    names = [name for name in dir(type(value)) if isinstance(getattr(type(value), name), property)]
    return {name: np.asarray(getattr(value, name)).tolist() for name in names}


@pytest.mark.parametrize("value", VALUES, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize("way", [passed, copy.copy, copy.deepcopy])
def test_laws_solids_and_poses(way, value):
    other = way(value)
    assert other is not value and type(other) is type(value) and parts(other) == parts(value)
    assert repr(other) == repr(value)


def test_what_is_shown_makes_an_equal_value():
    for value in VALUES:
        made = parts(eval(repr(value), vars(cc)))
        for name, part in parts(value).items():
            np.testing.assert_allclose(made[name], part, atol=1e-5)
    assert repr(cc.KelvinVoigt(1e5, 20)) == "KelvinVoigt(stiffness=100000.0, damping=20.0)"
    assert repr(cc.Box((1, 2, 3))) == "Box(half_extents=(1.0, 2.0, 3.0))"


def test_tissues():
    for tissue in cc.dental_tissues():
        assert passed(tissue) == tissue


def test_meshes_and_volumes_have_memory_of_their_own():
    mesh = cc.Mesh(*box_arrays([0.04, 0.03, 0.02]))
    other = copy.copy(mesh)
    np.testing.assert_array_equal(passed(mesh).vertices, mesh.vertices)
    np.testing.assert_array_equal(passed(mesh).triangles, mesh.triangles)
    other.vertices[0, 0] = 7
    assert mesh.vertices[0, 0] != 7
    volume = cc.CtVolume(np.arange(24.0).reshape(2, 3, 4), [1, 2, 3], [4, 5, 6])
    scan = passed(volume)
    np.testing.assert_array_equal(scan.values, volume.values)
    assert parts(scan)["spacing"] == [1, 2, 3] and parts(scan)["origin"] == [4, 5, 6]


def force(field, pose, law):
    return cc.contact(field, field, pose, law=law).force


def test_a_process_finds_the_same_contact(box_cloud, box_field):
    other = passed(box_cloud)
    np.testing.assert_array_equal(other.coverage, box_cloud.coverage)
    assert other.voxel == box_cloud.voxel and copy.deepcopy(box_cloud).materials == box_cloud.materials
    pose, law = cc.Pose((0.003, 0.001, 0.005), (0.1, 0.2, 0, 0.9)), cc.KelvinVoigt(1e5, 20)
    with concurrent.futures.ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        there = pool.submit(force, box_field, pose, law).result()
    np.testing.assert_array_equal(there, force(box_field, pose, law))
    assert np.linalg.norm(there) > 1


def test_what_works_stays():
    for value in (cc.ContactFinder(), cc.ContactBatch()):
        with pytest.raises(TypeError, match="cannot pickle"):
            pickle.dumps(value)
