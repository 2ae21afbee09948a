"""Many worlds of one scene."""

import numpy as np
import pytest
from conftest import box_arrays

import cloudcontact as cc

G = 9.81


def bricks():
    scene = cc.Scene("bricks", step=0.002)
    scene.add("floor", cc.HalfSpace(), static=True, friction=0.5)
    mesh = cc.Mesh(*box_arrays([0.04, 0.03, 0.02]))
    for i in range(3):
        scene.add(f"brick {i}", mesh, cc.Pose([0.01 * i, 0, 0.03 + 0.04 * i], [0.1 * i, 0.2, 0.3, 1]), mass=0.2, friction=0.5)
    return scene


def test_each_runs_as_a_world_by_itself():
    alone = cc.World(bricks(), voxel=0.002)
    worlds = cc.Worlds(bricks(), 5, voxel=0.002, threads=2)
    assert len(worlds) == 5 and worlds.names == alone.names
    brick = worlds.index("brick 1")
    worlds.forces[3, brick] = [0.5, 0, 0]
    positions = worlds.positions
    for step in range(150):
        worlds.step()
        alone.step()
        for i in (0, 1, 2, 4):
            assert worlds[i].hash == alone.hash, (step, i)
    np.testing.assert_array_equal(positions[0], alone.positions)  # the same memory all the time
    np.testing.assert_array_equal(worlds.orientations[4], alone.orientations)
    np.testing.assert_array_equal(worlds.velocities[4], alone.velocities)
    np.testing.assert_array_equal(worlds.angular_velocities[1], alone.angular_velocities)
    np.testing.assert_allclose(worlds.times, 0.3)
    assert worlds[3].hash != alone.hash
    assert positions[3, brick, 0] > positions[0, brick, 0] + 0.005


def test_one_thread_and_many_give_the_same_bits():
    def hashes(threads):
        worlds = cc.Worlds(bricks(), 4, voxel=0.002, threads=threads)
        for i in range(4):
            worlds.torques[i, worlds.index("brick 2")] = [0, 0, 0.001 * i]
        for _ in range(60):
            worlds.step(substeps=2)
        return [worlds[i].hash for i in range(4)]

    assert hashes(1) == hashes(3)


def test_worlds_go_back_by_number_and_by_mask():
    worlds = cc.Worlds(bricks(), 4, voxel=0.002)
    start = worlds.positions.copy()
    for _ in range(40):
        worlds.step()
    later, states = worlds.positions.copy(), worlds.save()
    worlds.forces[:, worlds.index("brick 0"), 2] = 1
    worlds.reset(2)
    np.testing.assert_array_equal(worlds.positions[2], start[2])
    np.testing.assert_array_equal(worlds.positions[[0, 1, 3]], later[[0, 1, 3]])
    assert worlds.times[2] == 0 and worlds.forces[2].sum() == 0 and worlds.forces[1].sum() == 1
    worlds.reset(np.array([True, False, False, True]))
    assert (worlds.times == [0, pytest.approx(0.08), 0, 0]).all()
    worlds.restore([states[3], states[1]], [0, 3])
    np.testing.assert_array_equal(worlds.positions[[0, 3]], later[[3, 1]])
    worlds.reset()
    np.testing.assert_array_equal(worlds.positions, start)
    worlds.restore(states)
    np.testing.assert_array_equal(worlds.positions, later)
    worlds[1]["brick 2"].pose = cc.Pose([0, 0, 1])
    worlds.read()
    assert worlds.positions[1, worlds.index("brick 2"), 2] == 1


def test_wrenches_hold_the_weight():
    scene = cc.Scene("rest", step=0.001)
    scene.add("floor", cc.HalfSpace(), static=True, friction=0.5)
    scene.add("brick", cc.Mesh(*box_arrays([0.04, 0.03, 0.02])), [0, 0, 0.0101], mass=0.2, friction=0.5)
    worlds = cc.Worlds(scene, 2, voxel=0.002)
    brick, floor = worlds.index("brick"), worlds.index("floor")
    worlds.torques[1, brick] = [0, 0.005, 0]
    for _ in range(400):
        worlds.step()
    wrenches = worlds.contact_wrenches()
    assert wrenches.shape == (2, 2, 6)
    np.testing.assert_allclose(wrenches[:, brick, :3], [[0, 0, 0.2 * G]] * 2, atol=0.02)
    np.testing.assert_allclose(wrenches[:, floor, :3], -wrenches[:, brick, :3])
    np.testing.assert_allclose(wrenches[1, brick, 3:], [0, -0.005, 0], atol=3e-4)


def test_what_does_not_fit_is_refused():
    worlds = cc.Worlds(bricks(), 2, voxel=0.002)
    state = worlds.save(0)
    with pytest.raises(IndexError, match="no world 2 of 2"):
        worlds.reset(2)
    with pytest.raises(IndexError, match="no world 2 of 2"):
        worlds[2]
    with pytest.raises(ValueError, match="mask has 3 values for 2"):
        worlds.reset(np.array([True, False, True]))
    with pytest.raises(ValueError, match="1 for 2 worlds"):
        worlds.restore(state)
    with pytest.raises(ValueError, match="substeps"):
        worlds.step(substeps=0)
    with pytest.raises(ValueError, match="count"):
        cc.Worlds(bricks(), 0, voxel=0.002)
    with pytest.raises(ValueError, match="backend"):
        cc.Worlds(bricks(), 2, voxel=0.002, backend="opencl")
    with pytest.raises(KeyError, match="lid"):
        worlds.index("lid")
    with pytest.raises(ValueError, match="read-only"):
        worlds.positions[0] = 0
    worlds.forces[1, worlds.index("floor")] = [0, 0, 1]
    with pytest.raises(ValueError, match="world 1: body 'floor'"):
        worlds.step()
