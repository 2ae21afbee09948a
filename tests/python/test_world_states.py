"""States of running worlds, copies, what worlds share, and what a run changes of bodies."""

import copy
import pickle

import numpy as np
import pytest
from conftest import box_arrays
from test_world import G, resting

import cloudcontact as cc

WOOD = [cc.Tissue("wood", stiffness=1e5, damping=10, hardness=1e6, density=700)]


def heap():
    scene = cc.Scene("heap", step=0.002)
    scene.add("floor", cc.HalfSpace(), static=True, friction=0.5)
    mesh = cc.Mesh(*box_arrays([0.04, 0.03, 0.02]))
    for i in range(6):
        pose = cc.Pose([0.01 * (i % 2), 0.008 * (i % 3), 0.04 + 0.04 * i], [0.1 * i, 0.2, 0.3, 1])
        scene.add(f"brick {i}", mesh, pose, mass=0.1 + 0.05 * i, friction=0.5)
    return scene


def hashes(world, steps):
    seen = []
    for _ in range(steps):
        world.step()
        seen.append(world.hash)
    return seen


def test_a_world_goes_back_to_its_states_and_on_from_there():
    world = cc.World(heap(), voxel=0.002)
    states, seen = [], []
    for step in range(200):
        if step % 20 == 0:
            states.append(world.save())
            if step == 60:
                world["brick 2"].applied_force = np.array([0.0, 0, 1])
        seen += hashes(world, 1)
    assert len(world.contacts()) > 10 and 0 < states[3].nbytes < 200_000
    energy = world.energy
    for k in (3, 0, 9, 4, 3):
        world.restore(states[k])
        assert world.time == pytest.approx(20 * k * 0.002) == states[k].time
        if k < 3:  # until it is pushed
            assert hashes(world, 60 - 20 * k) == seen[20 * k : 60]
        if k <= 3:
            world["brick 2"].applied_force = np.array([0.0, 0, 1])
        assert hashes(world, 200 - 20 * max(k, 3)) == seen[20 * max(k, 3) :]
    assert world.energy == energy
    np.testing.assert_array_equal(world["brick 2"].applied_force, [0, 0, 1])
    world.restore(states[0])
    np.testing.assert_array_equal(world["brick 2"].applied_force, [0, 0, 0])


def test_copies_of_a_world_go_on_by_themselves():
    world = cc.World(heap(), voxel=0.002)
    hashes(world, 80)
    twin, third = world.copy(), copy.deepcopy(world)
    assert twin.hash == world.hash and twin.time == world.time and twin.names == world.names
    np.testing.assert_array_equal(twin.contacts(), world.contacts())
    seen = hashes(world, 60)
    assert hashes(twin, 60) == seen == hashes(third, 60)
    state = pickle.loads(pickle.dumps(third.save()))
    seen = hashes(world, 10)
    other = cc.World(heap(), voxel=0.002)
    other.restore(state)
    assert hashes(other, 10) == seen


def test_states_of_other_worlds_and_of_cut_bodies_are_refused():
    world = cc.World(heap(), voxel=0.002)
    with pytest.raises(ValueError, match="2 bodies, and the world has 7"):
        world.restore(cc.World(resting(), voxel=0.002).save())
    cut = cc.World(resting(cuttable=True, tissue="wood"), voxel=0.002, tissues=WOOD)
    state = cut.save()
    cut.restore(state)
    cut["brick"].cut([[5, 5, 5]])
    with pytest.raises(ValueError, match="'brick': was cut since"):
        cut.restore(state)
    with pytest.raises(TypeError):
        world.restore(b"none")  # type: ignore[arg-type]


def test_fields_are_kept_for_the_next_world(tmp_path, monkeypatch):
    monkeypatch.setenv("CLOUDCONTACT_CACHE", str(tmp_path))
    voxel = 0.0019  # no other test's: worlds that live at the same time share
    first = cc.World(resting(), voxel, cache=False)
    assert not list(tmp_path.iterdir())
    second = cc.World(resting(), voxel)
    kept = sorted(tmp_path.rglob("*"))
    assert kept
    third = cc.World(resting(), voxel)
    assert sorted(tmp_path.rglob("*")) == kept
    assert hashes(first, 50) == hashes(second, 50) == hashes(third, 50)


def slope(friction):
    scene = cc.Scene("slope", gravity=(G * np.sin(0.3), 0, -G * np.cos(0.3)), step=0.002)
    scene.add("floor", cc.HalfSpace(), static=True, friction=1.0)
    scene.add("brick", cc.Mesh(*box_arrays([0.04, 0.03, 0.02])), [0, 0, 0.01], mass=0.2, friction=friction)
    return scene


def velocities(linear, angular=(0, 0, 0)):
    return np.array(linear, float), np.array(angular, float)


def test_friction_set_in_a_run_holds_from_then_on():
    world = cc.World(slope(0.5), voxel=0.002)
    brick = world["brick"]
    assert brick.friction == 0.5 and brick.stiffness is None and brick.drive is None
    hashes(world, 200)
    assert abs(brick.velocity).max() < 1e-3
    brick.friction = 0.1
    start = brick.velocity[0]
    hashes(world, 100)
    slides = G * (np.sin(0.3) - 0.1 * np.cos(0.3))
    assert brick.velocity[0] - start == pytest.approx(0.2 * slides, rel=0.03)
    brick.friction = None  # the floor's
    hashes(world, 300)
    assert abs(brick.velocity).max() < 1e-3


def test_mass_and_spring_set_in_a_run_hold_from_then_on():
    scene = resting(stiffness=2e4, damping=50)
    world = cc.World(scene, voxel=0.002)
    brick = world["brick"]
    assert (brick.stiffness, brick.damping, brick.mass) == (2e4, 50, pytest.approx(0.2))
    hashes(world, 500)
    first = brick.position[2]
    assert world.contacts()["force"][:, 2].sum() * np.sign(brick.index - 0.5) == pytest.approx(0.2 * G, rel=0.01)
    brick.mass = 0.8
    hashes(world, 800)
    second = brick.position[2]
    assert first - second == pytest.approx(0.6 * G / 2e4, rel=0.03)
    brick.stiffness = 8e4
    hashes(world, 800)
    assert brick.position[2] - second == pytest.approx(0.8 * G * (1 / 2e4 - 1 / 8e4), rel=0.03)
    brick.applied_torque = np.array([0, 0, 0.0])
    with pytest.raises(ValueError, match="'brick': mass: must be"):
        brick.mass = -1
    with pytest.raises(ValueError, match="'floor': its mass cannot be set"):
        world["floor"].mass = 1
    with pytest.raises(ValueError, match="'brick': its drive cannot be set"):
        brick.drive = velocities([0, 0, 1])
    with pytest.raises(ValueError, match="restitution"):
        brick.restitution = 2
    brick.stiffness = None
    with pytest.raises(ValueError, match="needs a stiffness"):
        brick.damping = 5
    assert brick.mass == pytest.approx(0.8)


def test_a_drive_goes_on_from_where_it_is_and_comes_back_with_a_state():
    scene = cc.Scene("belt", step=0.002)
    scene.add("belt", cc.Box((0.2, 0.1, 0.01)), (0, 0, -0.01), drive=((0.1, 0, 0), (0, 0, 0)), friction=0.8)
    scene.add("brick", cc.Mesh(*box_arrays([0.04, 0.03, 0.02])), [0, 0, 0.0101], mass=0.2, friction=0.8)
    world = cc.World(scene, voxel=0.002)
    hashes(world, 200)
    assert world["belt"].position[0] == pytest.approx(0.04)
    assert world["brick"].velocity[0] == pytest.approx(0.1, abs=1e-3)
    world["belt"].drive = velocities([0, 0.05, 0])
    drive = world["belt"].drive
    assert drive is not None and drive[0][1] == 0.05
    hashes(world, 100)
    np.testing.assert_allclose(world["belt"].position, [0.04, 0.01, -0.01], atol=1e-9)
    state = world.save()
    seen = hashes(world, 50)
    assert world["brick"].velocity[1] == pytest.approx(0.05, abs=1e-3)
    world["belt"].drive = velocities([0, 0, 0], [0, 0, 1])
    hashes(world, 50)
    world.restore(pickle.loads(pickle.dumps(state)))
    assert hashes(world, 50) == seen


def test_fields_that_are_made_already_are_bodies():
    cloud = cc.digitize(cc.Mesh(*box_arrays([0.04, 0.03, 0.02])), 0.002)
    field = cc.SurfaceField(cloud)

    def world(shape):
        scene = cc.Scene("two", step=0.002)
        scene.add("floor", cc.HalfSpace(), static=True, friction=0.5)
        for i in range(2):
            scene.add(f"brick {i}", shape, (0.01 * i, 0, 0.011 + 0.03 * i), mass=0.2, friction=0.5)
        return cc.World(scene)

    made, given = world(cloud), world(field)
    assert hashes(made, 100) == hashes(given, 100)
    np.testing.assert_allclose(given["brick 0"].position[2], 0.01, atol=5e-4)
