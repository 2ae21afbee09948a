"""What tests of the Python package share: meshes in closed form, a study that has run."""

import os

import numpy as np
import pytest

import cloudcontact as cc

os.environ.setdefault("CLOUDCONTACT_CACHE", "off")  # worlds leave the user's cache alone


def box_arrays(size):
    """A box about the origin: vertices (8, 3), triangles (12, 3)."""
    half = np.asarray(size, float) / 2
    vertices = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) * half
    triangles = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
                 [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]  # fmt: skip
    return vertices, np.array(triangles, np.int32)


def write_obj(path, vertices, triangles):
    lines = ["v %.9g %.9g %.9g" % tuple(v) for v in vertices]
    lines += ["f %d %d %d" % tuple(t + 1) for t in triangles]
    path.write_text("\n".join(lines) + "\n")


@pytest.fixture(scope="session")
def box():
    return cc.Mesh(*box_arrays([0.02, 0.016, 0.012]))


@pytest.fixture(scope="session")
def box_cloud(box):
    return cc.digitize(box, 0.001)


@pytest.fixture(scope="session")
def box_field(box_cloud):
    return cc.SurfaceField(box_cloud)


@pytest.fixture(scope="session")
def ball_field():
    return cc.SurfaceField(cc.digitize("sphere:0.01", 0.0005))


@pytest.fixture(scope="session")
def pegs(tmp_path_factory):
    """The study of 24 pegs, run once, and its results."""
    from study_samples import write_pegs

    from cloudcontact import study

    folder = tmp_path_factory.mktemp("pegs")
    made = study.load(write_pegs(folder))
    return made, made.run(folder / "pegs.sqlite", "local:2", progress=False)
