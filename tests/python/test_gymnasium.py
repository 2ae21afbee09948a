"""The environment of the guide to learning, with gymnasium from PyPI: a thousand episodes, the same to the bit."""

import os
import pathlib
import subprocess
import sys

from test_guides import samples

RUN = """
import hashlib
import numpy as np
from gymnasium.utils.env_checker import check_env

env = Insertion()
check_env(env, skip_render_check=True)


def episode(seed):
    seen, _ = env.reset(seed=seed)
    random = np.random.default_rng(seed)
    rows = [seen]
    for step in range(60):
        action = random.uniform(-1, 1, 3)
        action[2] = -1
        if step > 15:
            action[:2] = np.clip(-seen[:2] / 5e-4, -1, 1)
        seen, reward, done, cut, _ = env.step(action)
        rows.append(seen)
        if done:
            break
    return done, np.array(rows)


episodes = [episode(seed) for seed in range(1000)]
again = [episode(seed) for seed in range(0, 1000, 50)]
assert all(np.array_equal(rows, episodes[50 * k][1]) for k, (_, rows) in enumerate(again))
print(sum(done for done, _ in episodes), hashlib.sha256(b"".join(rows.tobytes() for _, rows in episodes)).hexdigest())
"""


def test_a_thousand_episodes(tmp_path):
    subprocess.run([sys.executable, "-m", "venv", "--system-site-packages", tmp_path / "tools"], check=True)
    subprocess.run([tmp_path / "tools" / "bin" / "pip", "-q", "install", "gymnasium"], check=True)
    parts = samples("docs/guides/learning.md")
    script = tmp_path / "run.py"
    script.write_text("\n".join([parts[0], parts[1], RUN]))
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(p for p in sys.path if pathlib.Path(p).name == "python"))

    def run():
        return subprocess.run(
            [tmp_path / "tools" / "bin" / "python", script], check=True, capture_output=True, text=True, env=environment
        ).stdout.split()

    home, bits = run()
    assert int(home) == 1000
    assert run() == [home, bits]
