"""The files of docs/studies.md, and what the tests of studies share."""

import os
import pathlib
import re
import sqlite3
import subprocess
import sys
import time

import cloudcontact as cc
from cloudcontact import study

SOURCE = pathlib.Path(__file__).parents[2]
GUIDE = (SOURCE / "docs/studies.md").read_text()
TRIALS = 24
COMMAND = [sys.executable, "-m", "cloudcontact.study"]


def sample(name):
    """The text of a file in the guide."""
    found = re.findall(r"`%s`[^`]*```\w+\n(.*?)```" % re.escape(name), GUIDE, re.S)
    assert found, name
    return found[0]


def write_pegs(folder, offsets=6, clearances=4):
    """peg.sdf and pegs.toml with fewer trials; the study's file."""
    (folder / "peg.sdf").write_text(sample("peg.sdf"))
    text = (
        sample("pegs.toml").replace("count = 40", f"count = {offsets}").replace("count = 25", f"count = {clearances}")
    )
    (folder / "pegs.toml").write_text(text)
    return folder / "pegs.toml"


def start(*words, **more):
    """The command as a process of its own."""
    return subprocess.Popen(
        [*COMMAND, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more
    )


def command(*words, **more):
    """Runs the command: exit code, stdout, stderr."""
    done = start(*words, **more)
    out, error = done.communicate(timeout=240)
    return done.returncode, out, error


def rows_done(path):
    try:
        with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as database:
            return database.execute("SELECT count(*) FROM trials WHERE status IS NOT NULL").fetchone()[0]
    except sqlite3.Error:
        return 0


def wait_for_rows(path, least, process):
    """Until a study that runs has written some rows."""
    end = time.monotonic() + 120
    while rows_done(path) < least:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end, "no rows after two minutes"
        time.sleep(0.02)


def descendants(pid):
    """Processes that a process has started, directly or not."""
    out = []
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            out += [int(stat.parent.name), *descendants(int(stat.parent.name))]
    return out


def one_by_one(folder):
    """The digest of all pegs, run one after the other."""
    with study.load(write_pegs(folder)).run(folder / "pegs.sqlite", "local:1", progress=False) as results:
        assert results.counts == {"done": TRIALS}
        return results.digest()


def check(path, digest):
    """All rows are there, each once, and equal to the bit."""
    with study.Results(path) as results:
        assert results.counts == {"done": TRIALS}
        numbers = [n for n, in results.database.execute("SELECT number FROM trials ORDER BY number")]
        logged = [n for n, in results.database.execute("SELECT number FROM log ORDER BY number")]
        assert numbers == logged == list(range(TRIALS))
        assert results.digest() == digest
    assert not path.with_name(path.name + ".lock").exists()


# Trial functions.


def kills_itself(way):
    if way == "killed":
        os.kill(os.getpid(), 9)
    if way == "exits":
        os._exit(3)
    if way == "raises":
        print("about to raise")
        raise KeyError("no such thing")
    if way == "sleeps":
        time.sleep(60)
    return {"pid": os.getpid(), "way_was": way}


def dies_once(file, n):
    """Ends its process the first time that it runs."""
    mark = pathlib.Path(f"{file}.{n}")
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), 9)
    return {"square": n**2}


def square(n, seed):
    return {"square": n**2, "seeded": seed, "list": [1, 2.5, True], "four": [1, 2, 3, 4], "none": None}


def brick_scene(height, friction=0.5):
    scene = cc.Scene("brick")
    scene.add("floor", cc.HalfSpace(), static=True, friction=friction)
    scene.add("brick", cc.Box((0.02, 0.015, 0.01)), (0, 0, 0.01 + height), mass=0.2, friction=friction)
    return scene
