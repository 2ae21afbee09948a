"""Surface fields and the contacts of pairs."""

import numpy as np
import pytest

import cloudcontact as cc

VOXEL = 0.001
RADIUS = 0.01


def turned(axis, angle, position):
    return cc.Pose.from_rotation_vector(angle * np.asarray(axis, float) / np.linalg.norm(axis), position)


def test_depth_and_normal_of_a_box(box_field):
    depth, normal = box_field.at([[0, 0, 0.0055], [0, 0, 0.0063], [0.0098, 0, 0], [0, 0, 0], [1, 1, 1]])
    np.testing.assert_allclose(depth[:3], [0.0005, -0.0003, 0.0002], atol=0.02 * VOXEL)
    np.testing.assert_allclose(normal[:3], [[0, 0, 1], [0, 0, 1], [1, 0, 0]], atol=1e-3)
    assert depth[3] == pytest.approx(0.006, rel=0.05)
    assert np.isnan(depth[4]) and np.isnan(normal[4]).all()


def test_samples_share_the_fields_memory(box_field):
    samples = box_field.samples()
    assert len(samples["x"]) == box_field.sample_count
    area = 2 * (0.02 * 0.016 + 0.016 * 0.012 + 0.012 * 0.02)
    assert samples["area"].sum() * VOXEL**2 == pytest.approx(area, rel=0.01)
    assert np.shares_memory(samples["x"], box_field.samples()["x"])
    assert not samples["x"].flags.writeable


def test_field_files(box_field, tmp_path):
    box_field.save(tmp_path / "box.field")
    again = cc.SurfaceField.load(tmp_path / "box.field")
    assert again.hash == box_field.hash
    with pytest.raises(RuntimeError, match="none.field"):
        cc.SurfaceField.load(tmp_path / "none.field")


def test_a_renewed_field_is_that_of_the_cut_cloud(box_cloud):
    field = cc.SurfaceField(box_cloud, renewable=True)
    x, y, z = box_cloud.shape
    after = box_cloud.cut([[x // 2 + i, y // 2, z // 2 + j] for i in range(3) for j in range(-6, 7)])
    assert field.renewed(after).hash == cc.SurfaceField(after).hash


def test_a_ball_pressed_on_a_plane(ball_field):
    """Force k d along the plane's normal, at the point of contact."""
    depth, k = 0.0002, 5e3
    found = cc.contact(cc.HalfSpace(), ball_field, [0.003, 0.002, RADIUS - depth], law=cc.KelvinVoigt(k))
    assert found and len(found) == len(found.points)
    np.testing.assert_allclose(found.force, [0, 0, k * depth], atol=0.05 * k * depth)
    np.testing.assert_allclose(found.torque, np.cross([0.003, 0.002, 0], found.force), atol=1e-4)
    assert found.depth == pytest.approx(depth, abs=0.1 * 0.0005)
    points = found.points
    np.testing.assert_allclose(points["normal"] @ [0, 0, 1], 1, atol=1e-2)
    assert points["stiffness"].sum() == pytest.approx(k, rel=1e-6)
    assert (points["patch"] == 0).all() and len(found.patches) == 1
    assert found.patches["confidence"][0] > 0.5


def test_damping_acts_on_the_closing_speed(ball_field):
    law, still = cc.KelvinVoigt(5e3, 10), [0, 0, RADIUS - 0.0002]
    rest = cc.contact(cc.HalfSpace(), ball_field, still, law=law)
    closing = cc.ContactBody(ball_field, still, velocity=[0, 0, -0.1])
    moving = cc.contact(cc.HalfSpace(), closing, law=law)
    assert moving.force[2] - rest.force[2] == pytest.approx(10 * 0.1, rel=0.02)


def test_swapping_the_bodies_turns_the_force(box_field, ball_field):
    place = turned([1, 2, 3], 0.4, [0.001, 0.002, 0.0155])
    one = cc.contact(box_field, ball_field, place)
    two = cc.contact(cc.ContactBody(ball_field, place), cc.ContactBody(box_field))
    assert one and np.linalg.norm(one.force) > 0
    np.testing.assert_allclose(two.force, -one.force, atol=1e-5 * float(np.linalg.norm(one.force)))


def test_apart_there_is_no_contact(box_field, ball_field):
    found = cc.contact(box_field, ball_field, [0, 0, 0.03])
    assert not found and len(found.points) == 0 and found.depth == 0
    np.testing.assert_array_equal(found.force, 0)


def test_results_outlive_the_finder(box_field, ball_field):
    finder = cc.ContactFinder()
    first = finder.find(box_field, cc.ContactBody(ball_field, [0, 0, 0.0158]))
    points, kept = first.points, first.points.copy()
    for z in np.linspace(0.0158, 0.0150, 20):
        finder.find(box_field, cc.ContactBody(ball_field, [0.002, 0, z]))
    del first, finder
    np.testing.assert_array_equal(points, kept)
    assert not points.flags.writeable


def test_ids_stay_from_call_to_call(box_field):
    finder, ids = cc.ContactFinder(), []
    body = cc.ContactBody(box_field)
    for step in range(5):
        body.pose = cc.Pose([0, 0, 0.0119 - 1e-6 * step])
        ids.append(set(finder.find(box_field, body).points["id"]))
    assert len(ids[0]) == 4 and all(i == ids[0] for i in ids)


def test_tissues_decide_k_and_c(ball_field):
    soft = cc.Tissue("gum", stiffness=800, damping=2)
    body = cc.ContactBody(ball_field, [0, 0, RADIUS - 0.0002], tissues=[soft])
    found = cc.contact(cc.HalfSpace(), body)
    assert found.points["stiffness"].sum() == pytest.approx(800, rel=1e-6)
    assert found.points["damping"].sum() == pytest.approx(2, rel=1e-6)


def test_base_vectors_push_along_the_plane(ball_field):
    paper = cc.PaperBody(ball_field.cloud, [cc.Tissue("steel", 1e4)])
    body = cc.ContactBody(ball_field, [0, 0, RADIUS - 0.0004], paper=paper)
    found = cc.contact(cc.HalfSpace(), body)
    np.testing.assert_allclose(found.patches["normal"][0], [0, 0, 1], atol=0.02)


def poses_of(n, seed):
    rng = np.random.default_rng(seed)
    turns = rng.normal(size=(n, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    places = rng.normal(size=(n, 3))
    places *= rng.uniform(0.012, 0.02, (n, 1)) / np.linalg.norm(places, axis=1, keepdims=True)
    return np.hstack([places, turns])


@pytest.mark.parametrize("backend", ["cpu", "opencl"])
def test_a_batch_equals_single_contacts_to_the_bit(backend, box_field, ball_field):
    batch = cc.ContactBatch(backend)
    if batch.backend != backend:
        pytest.skip(batch.message)
    poses, law = poses_of(64, 3), cc.KelvinVoigt(2e3, 1)
    found = batch.find_poses(box_field, ball_field, poses, law=law)
    assert len(found) == 64 and found.forces.shape == (64, 3)
    touching = 0
    for i, pose in enumerate(poses):
        one = cc.contact(box_field, ball_field, pose, law=law)
        np.testing.assert_array_equal(found.forces[i], one.force)
        np.testing.assert_array_equal(found.torques[i], one.torque)
        assert found.depths[i] == one.depth
        points = found.points[found.first_points[i] : found.first_points[i + 1]]
        for name in ("position", "normal", "depth", "stiffness", "damping"):
            np.testing.assert_array_equal(points[name], one.points[name])
        touching += bool(one)
    assert 5 < touching < 64
    pairs = [(box_field, cc.ContactBody(ball_field, pose)) for pose in poses]
    np.testing.assert_array_equal(batch.find(pairs, law=law).forces, found.forces)
    assert np.shares_memory(found.forces, found.forces)


def test_one_thread_gives_the_same_bits(box_field, ball_field):
    poses = poses_of(32, 4)
    one = cc.ContactBatch(threads=1).find_poses(box_field, ball_field, poses)
    many = cc.ContactBatch(threads=4).find_poses(box_field, ball_field, poses)
    np.testing.assert_array_equal(one.forces, many.forces)


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda f: cc.contact(cc.HalfSpace(), cc.Sphere(1)), "both bodies|shape"),
        (lambda f: cc.contact(cc.Sphere(-1), f), "sphere's radius"),
        (lambda f: cc.contact(cc.Box([1, np.nan, 1]), f), "box's half extents"),
        (lambda f: cc.contact(cc.Cone(1, 0), f), "cone's radius and half height"),
        (lambda f: cc.contact(f, f, [0, np.nan, 0]), "finite"),
        (lambda f: cc.contact(f, f, [0, 1]), "pose: give a Pose"),
        (lambda f: cc.contact(f, f, np.diag([2.0, 1, 1, 1])), "rigid one"),
        (lambda f: cc.contact(f, f, [0, 0, 0, 0, 0, 0, 0]), "quaternion"),
        (lambda f: cc.contact(f, f, law=cc.Maxwell(1e4, 1)), "memory"),
        (lambda f: cc.contact(f, f, margin=-1), "margin"),
        (lambda f: cc.ContactBatch().find_poses(f, f, np.zeros((1, 3)), samples=0), "samples"),
        (lambda f: cc.ContactBatch(threads=-1), "threads"),
        (lambda f: cc.ContactBody(f, velocity=[np.nan, 0, 0]), "velocity"),
        (lambda f: cc.Pose.from_rotation_vector([np.nan, 0, 0]), "turn"),
        (lambda f: cc.Pose([0, 0, 0], np.eye(4)), "one quaternion"),
        (lambda f: cc.contact(f, "ball"), "b: give a SurfaceField"),  # type: ignore[arg-type]
        (lambda f: cc.KelvinVoigt(-1), "stiffness|not negative"),
        (lambda f: cc.ContactBody(f, tissues=[cc.Tissue("a", 1), cc.Tissue("b", 1)]), "tissues"),
        (lambda f: cc.Tissue("a", 0), "stiffness"),
        (lambda f: cc.ContactBatch().find_poses(f, f, np.zeros((2, 4))), r"poses_b: .*\(n, 7\)"),
        (lambda f: cc.ContactBatch().find_poses(f, f, np.zeros((2, 3)), np.zeros((3, 3))), "as many"),
        (lambda f: cc.ContactBatch("tpu"), "backend"),
        (lambda f: cc.SurfaceField(f.cloud.cut(np.argwhere(f.cloud.coverage > 0))), "empty|no surface|material"),
    ],
)
def test_bad_input_is_named(call, words, box_field):
    with pytest.raises(ValueError, match=words):
        call(box_field)
