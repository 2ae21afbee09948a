"""Live views, heard and touched as the page does it, and replays in notebooks."""

import base64
import html
import json
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from typing import Any, Dict, List

import numpy as np
import pytest
from conftest import box_arrays

import cloudcontact as cc


def brick(height=0.0101, **words):
    scene = cc.Scene("a brick", gravity=(0, 0, -9.81), step=0.002)
    scene.add("floor", cc.HalfSpace(), static=True, friction=0.5)
    scene.add("brick", cc.Mesh(*box_arrays([0.04, 0.03, 0.02])), [0, 0, height], mass=0.2, friction=0.5)
    return cc.World(scene, voxel=0.002, **words)


class Page:
    """The page's WebSocket."""

    def __init__(self, url):
        host, token = url.removeprefix("http://").rstrip("/").split("/")
        name, port = host.split(":")
        assert name == "127.0.0.1"
        self.line = socket.create_connection((name, int(port)), timeout=30)
        key = base64.b64encode(os.urandom(16)).decode()
        lines = [f"GET /{token}/feed HTTP/1.1", f"Host: {host}", f"Origin: http://{host}", "Connection: Upgrade",
                 "Upgrade: websocket", "Sec-WebSocket-Version: 13", f"Sec-WebSocket-Key: {key}", "", ""]  # fmt: skip
        self.line.sendall("\r\n".join(lines).encode())
        self.unread = b""
        while b"\r\n\r\n" not in self.unread:
            self.unread += self.line.recv(65536)
        answer, self.unread = self.unread.split(b"\r\n\r\n", 1)
        assert answer.startswith(b"HTTP/1.1 101 "), answer

    def take(self, count):
        while len(self.unread) < count:
            got = self.line.recv(65536)
            if not got:
                raise EOFError
            self.unread += got
        taken, self.unread = self.unread[:count], self.unread[count:]
        return taken

    def hear(self) -> Dict[str, Any]:
        """The next moment, with its poses."""
        while True:
            kind, size = self.take(2)
            if size == 126:
                (size,) = struct.unpack("!H", self.take(2))
            elif size == 127:
                (size,) = struct.unpack("!Q", self.take(8))
            body = self.take(size)
            if kind & 15 == 8:
                raise EOFError
            if kind & 15 == 2:
                break
        assert body[:4] == b"RPLY"
        (length,) = struct.unpack_from("<I", body, 4)
        message = json.loads(body[8 : 8 + length])
        if "surface" in message:
            return self.hear()
        poses = message["poses"]
        message["poses"] = np.frombuffer(body, "<f4", poses["length"], 8 + length + poses["at"]).reshape(-1, 7)
        return message

    def ask(self, **command):
        body = json.dumps(command).encode()
        mask = os.urandom(4)
        masked = bytes(b ^ mask[i % 4] for i, b in enumerate(body))
        assert len(body) < 65536
        size = bytes([0x80 | len(body)]) if len(body) < 126 else b"\xfe" + struct.pack("!H", len(body))
        self.line.sendall(b"\x81" + size + mask + masked)

    def until(self, holds):
        """Hears on until it holds for a message."""
        for _ in range(5000):
            message = self.hear()
            if holds(message):
                return message
        raise AssertionError("it never came")


class Viewed:
    """A world whose view runs in a thread."""

    def __init__(self, world, **words):
        self.world = world
        self.urls: List[str] = []
        self.errors: List[Exception] = []
        told = threading.Event()

        def announce(url):
            self.urls.append(url)
            told.set()

        def run():
            try:
                world.view(announce=announce, **words)
            except Exception as error:
                self.errors.append(error)

        self.thread = threading.Thread(target=run)
        self.thread.start()
        assert told.wait(60)

    def __enter__(self):
        self.page = Page(self.urls[0])
        return self.page

    def __exit__(self, *_):
        self.world.stop()
        self.thread.join(60)
        assert not self.thread.is_alive()
        assert self.errors == []


def test_a_page_sees_the_world_pauses_it_and_pulls_a_body():
    world = brick()
    with Viewed(world) as page:
        first = page.hear()
        assert first["running"] and first["poses"].shape == (2, 7)
        page.ask(do="pause")
        paused = page.until(lambda m: not m["running"])
        page.ask(do="step")
        stepped = page.until(lambda m: m["time"] > paused["time"])
        assert stepped["time"] == pytest.approx(paused["time"] + 0.002)
        page.ask(do="run")
        page.ask(do="pull", body=1, at=[0, 0, 0], to=[0, 0, 0.1])
        lifted = page.until(lambda m: m["poses"][1, 2] > 0.09)
        assert lifted["pulls"][0]["body"] == 1
        page.ask(do="pull", body=0, at=[0, 0, 0], to=[0, 0, 0.1])
        refused = page.until(lambda m: m["sayings"] > 0)
        assert "floor" in refused["said"]
        page.ask(do="release")
        fallen = page.until(lambda m: m["poses"][1, 2] < 0.02)
        assert fallen["pulls"] == []
    assert world.time > 0 and world["brick"].position[2] < 0.1


def test_a_page_cuts_what_is_cuttable():
    scene = cc.Scene(gravity=[0, 0, 0], step=0.002)
    block = cc.Mesh(*box_arrays([0.03, 0.02, 0.01]))
    scene.add("block", block, static=True, cuttable=True, tissue="gum")
    gum = cc.Tissue("gum", stiffness=500, damping=1, hardness=1e5, density=1000)
    world = cc.World(scene, voxel=0.001, tissues=[gum])
    with Viewed(world, speed=0) as page:
        page.ask(do="cut", body=0, at=[0, 0, 0.005], radius=0.004)
        page.ask(do="pause")
        page.ask(do="nonsense")
        page.until(lambda m: m["sayings"] > 0)
        page.ask(do="run")
        page.until(lambda m: m["running"])
    # Half a ball.
    assert world["block"].cut_volume == pytest.approx(2 / 3 * np.pi * 0.004**3, rel=0.03)


def test_a_view_that_nobody_touches_changes_nothing():
    run, seen = brick(0.03), brick(0.03)
    run.run(0.2)
    urls: List[str] = []
    seen.view(0.2, speed=0, announce=urls.append)
    assert len(urls) == 1 and urls[0].startswith("http://127.0.0.1:")
    assert run.hash == seen.hash and seen.time == pytest.approx(0.2)


def test_all_steps_that_are_asked_for_are_made():
    with Viewed(brick()) as page:
        page.ask(do="pause")
        start = page.until(lambda m: not m["running"])["time"]
        for _ in range(100):
            page.ask(do="step")
        page.until(lambda m: m["time"] > start + 99.5 * 0.002)
        page.ask(do="step")
        page.ask(do="nonsense")  # is answered in turn
        page.until(lambda m: m["sayings"] > 0)
        page.ask(do="step")
        last = page.until(lambda m: m["time"] > start + 101.5 * 0.002)
        assert last["time"] == pytest.approx(start + 102 * 0.002)


def ended(act):
    """The last moment of a view in which `act` is called with the world after 20 steps, and what it raises."""
    # Its voxels lose their way at 1e38 m/s; as a box it slides on.
    world, urls, told, raised, steps = brick(tolerance="exact"), [], threading.Event(), [], [0]
    heard = threading.Event()

    def announce(url):
        urls.append(url)
        told.set()

    def observe(world):
        steps[0] += 1
        if steps[0] == 20:
            assert heard.wait(60)
            act(world)

    def run():
        try:
            world.view(0.1, announce=announce, observe=observe)
        except Exception as error:
            raised.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    assert told.wait(60)
    page = Page(urls[0])
    page.hear()
    heard.set()
    last = page.until(lambda m: m["ended"])
    page.line.close()
    thread.join(60)
    return last, raised


def test_a_page_learns_why_a_view_failed():
    def fail(_):
        raise ValueError("my controller failed.\nIn detail: all of it")

    def rush(world):
        world["brick"].velocity = [1e38, 0, 0]

    last, raised = ended(fail)
    assert last["why"] == "ValueError: my controller failed"
    assert [type(error) for error in raised] == [ValueError]
    last, raised = ended(rush)
    assert raised and last["why"] and str(raised[0]).startswith(last["why"])
    last, raised = ended(lambda world: None)
    assert last["why"] == "" and raised == []


def test_other_threads_run_while_the_pages_of_a_view_close():
    urls: List[str] = []
    told = threading.Event()
    world = brick()

    def announce(url):
        urls.append(url)
        told.set()

    thread = threading.Thread(target=lambda: world.view(0.3, announce=announce))
    thread.start()
    assert told.wait(60)
    page = Page(urls[0])  # it never reads, so it does not answer that it is closed
    longest, last = 0.0, time.monotonic()
    while thread.is_alive():
        assert world["brick"].position[2] < 0.1
        time.sleep(0.01)
        longest, last = max(longest, time.monotonic() - last), time.monotonic()
    page.line.close()
    assert longest < 0.7  # the view waits for a second


def test_views_of_one_world_do_not_take_each_others_pulls():
    world = brick()
    with Viewed(world) as one, Viewed(world) as other:
        one.ask(do="pull", body=1, at=[0, 0, 0], to=[0, 0, 0.1])
        one.until(lambda m: len(m["pulls"]) == 1)
        other.ask(do="pull", body=1, at=[0, 0, 0], to=[0.1, 0, 0.1])
        one.until(lambda m: len(m["pulls"]) == 2)
        other.ask(do="release")
        left = one.until(lambda m: len(m["pulls"]) == 1)
        assert left["pulls"][0]["to"] == [0, 0, 0.1]


def test_a_port_in_use_is_an_error():
    taken = socket.create_server(("127.0.0.1", 0))
    port = taken.getsockname()[1]
    with pytest.raises(ValueError, match=f"127.0.0.1:{port}"):
        brick().view(0.1, port=port, announce=lambda url: None)
    with pytest.raises(ValueError, match="speed"):
        brick().view(0.1, speed=-1, announce=lambda url: None)


def test_ctrl_c_ends_a_view_and_the_world_goes_on():
    code = (
        "import cloudcontact as cc\n"
        "scene = cc.Scene(step=0.002)\n"
        "scene.add('ball', cc.Sphere(0.01), mass=0.1)\n"
        "world = cc.World(scene, voxel=0.002)\n"
        "world.view()\n"
        "before = world.time\n"
        "world.run(0.1)\n"
        "print('went on', world.time - before)\n"
    )
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stderr is not None
    while "open http://127.0.0.1:" not in child.stderr.readline():
        assert child.poll() is None
    child.send_signal(signal.SIGINT)
    out, _ = child.communicate(timeout=60)
    assert child.returncode == 0
    assert float(out.split()[-1]) == pytest.approx(0.1)


def test_a_replay_is_shown_in_a_notebook(tmp_path):
    replay = brick(0.03).run(0.2, replay=tmp_path / "run.html")
    assert isinstance(replay, cc.Replay) and os.fspath(replay) == str(tmp_path / "run.html")
    frame = replay._repr_html_()
    assert html.unescape(frame.split('srcdoc="')[1].split('"')[0]) == (tmp_path / "run.html").read_text()
    assert 'sandbox="allow-scripts"' in frame
    assert brick().run(0.01) is None
    assert brick().run(0.01, replay=tmp_path / "run.glb") is None
    with pytest.raises(ValueError, match="run.glb"):
        cc.Replay(tmp_path / "run.glb")
