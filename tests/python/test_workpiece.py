"""The paper's workpiece: base vectors, collisions, cutting, haptics."""

import numpy as np
import pytest
from conftest import box_arrays

import cloudcontact as cc

VOXEL = 0.0005
TOP = 0.006  # z of the block's upper face
STEEL = cc.Tissue("steel", stiffness=2000, damping=1, hardness=1e9, density=7800)


@pytest.fixture
def block():
    return cc.BaseVectorField(cc.digitize(box_arrays([0.02, 0.02, 2 * TOP]), VOXEL), [STEEL])


def voxel_at(field, point):
    return np.floor((np.asarray(point) - field.origin) / field.voxel).astype(int)


def test_base_vectors_point_outward(block):
    vectors, share = block.at([voxel_at(block, [0, 0, TOP - 0.1 * VOXEL]), voxel_at(block, [0, 0, 0])])
    outward = vectors[0] / np.linalg.norm(vectors[0])
    np.testing.assert_allclose(outward, [0, 0, 1], atol=0.01)
    assert 0.3 < share[0] < 0.9
    np.testing.assert_allclose(vectors[1], 0, atol=1e-12)
    assert share[1] == pytest.approx(1)


def test_a_cut_field_equals_one_of_the_cut_cloud(block):
    before = block.mass_properties().mass
    changed = block.cut_area(cc.Sphere(0.003), [0, 0, TOP])
    assert changed > 100
    gone = (before - block.mass_properties().mass) / STEEL.density
    assert gone == pytest.approx(2 / 3 * np.pi * 0.003**3, rel=0.02)
    assert cc.BaseVectorField(block.cloud(), [STEEL]).hash == block.hash
    voxel = voxel_at(block, [0.005, 0.005, 0])
    assert block.coverage([voxel])[0] == 255
    assert block.cut([voxel], 100) == 1 and block.coverage([voxel])[0] == 100
    with pytest.raises(IndexError):
        block.cut([[-1, 0, 0]])


def test_a_collision_by_the_equations(block):
    tool = cc.Detection(cc.Sphere(0.004))
    depth = 0.001
    found = cc.CollisionFinder().find(block, tool, [0, 0, TOP + 0.004 - depth])
    assert found
    np.testing.assert_allclose(found.normal, [0, 0, 1], atol=0.01)
    assert found.depth == pytest.approx(depth, abs=0.15 * VOXEL)
    cap = np.pi * depth**2 * (3 * 0.004 - depth) / 3
    assert found.volume == pytest.approx(cap, rel=0.05)
    assert found.stiffness == pytest.approx(STEEL.stiffness)
    assert found.damping == pytest.approx(STEEL.damping)
    assert found.voxels["share"].sum() == pytest.approx(found.count, rel=1e-5)
    assert not cc.CollisionFinder().find(block, tool, [0, 0, 0.02])


def test_cutting_removes_by_archards_law(block):
    cutter = cc.Cutter(hardness=17e9, efficiency=0.1, edge_speed=10)
    found = cc.CollisionFinder().find(block, cc.Detection(cc.Sphere(0.004)), [0, 0, TOP + 0.003])
    process = cc.CuttingProcess(cutter)
    volume = sum(process.step(block, found, force=20, speed=0, seconds=1e-3)[1] for _ in range(20))
    expected = 0.1 * 20 * 10 * 0.02 / STEEL.hardness
    assert volume == pytest.approx(expected, rel=0.05)


def test_a_haptic_loop_pushes_back(block):
    tool = cc.Detection(cc.Sphere(0.003))
    loop = cc.HapticLoop(block, tool, hand_stiffness=1000)
    assert np.linalg.norm(loop.tick([0, 0, TOP + 0.01]).force) == 0
    pressed = 0.001
    out = cc.HapticLoop(block, tool).tick([0, 0, 1])
    for z in np.linspace(TOP + 0.004, TOP + 0.003 - pressed, 400):
        out = loop.tick([0, 0, z])
    # Two springs in series: the hand's and the material's.
    expected = pressed / (1 / 1000 + 1 / STEEL.stiffness)
    assert out.force[2] == pytest.approx(expected, rel=0.03)
    assert out.depth == pytest.approx(expected / STEEL.stiffness, rel=0.05)
    assert out.tool.position[2] > TOP + 0.003 - pressed
    assert out.least_energy > -1e-6


def test_a_run_equals_its_ticks():
    def loop():
        field = cc.BaseVectorField(cc.digitize(box_arrays([0.02, 0.02, 0.012]), VOXEL), [STEEL])
        tool = cc.Detection(cc.Sphere(0.002), depth="nearest")
        return field, cc.HapticLoop(field, tool, cutter=cc.Cutter(edge_speed=50, efficiency=0.5))

    n = 300
    hand = np.zeros((n, 3))
    hand[:, 0] = np.linspace(-0.004, 0.004, n)
    hand[:, 2] = TOP + 0.0015 - 0.0008 * np.linspace(0, 1, n)
    (field_a, one), (field_b, many) = loop(), loop()
    ticks = [one.tick(h) for h in hand]
    run = many.run(hand)
    np.testing.assert_array_equal(run["force"], [t.force for t in ticks])
    np.testing.assert_array_equal(run["depth"], [t.depth for t in ticks])
    assert run["cut_volume"].sum() > 0 and field_a.hash == field_b.hash


def test_the_loop_keeps_its_workpiece():
    loop = cc.HapticLoop(
        cc.BaseVectorField(cc.digitize(box_arrays([0.02, 0.02, 0.012]), 0.001), [STEEL]), cc.Detection(cc.Sphere(0.003))
    )
    assert loop.tick([0, 0, TOP + 0.001]).force[2] > 0


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda b: cc.BaseVectorField(b.cloud(), []), "tissue"),
        (lambda b: cc.Detection(cc.Sphere(0)), "radius"),
        (lambda b: cc.Detection(cc.Sphere(1), membership="some"), "membership"),
        (lambda b: cc.HapticLoop(b, cc.Detection(cc.Sphere(1e-3)), step=-1), "step"),
        (lambda b: cc.HapticLoop(b, cc.Detection(cc.Sphere(1e-3))).run(np.zeros((3, 2))), r"\(n, 7\)"),
        (lambda b: cc.HapticLoop(b, cc.Detection(cc.Sphere(1e-3))).tick([0, 0, 1], [0, np.nan, 0]), "velocity"),
        (lambda b: cc.HapticLoop(b, cc.Detection(cc.Sphere(1e-3))).run(np.zeros((1, 3)), [[0, np.inf, 0]]), "velocity"),
        (lambda b: cc.Detection(cc.Sphere(1), ability=np.nan), "ability"),
        (lambda b: cc.Cutter(efficiency=-1), "efficiency"),
        (lambda b: b.at([[0, 0]]), r"voxels: .*\(n, 3\)"),
        (lambda b: b.cut([[0, 0, 0]], 300), "0..255"),
    ],
)
def test_bad_input_is_named(call, words, block):
    with pytest.raises(ValueError, match=words):
        call(block)
