"""The package: its types, docstrings, README sample, progress, Ctrl-C and threads."""

import ast
import inspect
import io
import os
import pathlib
import re
import signal
import subprocess
import sys
import threading
import time
from typing import Any

import numpy as np
import pytest
from conftest import box_arrays, write_obj

import cloudcontact as cc
from cloudcontact import _core, _progress

SOURCE = pathlib.Path(__file__).parents[2]
PACKAGE = pathlib.Path(cc.__file__).parent


def mypy(*words):
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent)}
    done = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr


def test_types_hold_for_the_package_and_for_these_tests(tmp_path):
    """The tests' calls run, so what mypy says of them it says of the module."""
    pytest.importorskip("mypy")
    mypy("mypy", "--strict", "--cache-dir", str(tmp_path), "-p", "cloudcontact")
    files = sorted(str(f) for f in (SOURCE / "tests/python").glob("*.py"))
    mypy("mypy", "--check-untyped-defs", "--ignore-missing-imports", "--cache-dir", str(tmp_path), *files)


def names_of(body):
    """Of the classes, functions and members that a stub declares."""
    for node in body:
        if isinstance(node, ast.ClassDef):
            yield node.name
            yield from (f"{node.name}.{inner}" for inner in names_of(node.body))
        elif isinstance(node, ast.FunctionDef):
            yield node.name
        elif isinstance(node, ast.AnnAssign):
            yield ast.unparse(node.target)


def test_the_stub_names_what_the_module_has():
    stub = set(names_of(ast.parse((PACKAGE / "_core.pyi").read_text()).body))
    module = {n for n in vars(_core) if not n.startswith("_")} | {"__version__"}
    for name in [n for n in module if inspect.isclass(getattr(_core, n))]:
        module |= {f"{name}.{member}" for member in vars(getattr(_core, name)) if not member.startswith("_")}
    assert {n for n in stub if not re.search(r"\.__\w+__$|^_[a-z]", n)} == module


def test_wrong_types_are_seen(tmp_path):
    pytest.importorskip("mypy")
    (tmp_path / "wrong.py").write_text("import cloudcontact as cc\ncc.digitize('a.stl', voxel='small')\n")
    with pytest.raises(AssertionError, match="incompatible type"):
        mypy("mypy", "--cache-dir", str(tmp_path), str(tmp_path / "wrong.py"))


def public():
    for name in cc.__all__:
        thing = getattr(cc, name)
        yield name, thing
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                if not member.startswith("_"):
                    yield f"{name}.{member}", value


# What needs no words.
PLAIN = re.compile(r"Tissue.name|Cutter.efficiency|Scene.name|WorldBody.(name|asleep|cuttable)|__version__")


def test_everything_has_a_docstring():
    missing = [n for n, thing in public() if not getattr(thing, "__doc__", None) and not PLAIN.fullmatch(n)]
    assert missing == []


def test_docstrings_have_short_lines():
    long = [n for n, t in public() for line in (t.__doc__ or "").split("\n") if len(line) > 100]
    assert long == []


def test_the_readme_sample_runs(tmp_path, monkeypatch):
    text = (SOURCE / "README.md").read_text()
    sample = re.findall(r"```python\n(.*?)```", text, re.S)[0]
    lines = [line for line in sample.split("\n") if line.strip()]
    assert len(lines) <= 10
    vertices, triangles = box_arrays([40, 30, 20])
    write_obj(tmp_path / "part.obj", vertices, triangles)
    monkeypatch.chdir(tmp_path)
    values: dict[str, Any] = {}
    exec(compile(sample.replace("part.stl", "part.obj"), "README.md", "exec"), values)
    assert values["world"]["part"].position[2] < 0.05
    assert abs(values["world"]["part"].velocity).max() < 0.01
    assert (tmp_path / "rest.html").stat().st_size > 100_000


def test_progress_calls_back_and_ends_at_one(box):
    seen: list[float] = []
    cc.SurfaceField(cc.digitize(box, 0.0002, progress=seen.append), progress=seen.append)
    assert seen[-1] == 1 and all(0 <= s <= 1 for s in seen)


def test_what_a_callback_raises_ends_the_work():
    cloud = cc.digitize("sphere:0.03", 0.0002)

    def stop(share):
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        cc.SurfaceField(cloud, progress=stop)
    with pytest.raises(KeyError, match="enough"):
        scene = cc.Scene()
        scene.add("ball", cc.Sphere(0.01), mass=1)
        cc.World(scene, voxel=0.001, progress=False).run(100, progress=stop)


def test_a_line_of_text():
    out = io.StringIO()
    line = _progress.TextLine("digitizing", out, 0)
    line(0.25)
    line.due = 0
    line(0.5)
    line(1.0)
    assert "digitizing [######------------------]  25 %" in out.getvalue()
    assert out.getvalue().endswith("\r")


def test_lines_only_where_someone_sees_them(monkeypatch):
    assert _progress.reporter(False, "x") is None
    assert _progress.reporter(print, "x") is print
    assert isinstance(_progress.reporter(True, "x"), _progress.TextLine)
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    assert _progress.reporter(None, "x") is None
    monkeypatch.setattr(_progress, "in_notebook", lambda: True)
    assert isinstance(_progress.reporter(None, "x"), _progress.TextLine)


LONG = {
    "field": "cc.SurfaceField(cc.digitize('sphere:0.05', 0.00015))",
    "world": "cc.World(scene, voxel=0.001).run(1e6)",
    "haptics": "loop.run(np.zeros((20_000_000, 3)))",
}
PREPARE = """import numpy as np, cloudcontact as cc
scene = cc.Scene(); scene.add('ball', cc.Sphere(0.01), mass=1)
field = cc.BaseVectorField(cc.digitize('sphere:0.01', 0.001), [cc.Tissue('a', 1)])
loop = cc.HapticLoop(field, cc.Detection(cc.Sphere(0.003)))
print('ready', flush=True)
"""


@pytest.mark.parametrize("work", LONG)
def test_ctrl_c_ends_long_work(work):
    child = subprocess.Popen(
        [sys.executable, "-c", PREPARE + LONG[work]], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert child.stdout and child.stdout.readline() == "ready\n"
    time.sleep(1)
    child.send_signal(signal.SIGINT)
    _, error = child.communicate(timeout=60)
    assert child.returncode != 0 and "KeyboardInterrupt" in error


def test_other_threads_run_meanwhile():
    cloud, ticks, done = cc.digitize("sphere:0.02", 0.0002), [0], threading.Event()

    def count():
        while not done.is_set():
            ticks[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    before = ticks[0]
    cc.SurfaceField(cloud, threads=1)
    during = ticks[0] - before
    done.set()
    thread.join()
    assert during > 10


def test_the_version_is_the_projects():
    text = (SOURCE / "CMakeLists.txt").read_text()
    assert cc.__version__ == re.findall(r"project\(CloudContact VERSION ([\d.]+)", text)[0]
    assert _core.__version__ == cc.__version__


def test_poses_compose_as_matrices():
    rng = np.random.default_rng(2)
    a, b = (cc.Pose.from_rotation_vector(rng.normal(size=3), rng.normal(size=3)) for _ in range(2))
    np.testing.assert_allclose((a @ b).matrix, a.matrix @ b.matrix, atol=1e-12)
    np.testing.assert_allclose(a.inverse().matrix, np.linalg.inv(a.matrix), atol=1e-12)
    np.testing.assert_allclose(cc.Pose(a.matrix).orientation, a.orientation, atol=1e-12)
    point = rng.normal(size=3)
    np.testing.assert_allclose(a.to_local(a.to_world(point)), point, atol=1e-12)
    np.testing.assert_allclose(a.to_world(point), a.matrix[:3, :3] @ point + a.position, atol=1e-12)
