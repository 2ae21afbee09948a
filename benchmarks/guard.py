#!/usr/bin/env python3
"""Times of an earlier commit and of this checkout side by side, for script/bench --guard.

The earlier commit is built in a git worktree below build-guard, which stays for the next run (git worktree remove
build-guard/before ends it). Both programs run in turns on this machine; each time is the least of its turns.
  CPU: the list of benchmarks/work.json, the narrow phase of a step or a query, beside the same bodies as GImpact meshes
    and beside reading the looked up bytes from memory.
  --device: one step of a batch on an OpenCL device, kernel by kernel, beside the bound of the device's peak speeds.
"""
import argparse
import datetime
import json
import math
import os
import re
import shutil
import subprocess
import sys

HERE = os.path.realpath(os.path.join(os.path.dirname(__file__), ".."))
PLACE = os.path.join(HERE, "build-guard")


def output(*words, cwd=HERE):
    return subprocess.run(words, cwd=cwd, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()


def tree_of(commit):
    """The commit's files."""
    tree = os.path.join(PLACE, "before")
    if os.path.exists(os.path.join(tree, ".git")):
        output("git", "checkout", "--quiet", "--force", "--detach", commit, cwd=tree)
    else:
        output("git", "worktree", "prune")
        output("git", "worktree", "add", "--quiet", "--force", "--detach", tree, commit)
    return tree


def built(tree, build, target, device):
    """The path of a program of a tree."""
    options = ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCLOUDCONTACT_LAB=ON", "-DCLOUDCONTACT_OPENCL=ON"]
    if device: options.append("-DCLOUDCONTACT_BENCHMARKS=ON")
    if not os.path.exists(os.path.join(build, "CMakeCache.txt")):
        options += ["-DCLOUDCONTACT_TESTS=OFF", "-DCLOUDCONTACT_INSTALL=OFF", "-DCLOUDCONTACT_PYTHON=OFF"]
        if shutil.which("ccache"): options.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    output("cmake", "-S", tree, "-B", build, *options)
    if not re.search(rf"^{target}:", output("cmake", "--build", build, "--target", "help"), re.M):
        sys.exit(f"guard: the commit has no program {target}; name a later one by --against COMMIT")
    print(f"building {target} in {os.path.relpath(build, HERE)} ...", file=sys.stderr)
    subprocess.run(["cmake", "--build", build, "--target", target], check=True, stdout=sys.stderr)
    return os.path.join(build, "benchmarks" if device else "demos", target)


def least(known, more):
    """The least of two tables of times, number by number; 0 is not measured."""
    for name, numbers in more.items():
        row = known.setdefault(name, dict(numbers))
        for key, value in numbers.items():
            if value > 0: row[key] = min(row.get(key) or value, value)
    return known


def processor_times(program, gimpact, only):
    file = os.path.join(PLACE, "times.json")
    words = [program, "--times", file, "--checkout", HERE, "--only", only]
    subprocess.run(words + (["--gimpact"] if gimpact else []), check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    with open(file) as text: return json.load(text)


def kernel_times(program, words):
    """By the table that the program gpu prints."""
    text = output(program, *words)
    rows = re.findall(r"^(\S.*?) +([\d.]+) +([\d.]+) +[\d.]+%  \S+$", text, re.M)
    times = {name: {"us": float(us), "bound": float(bound)} for name, us, bound in rows}
    times["all kernels and copies"] = {"us": float(re.search(r"^total +([\d.]+)", text, re.M)[1])}
    step = re.search(r"OpenCL ([\d.]+) ms .*one core ([\d.]+) ms", text)
    times["a step"] = {"us": 1e3 * float(step[1])}
    times["a step on one core"] = {"us": 1e3 * float(step[2])}
    return text.split("\n")[0], times


def ratio(over, under):
    return over / under if over and under else math.nan


def number(value, digits=2):
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def table(before, now, columns):
    """`columns`: (heading, function of a row of `now`)."""
    print(f"{'':44} {'before us':>11} {'now us':>11} {'now/before':>11}" + "".join(f" {c:>11}" for c, _ in columns))
    ratios = []
    for name, row in now.items():
        was = before.get(name, {}).get("us", 0)
        grown = ratio(row["us"], was)
        if not math.isnan(grown): ratios.append(grown)
        mark = "  slower" if grown > 1.1 else "  faster" if grown < 0.9 else ""
        print(f"{name:44} {was:11.2f} {row['us']:11.2f} {number(grown):>11}" +
              "".join(f" {number(of(row)):>11}" for _, of in columns) + mark)
    if ratios:
        mean = math.exp(sum(map(math.log, ratios)) / len(ratios))
        print(f"{'geometric mean':44} {'':11} {'':11} {mean:11.2f}")


def processor():
    with open("/proc/cpuinfo") as file: names = re.findall(r"^model name\s*: (.*)$", file.read(), re.M)
    return names[0] if names else "unknown"


def two_digits(value):
    return f"{float(f'{value:.2g}'):g}"


def renew_figures(file, times, commit, where):
    """Figures of documents that name an entry of this list, measured now."""
    with open(file) as text: all_figures = json.load(text)
    for figure in all_figures["figures"]:
        row = times.get(figure.get("entry"))
        if not row: continue
        kind = figure["kind"]
        value = ratio(row.get("gimpact", 0), row["us"]) if kind == "times GImpact" else row.get(kind, 0)
        if not value or math.isnan(value): continue
        text = f"{two_digits(value)} times" if kind == "times GImpact" else \
            f"{two_digits(1e-3 * value)} ms" if value >= 100 else f"{two_digits(value)} us"
        figure.update(text=text, date=datetime.date.today().isoformat(), processor=where, commit=commit)
    with open(file, "w") as text: text.write(json.dumps(all_figures, indent=1) + "\n")


def main():
    words = argparse.ArgumentParser(prog="script/bench --guard", description=__doc__.split("\n")[0])
    words.add_argument("--against", default="HEAD~1", help="the earlier commit")
    words.add_argument("--turns", type=int, default=3)
    words.add_argument("--only", default="", help="a part of the names of what is timed")
    words.add_argument("--device", action="store_true", help="kernels on an OpenCL device")
    words.add_argument("--figures", help="also renews the figures of this file")
    words.add_argument("gpu", nargs="*", help="after --: options of benchmarks/gpu, with --device")
    how = words.parse_args()
    commit = output("git", "rev-parse", "--verify", how.against + "^{commit}")
    os.makedirs(PLACE, exist_ok=True)
    target = "gpu" if how.device else "cloudcontact-work"
    now_program = built(HERE, os.path.join(HERE, "build-release"), target, how.device)
    before_program = built(tree_of(commit), os.path.join(PLACE, "build"), target, how.device)
    before, now, where = {}, {}, processor()
    for turn in range(how.turns):
        if how.device:
            where, times = kernel_times(before_program, how.gpu)
            before = least(before, times)
            now = least(now, kernel_times(now_program, how.gpu)[1])
        else:
            before = least(before, processor_times(before_program, False, how.only))
            now = least(now, processor_times(now_program, turn == how.turns - 1, how.only))
    head = output("git", "describe", "--always", "--dirty")
    print(f"\nbefore: {commit[:12]}; now: {head}; {datetime.date.today()}; {where}\n")
    if how.device:
        table(before, now, [("bound us", lambda row: row.get("bound", math.nan)),
                            ("now/bound", lambda row: ratio(row["us"], row.get("bound", 0)))])
    else:
        table(before, now, [("GImpact/now", lambda row: ratio(row["gimpact"], row["us"])),
                            ("now/gather", lambda row: ratio(row["us"], row["gather"]))])
    if how.figures: renew_figures(how.figures, now, head, where)


if __name__ == "__main__":
    main()
