"""Joints of worlds: kinds, places, motors, reactions, names and states."""

import copy
import math
import pickle

import numpy as np
import pytest

import cloudcontact as cc

G = 9.81


def hung(kind="revolute", **words):
    """A bar of 1 kg, 0.2 m along x, that a joint holds at its left end."""
    scene = cc.Scene("hung", step=1e-3)
    scene.add("bar", cc.Box((0.1, 0.01, 0.01)), (0.1, 0, 0), mass=1.0, friction=0.3)
    scene.join(kind, "bar", axis=(0, 1, 0), name="pivot", **words)
    return scene


def world_of(scene):
    return cc.World(scene, voxel=0.004, progress=False)


def test_a_servo_holds_a_bar_and_the_joint_carries_its_weight():
    world = world_of(hung(lower=-2.0, upper=2.0))
    joint = world.joint("pivot")
    joint.motor = cc.Motor(position=-0.5, stiffness=4000, damping=40)
    world.run(1.0, progress=False)
    # The weight turns it down by its torque over the stiffness.
    sag = G * 0.1 * math.cos(0.5) / 4000
    assert joint.position == pytest.approx(-0.5 + sag, abs=1e-5)
    assert joint.velocity == pytest.approx(0, abs=1e-4)
    np.testing.assert_allclose(joint.force, [0, 0, G], atol=2e-3)
    np.testing.assert_allclose(joint.torque, [0, -G * 0.1 * math.cos(0.5), 0], atol=2e-3)
    np.testing.assert_allclose(joint.origin, 0, atol=1e-5)
    np.testing.assert_allclose(joint.direction, [0, 1, 0], atol=1e-6)
    assert (joint.kind, joint.lower, joint.upper, joint.effort) == ("revolute", -2, 2, math.inf)
    assert world.joints == ["pivot"]


def test_speed_force_and_effort():
    world = world_of(hung(kind="prismatic", effort=30.0))
    joint = world.joint("pivot")
    joint.motor = cc.Motor(velocity=0.2, damping=math.inf)
    world.run(0.5, progress=False)
    # 30 N are enough from 7 ms on.
    assert joint.position == pytest.approx(0.1 - 0.2**2 / (2 * 30), rel=2e-3)
    assert world["bar"].velocity[1] == pytest.approx(0.2, rel=1e-4)
    joint.motor = cc.Motor(force=100.0)  # 30 of them count, on 1 kg
    world.run(0.1, progress=False)
    assert joint.velocity == pytest.approx(0.2 + 3.0, rel=2e-3)
    joint.motor = None
    world.run(0.1, progress=False)
    assert joint.velocity == pytest.approx(3.2, rel=2e-3)
    assert world.joint("pivot").motor.force == 0


def test_screws_balls_and_universal_joints():
    scene = hung(kind="screw", pitch=0.3)
    world = world_of(scene)
    joint = world.joint("pivot")
    joint.motor = cc.Motor(velocity=30.0, damping=math.inf)
    world.run(0.5, progress=False)
    assert joint.position == pytest.approx(15.0, rel=0.02)  # more than two turns
    assert joint.origin[1] == pytest.approx(joint.position / (2 * math.pi) * 0.3, rel=1e-3)

    world = world_of(hung(kind="ball"))
    with pytest.raises(IndexError, match="pivot"):
        world.joint("pivot").position
    world.run(0.1, progress=False)
    assert world["bar"].angular_velocity[1] > 1

    scene = hung(kind="universal", second={"axis": (0, 0, 1), "lower": -0.3, "upper": 0.4})
    world = world_of(scene)
    world.joint("pivot", 1).motor = cc.Motor(velocity=2.0, damping=math.inf, most=50)
    world.run(0.5, progress=False)
    second = world.joint("pivot", 1)
    assert second.position == pytest.approx(0.4, abs=2e-3) and second.upper == 0.4
    assert world.joint("pivot").position > 0.5  # it fell meanwhile


def test_joints_have_names():
    scene = hung()
    scene.add("lid", cc.Box((0.05, 0.01, 0.01)), (0.3, 0, 0), mass=0.1, friction=0.3)
    scene.join("revolute", "lid", "bar", (0.25, 0, 0), (0, 1, 0))
    with pytest.raises(ValueError, match="'lid to bar'; give this one a name"):
        scene.join("revolute", "lid", "bar", (0.25, 0, 0), (0, 1, 0))
    scene.join("fixed", "lid", "bar", name="weld")
    with pytest.raises(ValueError, match="'weld'; give another name"):
        scene.join("fixed", "lid", "bar", name="weld")
    world = world_of(scene)
    assert world.joints == ["pivot", "lid to bar", "weld"]
    with pytest.raises(KeyError, match="hinge"):
        world.joint("hinge")
    with pytest.raises(IndexError):
        world.joint("pivot", 1)


@pytest.mark.parametrize(
    "words, message",
    [
        ({"kind": "glue"}, "screw, ball or universal"),
        ({"kind": "screw"}, "pitch"),
        ({"kind": "revolute", "pitch": 1.0}, "screw"),
        ({"kind": "universal"}, "second"),
        ({"kind": "universal", "second": (0, 1, 1)}, "across"),
        ({"kind": "universal", "second": {"lower": None}}, "axis"),
        ({"kind": "universal", "second": {"axis": (1, 0, 0), "speed": 1}}, "speed"),
        ({"kind": "revolute", "second": (1, 0, 0)}, "universal"),
        ({"kind": "ball", "lower": 0.0}, "moving"),
        ({"kind": "revolute", "effort": -1.0}, "effort"),
    ],
)
def test_what_is_none_is_refused(words, message):
    with pytest.raises(ValueError, match=message):
        hung(**words)


def test_bad_motors_are_refused():
    joint = world_of(hung()).joint("pivot")
    for bad in (cc.Motor(stiffness=-1), cc.Motor(position=math.nan), cc.Motor(most=-1)):
        with pytest.raises(ValueError, match="pivot"):
            joint.motor = bad


def test_a_motor_does_not_change_and_is_given_again():
    joint = world_of(hung()).joint("pivot")
    with pytest.raises(AttributeError):
        setattr(joint.motor, "position", 0.5)
    joint.motor = cc.Motor(position=0.5, stiffness=1)
    assert joint.motor.position == 0.5


def test_states_keep_turns_and_motors():
    world = world_of(hung(kind="screw", pitch=0.3))
    joint = world.joint("pivot")
    joint.motor = cc.Motor(velocity=30.0, damping=5)
    world.run(0.3, progress=False)
    state = pickle.loads(pickle.dumps(world.save()))
    world.run(0.2, progress=False)
    went, place = world.hash, joint.position
    joint.motor = None
    world.run(0.1, progress=False)
    world.restore(state)
    world.run(0.2, progress=False)
    assert (world.hash, joint.position) == (went, place)
    other = copy.copy(world)
    assert np.linalg.norm(joint.force) > 1
    assert (joint.force == other.joint("pivot").force).all()
    assert (joint.torque == other.joint("pivot").torque).all()
    assert other.joint("pivot").position == place and other.joint("pivot").motor.velocity == 30
    motor = pickle.loads(pickle.dumps(other.joint("pivot").motor))
    assert repr(motor) == repr(joint.motor)
