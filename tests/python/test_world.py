"""Scenes of files and by hand, running worlds."""

import gc
import json
import os
import subprocess

import numpy as np
import pytest
from conftest import box_arrays, write_obj

import cloudcontact as cc

G = 9.81
PROGRAM = os.environ.get("CLOUDCONTACT_EXECUTABLE")
FALL = """<sdf version="1.9"><world name="fall"><gravity>0 0 -9.81</gravity>
<physics name="p" type="bullet"><max_step_size>0.002</max_step_size><real_time_factor>0</real_time_factor></physics>
<model name="floor"><static>true</static><link name="l"><collision name="c">
<geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
<model name="brick"><pose>0 0 0.03 0.3 0.2 0.1</pose><link name="l"><inertial><mass>0.2</mass></inertial>
<collision name="c"><geometry><mesh><uri>brick.obj</uri></mesh></geometry>
<surface><friction><ode><mu>0.5</mu></ode></friction></surface></collision></link></model></world></sdf>"""
ROBOT = """<robot name="arm"><link name="world"/>
<link name="base"><inertial><mass value="2"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
<collision><geometry><box size="0.1 0.1 0.02"/></geometry></collision></link>
<link name="lever"><inertial><origin xyz="0.1 0 0"/><mass value="0.5"/>
<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial>
<collision><origin xyz="0.1 0 0"/><geometry><mesh filename="package://parts/brick.obj"/></geometry></collision></link>
<joint name="stand" type="fixed"><parent link="world"/><child link="base"/><origin xyz="0 0 0.01"/></joint>
<joint name="hinge" type="revolute"><parent link="base"/><child link="lever"/><origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""


def resting(**words):
    scene = cc.Scene("rest", step=0.001)
    scene.add("floor", cc.HalfSpace(), static=True, friction=0.5)
    scene.add("brick", cc.Mesh(*box_arrays([0.04, 0.03, 0.02])), [0, 0, 0.0101], mass=0.2, friction=0.5, **words)
    return scene


def test_a_brick_comes_to_rest_and_presses_with_its_weight():
    world = cc.World(resting(), voxel=0.002)
    seen = []
    world.run(0.5, observe=lambda w: seen.append(w.time))
    assert len(seen) == 500 and seen[-1] == pytest.approx(0.5)
    brick = world["brick"]
    assert brick.position[2] == pytest.approx(0.01, abs=0.0005)
    np.testing.assert_allclose(brick.velocity, 0, atol=1e-3)
    contacts = world.contacts()
    assert len(contacts) >= 3
    assert {world.names[i] for i in (*contacts["a"], *contacts["b"])} == {"floor", "brick"}
    sign = np.where(contacts["b"] == brick.index, 1, -1)[:, None]
    np.testing.assert_allclose((sign * contacts["force"]).sum(axis=0), [0, 0, 0.2 * G], atol=0.02)
    np.testing.assert_allclose(np.abs(contacts["normal"] @ [0, 0, 1]), 1, atol=0.01)
    assert world.penetration() < 0.0005
    assert world.energy["kinetic"] < 1e-6
    assert len(world) == 2 and world.positions.shape == (2, 3)
    np.testing.assert_array_equal(world.positions[brick.index], brick.position)


def test_a_static_shape_stays_exact():
    scene = cc.Scene("shapes", step=0.001)
    scene.add("floor", cc.Box((1, 1, 0.1)), [0, 0, -0.1], static=True, friction=0.5)
    scene.add("cone", cc.Cone(0.06, 0.03), [0.3, 0, 0.03], static=True, friction=0.5)
    scene.add("brick", cc.Mesh(*box_arrays([0.04, 0.03, 0.02])), [0, 0, 0.0101], mass=0.2, friction=0.5)
    scene.add("ball", cc.Sphere(0.02), [0.3, 0, 0.0801], mass=0.2, friction=0.5)
    world = cc.World(scene, voxel=0.002)  # a minute with voxels of the floor
    world.run(0.1)
    sag = 0.1 * 0.002  # of the automatic spring: a tenth of a voxel
    assert world["brick"].position[2] == pytest.approx(0.01 - sag, abs=4e-5)
    assert world["ball"].position[2] == pytest.approx(0.08 - sag, abs=2e-4)  # on the tip


def test_free_fall_and_velocities():
    scene = cc.Scene(gravity=[0, 0, -G], step=0.001)
    scene.add("ball", cc.Sphere(0.01), [0, 0, 1], mass=0.1, velocity=[0.5, 0, 0], angular_velocity=[0, 0, 3])
    world = cc.World(scene, voxel=0.002)
    world.run(0.2)
    np.testing.assert_allclose(world["ball"].velocity, [0.5, 0, -G * 0.2], rtol=1e-3, atol=1e-6)
    np.testing.assert_allclose(world["ball"].position, [0.1, 0, 1 - G * 0.2**2 / 2], atol=2e-3)
    np.testing.assert_allclose(world["ball"].angular_velocity, [0, 0, 3], atol=1e-3)
    assert world.energy["bodies"] == pytest.approx(world.energy["kinetic"] + world.energy["potential"])


def floating():
    """A block of 0.1 x 0.08 x 0.06 m and 1 kg in no gravity, whose frame is 0.2 m beside its center."""
    vertices, triangles = box_arrays([0.1, 0.08, 0.06])
    scene = cc.Scene(gravity=[0, 0, 0], step=0.001)
    scene.add("block", cc.Mesh(np.asarray(vertices) + [0.2, 0, 0], triangles), [0, 0, 1], mass=1)
    return cc.World(scene, voxel=0.004)


def test_forces_and_torques_that_are_applied():
    world = floating()
    block = world["block"]
    block.applied_force, block.applied_torque = np.array([2.0, 0, -3]), np.array([0, 0, 0.01])
    np.testing.assert_array_equal(block.applied_force, [2, 0, -3])
    world.run(0.1)
    spin = 0.01 * 0.1 / (1 / 12 * (0.1**2 + 0.08**2))
    np.testing.assert_allclose(block.angular_velocity, [0, 0, spin], rtol=0.01)
    # Of the frame's origin, 0.2 m from the center of mass.
    turned = spin * 0.1 / 2
    arm = -0.2 * np.array([np.cos(turned), np.sin(turned), 0])
    np.testing.assert_allclose(block.velocity, np.array([0.2, 0, -0.3]) + np.cross([0, 0, spin], arm), atol=2e-3)
    block.applied_force = block.applied_torque = np.zeros(3)
    before = block.angular_velocity
    world.run(0.1, substeps=2)
    np.testing.assert_allclose(block.angular_velocity, before, rtol=1e-3)


def test_a_force_holds_the_weight():
    world = cc.World(resting(), voxel=0.002)
    brick = world["brick"]
    brick.pose = cc.Pose([0, 0, 0.05])
    brick.applied_force = np.array([0, 0, 0.2 * G])
    world.run(0.3)
    np.testing.assert_allclose(brick.position, [0, 0, 0.05], atol=1e-5)
    assert len(world.contacts()) == 0


def test_velocities_that_are_set():
    world = floating()
    block = world["block"]
    block.velocity, block.angular_velocity = np.array([1.0, 2, 3]), np.array([0.0, 0, 4])
    np.testing.assert_allclose(block.velocity, [1, 2, 3], rtol=1e-6)
    np.testing.assert_allclose(block.angular_velocity, [0, 0, 4], rtol=1e-6)
    world.step()
    # The center of mass is 0.2 m along x.
    np.testing.assert_allclose(block.position + block.pose.matrix[:3, :3] @ [0.2, 0, 0],
                               np.array([0.2, 0, 1]) + 1e-3 * np.array([1, 2 + 0.8, 3]), atol=1e-6)  # fmt: skip


def test_a_body_put_back_starts_as_a_new_one():
    new, used = (cc.World(resting(), voxel=0.002) for _ in range(2))
    brick = used["brick"]
    start = brick.pose
    used.run(0.2)
    assert len(used.contacts()) > 0
    brick.pose = cc.Pose([0, 0, 0.5])
    used.step()
    assert len(used.contacts()) == 0
    brick.pose, brick.angular_velocity, brick.velocity = start, np.zeros(3), np.zeros(3)
    assert used.hash == new.hash
    for world in (new, used):
        world.run(0.1)
    assert used.hash == new.hash


def test_a_stated_spring_sags_by_the_weight():
    scene = resting(stiffness=2000, damping=20)
    world = cc.World(scene, voxel=0.001)
    world.run(1.0)
    assert world["brick"].position[2] == pytest.approx(0.01 - 0.2 * G / 2000, abs=1e-4)


def test_runs_are_equal_to_the_bit():
    hashes = []
    for threads in (1, 1, 3):
        world = cc.World(resting(), voxel=0.002, threads=threads)
        world.run(0.1)
        hashes.append(world.hash)
    assert len(set(hashes)) == 1


def test_a_file_runs_as_the_program_runs_it(tmp_path):
    write_obj(tmp_path / "brick.obj", *box_arrays([0.03, 0.02, 0.01]))
    (tmp_path / "fall.sdf").write_text(FALL)
    world = cc.World(tmp_path / "fall.sdf", voxel=0.001)
    assert world.names == ["floor", "brick"]
    world.run(0.2)
    if PROGRAM is None:
        pytest.skip("CLOUDCONTACT_EXECUTABLE is not set")
    words = [PROGRAM, "simulate", tmp_path / "fall.sdf", "--voxel", "0.001", "--seconds", "0.2", "--json"]
    report = json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)
    assert world.hash == int(report["hash"], 16)
    np.testing.assert_allclose(world["brick"].position, report["bodies"][1]["position"], rtol=1e-12)


def test_a_robot_of_urdf_swings_on_its_hinge(tmp_path):
    (tmp_path / "parts").mkdir()
    write_obj(tmp_path / "parts" / "brick.obj", *box_arrays([0.2, 0.02, 0.02]))
    (tmp_path / "arm.urdf").write_text(ROBOT)
    scene = cc.Scene.load(tmp_path / "arm.urdf")
    assert scene.name == "arm" and len(scene.joints) >= 1
    world = cc.World(scene, voxel=0.005)
    lever = next(n for n in world.names if "lever" in n)
    world.run(0.05, step=0.001)
    # A bar of inertia I about the hinge falls with m g l / I.
    inertia = 1e-3 + 0.5 * 0.1**2
    assert world[lever].angular_velocity[1] == pytest.approx(0.5 * 9.8 * 0.1 / inertia * 0.05, rel=0.05)


GRIPPER = """<robot name="gripper"><link name="world"/>
<link name="table"><collision><geometry><box size="0.1 0.1 0.02"/></geometry></collision></link>
<link name="tool"><collision><geometry><box size="0.02 0.02 0.02"/></geometry></collision></link>
<link name="pad"><collision><geometry><box size="0.01 0.01 0.01"/></geometry></collision></link>
<joint name="stand" type="fixed"><parent link="world"/><child link="table"/></joint>
<joint name="lift" type="prismatic"><parent link="table"/><child link="tool"/><origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="9" velocity="9"/><dynamics damping="0.016" friction="0"/></joint>
<joint name="glue" type="fixed"><parent link="tool"/><child link="pad"/><origin xyz="0 0 -0.015"/></joint></robot>"""


def test_links_of_a_robot_without_a_mass_have_that_of_their_voxels(tmp_path):
    (tmp_path / "g.urdf").write_text(GRIPPER)
    world = cc.World(tmp_path / "g.urdf", voxel=0.001)
    assert len(world) == 2
    tool = world[next(n for n in world if "tool" in n)]
    assert tool.mass == pytest.approx(1000 * (0.02**3 + 0.01**3), rel=1e-3)
    # Damping c brings the fall of m to m g / c, with the time m / c.
    world.run(0.05)
    m, c = tool.mass, 0.016
    assert tool.velocity[2] == pytest.approx(-m * 9.8 / c * (1 - np.exp(-0.05 * c / m)), rel=0.01)


def test_a_link_of_a_robot_without_mass_and_matter_is_named(tmp_path):
    (tmp_path / "g.urdf").write_text(GRIPPER.replace("<collision>", "<visual>").replace("</collision>", "</visual>"))
    with pytest.raises(ValueError, match="g.urdf: link 'table': has neither <inertial> nor <collision>"):
        cc.Scene.load(tmp_path / "g.urdf")


def test_what_stands_on_a_body_that_is_moved_away_falls():
    scene = resting()
    scene.add("upper", cc.Mesh(*box_arrays([0.04, 0.03, 0.02])), [0, 0, 0.0301], mass=0.2, friction=0.5)
    world = cc.World(scene, voxel=0.002, sleep=True)
    for _ in range(50):
        world.run(0.1)
        if world["upper"].asleep and world["brick"].asleep:
            break
    assert world["upper"].asleep
    world["brick"].pose = cc.Pose([1, 0, 0.01])
    world.run(0.3)
    assert world["upper"].position[2] == pytest.approx(0.01, abs=1e-3)


def test_names_of_bodies_are_looked_up():
    world = cc.World(resting(), voxel=0.004)
    assert "brick" in world and "ghost" not in world and list(world) == world.names == ["floor", "brick"]


def test_joints_by_hand():
    scene = cc.Scene(gravity=[0, 0, 0], step=0.001)
    bar = cc.Mesh(*box_arrays([0.2, 0.02, 0.02]))
    scene.add("wheel", bar, mass=1, angular_velocity=[0, 0, 2])
    scene.add("slide", bar, [0, 0.5, 0], mass=1, velocity=[0, 0, 0.1])
    scene.join("revolute", "wheel", axis=[0, 0, 1])
    scene.join("prismatic", "slide", position=[0, 0.5, 0], axis=[0, 0, 1], lower=-0.005, upper=0.005)
    world = cc.World(scene, voxel=0.005)
    world.run(0.3)
    np.testing.assert_allclose(world["wheel"].position, 0, atol=1e-4)
    assert world["wheel"].angular_velocity[2] == pytest.approx(2, rel=0.02)
    assert world["slide"].position[2] < 0.0052


def test_voxels_of_an_array_fall_on_a_mesh():
    scene = resting()
    ct = np.ones((12, 12, 12))
    cloud = cc.Cloud.from_array(ct, 0.001, [-0.006] * 3)
    scene.add("cube", cloud, [0, 0, 0.0262], mass=0.05, friction=0.5)
    world = cc.World(scene, voxel=0.001)
    world.run(0.4)
    assert world["cube"].position[2] == pytest.approx(0.026, abs=0.0006)


def test_a_tissue_is_cut_by_a_driven_tool():
    scene = cc.Scene(gravity=[0, 0, 0], step=0.002)
    block = cc.Mesh(*box_arrays([0.02, 0.02, 0.01]))
    scene.add("block", block, static=True, cuttable=True, tissue="gum")
    cutter = cc.Cutter(hardness=1e9, efficiency=1, edge_speed=100, keeps_outside=True)
    scene.add("mill", cc.Sphere(0.003), [-0.014, 0, 0.005], cutter=cutter, drive=([0.05, 0, 0], [0, 0, 0]))
    gum = cc.Tissue("gum", stiffness=500, damping=1, hardness=1e5, density=1000)
    world = cc.World(scene, voxel=0.0005, tissues=[gum])
    before = world["block"].matter
    world.run(0.2)
    body = world["block"]
    assert body.cuttable and body.cut_volume > 1e-8
    assert body.matter.voxels < before.voxels
    cells = np.argwhere(body.matter.coverage > 0)
    body.cut(cells[cells[:, 2] == cells[:, 2].max()])
    assert world["block"].matter.voxels < len(cells)


def test_replays(tmp_path):
    world = cc.World(resting(), voxel=0.002)
    world.run(0.05, replay=tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text()
    assert "<html" in page and "brick" in page
    world.run(0.05, replay=tmp_path / "run.glb")
    assert (tmp_path / "run.glb").read_bytes()[:4] == b"glTF"
    with pytest.raises(ValueError, match="glb"):
        world.run(0.05, replay=tmp_path / "run.avi")


def test_a_run_that_ends_early_leaves_its_replay(tmp_path):
    world = cc.World(resting(), voxel=0.004)

    def stop(now):
        if now.time > 0.0195:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        world.run(1, replay=tmp_path / "early.html", observe=stop)
    assert world.time == pytest.approx(0.02)
    assert (tmp_path / "early.html").stat().st_size > 10_000


def test_bodies_keep_their_world():
    brick = cc.World(resting(), voxel=0.004)["brick"]
    gc.collect()
    assert brick.mass == pytest.approx(0.2)


def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_a_thousand_worlds_leave_nothing():
    scene = cc.Scene()
    scene.add("floor", cc.HalfSpace(), static=True)
    scene.add("brick", cc.Mesh(*box_arrays([0.04, 0.03, 0.02])), [0, 0, 0.0099], mass=0.2)

    def one():
        world = cc.World(scene, voxel=0.005, threads=1)
        world.step()
        assert len(world.contacts()) > 0 and world["brick"].position[2] > 0

    for _ in range(200):  # the allocator's and libraries' own memory
        one()
    gc.collect()
    start = resident()
    for _ in range(1000):
        one()
    gc.collect()
    # A world's clouds, fields and bodies are over 100 kB: all of them would be 100 MB.
    assert resident() - start < 8e6


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda s: cc.World(cc.Scene()), ValueError, "no body"),
        (lambda s: cc.World("none.sdf"), ValueError, "none.sdf: no such file"),
        (lambda s: s.add("floor", cc.Sphere(1)), ValueError, "another name"),
        (lambda s: s.add("a", "none.stl"), ValueError, "no file 'none.stl'"),
        (lambda s: s.add("a", 3), ValueError, "shape: give"),
        (lambda s: s.add("a", cc.Cylinder(1, -1)), ValueError, "cylinder's radius and half height"),
        (lambda s: s.add("a", cc.HalfSpace()), ValueError, "static=True"),
        (lambda s: s.add("a", cc.Sphere(1), mass=-1), ValueError, "mass"),
        (lambda s: s.join("fixed", "ghost"), ValueError, "no body 'ghost'"),
        (lambda s: s.join("gearbox", "brick"), ValueError, "kind"),
        (lambda s: s.join("fixed", "brick", "brick"), ValueError, "parent"),
        (lambda s: s.join("fixed", "brick", damping=1), ValueError, "belong to moving joints"),
        (lambda s: s.join("revolute", "brick", axis=[1, 0]), ValueError, "axis: give three"),
        (lambda s: s.join("revolute", "brick", lower=1, upper=-1), ValueError, "lower"),
        (lambda s: s.join("revolute", "brick", rest=np.nan), ValueError, "rest"),
        (lambda s: s.add("a", cc.Sphere(1), velocity=[1, 2]), ValueError, "velocity: give three"),
        (lambda s: s.add("a", cc.Sphere(1), drive=5), ValueError, "drive"),
        (lambda s: s.add("a", cc.Sphere(1), angular_velocity=[0, 0, np.nan]), ValueError, "angular_velocity"),
        (lambda s: s.add("a", cc.Sphere(1), damping=5), ValueError, "damping: needs a stiffness"),
        (lambda s: s.add("a", cc.Sphere(1), restitution=2), ValueError, "restitution"),
        (lambda s: s.add("a", cc.Sphere(1), mass=1e300), ValueError, "mass"),
        (lambda s: s.add("a", cc.Sphere(1), static=True, velocity=[1, 0, 0]), ValueError, "static"),
        (lambda s: s.add("a", cc.Sphere(1), cutter=cc.Cutter(), ability=np.nan), ValueError, "ability"),
        (lambda s: setattr(s, "gravity", [0, np.nan, 0]), ValueError, "gravity"),
        (lambda s: setattr(s, "step", 0), ValueError, "step"),
        (lambda s: cc.World(s, friction=-1), ValueError, "friction"),
        (lambda s: cc.World(s, friction="a"), TypeError, "friction is of a wrong type: str"),  # type: ignore[arg-type]
        (lambda s: cc.World(s, samples=0), ValueError, "samples"),
        (lambda s: cc.World(s, iterations=-3), ValueError, "iterations"),
        (lambda s: cc.World(s, shell=-1), ValueError, "shell"),
        (lambda s: cc.World(s, threads=100000), ValueError, "threads"),
        (lambda s: cc.World(s, law="hertz"), TypeError, "law"),  # type: ignore[arg-type]
        (lambda s: cc.World(s, voxel=-1), ValueError, "voxel"),
        (lambda s: cc.World(s, voxel=1), ValueError, "brick"),
        (lambda s: cc.World(s, method="magic"), ValueError, "method"),
        (lambda s: cc.World(s, wheels=4), TypeError, "wheels"),  # type: ignore[call-arg]
        (lambda s: cc.World(s, voxel=0.004)["ghost"], KeyError, "ghost"),
        (lambda s: cc.World(s, voxel=0.004)["brick"].matter, ValueError, "cuttable"),
        (lambda s: setattr(cc.World(s, voxel=0.004)["floor"], "pose", [0, 0, 1]), ValueError, "'floor': its pose"),
        (lambda s: setattr(cc.World(s, voxel=0.004)["brick"], "pose", [0, 0, np.nan]), ValueError, "finite"),
        (lambda s: setattr(cc.World(s, voxel=0.004)["brick"], "velocity", [0, 0, np.inf]), ValueError, "velocity"),
        (lambda s: setattr(cc.World(s, voxel=0.004)["brick"], "applied_force", [0, np.nan, 0]), ValueError, "force"),
        (lambda s: setattr(cc.World(s, voxel=0.004)["brick"], "velocity", [1, 2]), ValueError, "velocity: give three"),
        (lambda s: cc.World(s, voxel=0.004).run(0.0004), ValueError, "less than half a step"),
        (lambda s: cc.World(s, voxel=0.004).step(-1), ValueError, "step"),
        (lambda s: cc.World(s, voxel=0.004).run(np.nan), ValueError, "seconds"),
    ],
)
def test_bad_input_is_named(call, error, words):
    with pytest.raises(error, match=words):
        call(resting())
