"""Threads of Python that share an object take turns: all get what one thread would get."""

import subprocess
import sys
import threading

import numpy as np
import pytest
from conftest import box_arrays

import cloudcontact as cc

TIMES = 40


def in_threads(*works):
    """Runs each work in a thread of its own, and raises what one of them raised."""
    failures = []

    def guarded(work):
        try:
            work()
        except BaseException as failure:
            failures.append(failure)

    threads = [threading.Thread(target=guarded, args=(work,)) for work in works]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if failures:
        raise failures[0]


@pytest.fixture(scope="module")
def ball():
    return cc.SurfaceField(cc.digitize("sphere:0.01", 0.0005))


def test_a_finder_finds_for_each(ball):
    poses = [[0, 0, 0.018 + 0.0002 * i] for i in range(4)]
    alone = [cc.contact(ball, ball, pose) for pose in poses]
    finder = cc.ContactFinder()

    def finds(i):
        for _ in range(5 * TIMES):
            found = finder.find(ball, cc.ContactBody(ball, poses[i]))
            np.testing.assert_array_equal(found.force, alone[i].force)
            np.testing.assert_array_equal(found.points["position"], alone[i].points["position"])

    in_threads(*(lambda i=i: finds(i) for i in range(4)))


def test_a_batch_finds_for_each(ball):
    poses = [np.array([[0, 0, 0.018 + 0.0002 * i + 0.0001 * k] for k in range(20 + i)]) for i in range(3)]
    alone = [cc.ContactBatch().find_poses(ball, ball, p).forces for p in poses]
    batch = cc.ContactBatch()

    def finds(i):
        for _ in range(TIMES):
            np.testing.assert_array_equal(batch.find_poses(ball, ball, poses[i]).forces, alone[i])
            assert batch.on_device == 0

    in_threads(*(lambda i=i: finds(i) for i in range(3)))


def falling():
    scene = cc.Scene()
    scene.add("floor", cc.HalfSpace(), static=True, friction=0.5)
    brick = cc.Mesh(*box_arrays([0.04, 0.03, 0.02]))
    for i in range(6):  # a heap, whose steps are long enough to meet
        scene.add(f"brick {i}", brick, [0.004 * i, 0, 0.0099 + 0.0199 * i], mass=0.2, friction=0.5)
    return cc.World(scene, voxel=0.002)


def test_threads_step_one_world_and_read_it():
    alone, shared = falling(), falling()
    for _ in range(4 * TIMES):
        alone.step()

    def steps():
        for _ in range(TIMES):
            shared.step()

    def reads():
        for _ in range(10 * TIMES):
            assert np.isfinite(shared.positions).all() and np.isfinite(shared.contacts()["force"]).all()
            assert shared["brick 0"].position[2] > 0 and shared.energy["kinetic"] >= 0

    in_threads(steps, reads, lambda: shared.run(TIMES * 1e-3), reads, steps, steps)
    assert shared.hash == alone.hash and shared.time == pytest.approx(alone.time)


def test_a_world_is_read_while_it_is_shown():
    world, done = falling(), threading.Event()

    def shows():
        world.view(0.2, announce=lambda url: None)
        done.set()

    def reads():
        times = [world.time]
        while not done.is_set():
            times.append(world.time)
        assert len(set(times)) > 3 and times == sorted(times)

    in_threads(shows, reads)


def test_threads_that_cut_remove_what_one_removes(box_cloud):
    tissue = [cc.Tissue("bone", 1e5)]
    alone, shared = (cc.BaseVectorField(box_cloud, tissue) for _ in range(2))
    places = np.linspace(-0.01, 0.01, 10 * TIMES)
    for x in places:
        alone.cut_area(cc.Sphere(0.004), [x, 0, 0])
    finder = cc.CollisionFinder()

    def cuts(part):
        for x in places[part::2]:
            shared.cut_area(cc.Sphere(0.004), [x, 0, 0])

    def looks():
        tool = cc.Detection(cc.Sphere(0.002))
        loop = cc.HapticLoop(shared, tool)
        for x in places:
            finder.find(shared, tool, [x, 0, 0])
            loop.tick([x, 0, 0.005])
            shared.mass_properties()

    in_threads(lambda: cuts(0), looks, lambda: cuts(1), looks)
    assert shared.hash == alone.hash


def test_a_world_stops_when_another_thread_asks():
    scene = cc.Scene("stops", step=0.002)
    scene.add("ball", cc.Sphere(0.02), mass=0.1, friction=0.5)
    world = cc.World(scene, voxel=0.004)
    begun = threading.Event()

    def stops():
        begun.wait(60)
        world.stop()

    in_threads(lambda: world.run(1000, observe=lambda _: begun.set(), progress=False), stops)
    assert 0 < world.time < 1000
    steps = []

    def observes(running):
        steps.append(running.time)
        running.stop()

    world.run(0.1, observe=observes)
    assert len(steps) == 1, "an observer stops its own run"
    world.stop()  # no run: nothing
    world.run(0.01, observe=lambda w: steps.append(w.time))
    assert len(steps) > 1


# A thread that Python does not wait for, in the midst of each work when the main one ends.
ENDS = """
import sys, threading, time
import cloudcontact as cc

scene = cc.Scene("ends", gravity=(0, 0, -9.81), step=0.002)
scene.add("floor", cc.HalfSpace(), static=True, friction=0.5)
scene.add("ball", cc.Sphere(0.02), (0, 0, 0.02), mass=0.1, friction=0.5)
world = cc.World(scene, voxel=0.004)
cloud = cc.digitize("sphere:0.02", 0.001)
field = cc.SurfaceField(cloud)

def finds():
    while True:
        cc.contact(field, field, (0, 0, 0.039))

def digitizes():
    while True:
        cc.digitize("sphere:0.02", 0.0005, progress=False)

def waits():
    world.run(1000, observe=lambda w: [w.contacts() for _ in range(9)], progress=False)

works = {
    "view": lambda: world.view(announce=lambda url: None),
    "run": lambda: world.run(1000, progress=False),
    "observes": waits,
    "finds": finds,
    "digitizes": digitizes,
}
for _ in range(2 if sys.argv[1] in ("finds", "digitizes") else 1):
    threading.Thread(target=works[sys.argv[1]], daemon=True).start()
time.sleep(0.5)
"""


@pytest.mark.parametrize("work", ["view", "run", "observes", "finds", "digitizes"])
def test_the_interpreter_ends_while_a_thread_works(work):
    ended = subprocess.run([sys.executable, "-c", ENDS, work], capture_output=True, text=True, timeout=120)
    assert (ended.returncode, ended.stderr) == (0, "")
