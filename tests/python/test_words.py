"""Errors speak Python's words, and name what was meant."""

import numpy as np
import pytest
from conftest import box_arrays, write_obj

import cloudcontact as cc


def scene(**words):
    made = cc.Scene("words")
    made.add("floor", cc.HalfSpace(), static=True, friction=0.5)
    made.add("brick", cc.Mesh(*box_arrays([0.04, 0.03, 0.02])), [0, 0, 0.02], mass=0.2, **words)
    return made


def test_unknown_keywords_are_named_with_the_nearest():
    with pytest.raises(TypeError, match="World.* 'frction'; did you mean 'friction'"):
        cc.World(scene(), voxel=0.002, frction=0.5)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="add.* 'mas'; did you mean 'mass'"):
        scene().add("x", cc.Sphere(1), mas=1)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="join.* 'axs'; did you mean 'axis'"):
        scene().join("revolute", "brick", axs=[0, 0, 1])  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="'colour'; it takes name, shape, pose"):
        scene().add("x", cc.Sphere(1), colour="red")  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"add\(\): an argument is missing"):
        scene().add("x")  # type: ignore[call-arg]


def test_errors_have_keywords_and_not_options_or_elements():
    with pytest.raises(ValueError, match="^method: 'gimpac'"):
        cc.World(scene(), voxel=0.002, method="gimpac")
    with pytest.raises(ValueError, match="^tissues: dentl"):
        cc.World(scene(), voxel=0.002, tissues="dentl")
    with pytest.raises(ValueError, match="^law: .* use method cloud"):
        cc.World(scene(), voxel=0.002, method="gimpact", law=cc.Maxwell(1e4, 10))
    with pytest.raises(ValueError, match="'brick' cuttable: its tissue is missing.* add a tissue"):
        cc.World(scene(cuttable=True), voxel=0.002)


def test_millimeters_read_as_meters_are_asked_about(tmp_path):
    file = tmp_path / "part.obj"
    write_obj(file, *box_arrays([40, 30, 20]))
    with pytest.raises(ValueError, match="40 m long as it is read: did you mean unit='mm'"):
        cc.digitize(file, 0.001)
    made = cc.Scene("in meters")
    made.add("part", str(file), mass=1)
    with pytest.raises(ValueError, match="'part'.* did you mean unit='mm'"):
        cc.World(made, voxel=0.001)
    assert cc.digitize(file, 0.001, unit="mm").mass_properties(1).volume == pytest.approx(2.4e-5, rel=0.01)
    write_obj(file, *box_arrays([40000, 30000, 20000]))  # forty meters, and no mistake
    with pytest.raises(ValueError) as raised:
        cc.digitize(file, 1e-3, unit="mm")
    assert "unit" not in str(raised.value)


def test_poses_take_points_of_any_shape():
    pose = cc.Pose.from_rotation_vector([0, 0, np.pi / 2], [1, 2, 3])
    points = np.random.default_rng(1).normal(size=(4, 5, 3))
    world = pose.to_world(points)
    assert world.shape == points.shape
    np.testing.assert_allclose(world[..., 0], 1 - points[..., 1])
    np.testing.assert_allclose(pose.to_local(world), points, atol=1e-12)
    np.testing.assert_allclose(pose.to_world([1, 0, 0]), [1, 3, 3], atol=1e-12)
    with pytest.raises(ValueError, match="local: give points"):
        pose.to_world(np.zeros((3, 2)))


def test_a_window_is_the_bodys_own():
    """A wide C rounds a block's edge: it pushes aside where the edge alone pushes straight."""

    def aside(**words):
        scene = cc.Scene(step=1e-3)
        block = cc.digitize(cc.Mesh(*box_arrays([0.02, 0.02, 0.02])), 0.001)
        scene.add("table", block, (0, 0, -0.01), static=True, **words)
        scene.add("block", block, (0.0185, 0, 0.0095), mass=0.1, stiffness=1e4)
        world = cc.World(scene, voxel=0.001)
        world.step()
        normals = world.contacts()["normal"]
        assert len(normals) > 0
        return np.abs(normals[:, 0]).mean()

    assert aside(window=cc.Sphere(0.004)) > aside() + 0.02


def test_soft_bodies_deform():
    scene = cc.Scene(step=1 / 240)
    gum = cc.Tissue("gum", stiffness=2000, damping=2, density=1000, elasticity=2e4)
    scene.add("table", cc.Box((0.05, 0.05, 0.005)), (0, 0, -0.005), static=True, tissue="gum")
    scene.add("gum", cc.Box((0.01, 0.01, 0.02)), (0, 0, 0.03), tissue="gum", soft=0.01, held="+z")
    world = cc.World(scene, voxel=0.002, tissues=[gum])
    start = world["gum"].position
    world.run(0.5)
    sunk = start[2] - world["gum"].position[2]
    # It hangs from its upper side: half of rho g L^2 / (2 E) in the mean, about.
    assert 1e-5 < sunk < 4e-4


def test_a_soft_body_that_cannot_be_joined_is_refused():
    made = cc.Scene()
    made.add("ball", cc.Sphere(0.01), mass=0.1)
    made.add("gum", cc.Box((0.01, 0.01, 0.02)), (0, 0, 0.1), tissue="gum", soft=0.01)
    made.join("ball", "gum", "ball")
    gum = cc.Tissue("gum", stiffness=2000, damping=2, density=1000, elasticity=2e4)
    with pytest.raises(ValueError, match="deforms"):
        cc.World(made, voxel=0.002, tissues=[gum])


@pytest.mark.parametrize(
    "words, what",
    [
        ({"soft": 0.01}, "tissue"),
        ({"soft": -1, "tissue": "gum"}, "soft"),
        ({"soft": 0.01, "tissue": "gum", "static": True}, "static"),
        ({"soft": 0.01, "tissue": "gum", "stiffness": 1e3}, "stiffness"),
        ({"soft": 0.01, "tissue": "gum", "window": cc.Sphere(0.01)}, "window"),
        ({"soft": 0.01, "tissue": "gum", "held": "up"}, "held"),
        ({"soft": 0.01, "tissue": "gum", "cuttable": True}, "cuts"),
        ({"held": "-z"}, "soft"),
        ({"window": cc.Cylinder(0.01, 0.01)}, "window"),
        ({"window": 0.01}, "window"),
        ({"tolerance": -1}, "tolerance"),
    ],
)
def test_what_a_body_cannot_be_is_named(words, what):
    with pytest.raises(ValueError, match=what):
        cc.Scene().add("body", cc.Box((0.01, 0.01, 0.01)), **words)
