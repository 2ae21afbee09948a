#!/usr/bin/env python3
"""Pours bowls, mugs, rings, hooks and brackets of 10 to 25 cm into a bin, by CloudContact and by Bullet's own methods.

  benchmarks/mixed_pour.py [--program PATH] [--bodies 60] [--steps 60 240] [--methods cloud hacd gimpact] [--seconds 10]

Prints for each run what a step takes (narrow phase and solver, one thread), how much energy the bodies had at most over
their start's, how fast the fastest and the tenth of the bodies that is the fastest are in the last second, and how many
lie in the bin. With --check it fails where bodies gain energy or leave the bin.
"""
import argparse
import csv
import json
import math
import os
import random
import subprocess
import sys
import tempfile

KINDS = ["bowl", "mug", "bracket", "ring", "hook", "small bowl", "small ring"]
BIN = 0.35  # [m] half of its width


def closed(points, faces):
    """The mesh with its faces wound outward."""
    volume = 0.0
    for a, b, c in faces:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = points[a], points[b], points[c]
        volume += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return points, faces if volume > 0 else [(a, c, b) for a, b, c in faces]


def revolved(profile, sectors, lowered):
    """A closed profile of (radius, height) about z."""
    points, rings, faces = [], [], []
    for radius, height in profile:
        count = sectors if radius > 0 else 1
        rings.append([len(points) + k % count for k in range(sectors)])
        for k in range(count):
            angle = 2 * math.pi * k / sectors
            points.append((radius * math.cos(angle), radius * math.sin(angle), height - lowered))
    for ring, next_ring in zip(rings, rings[1:] + rings[:1]):
        for k in range(sectors):
            a, b, c, d = ring[k], ring[(k + 1) % sectors], next_ring[(k + 1) % sectors], next_ring[k]
            faces += [f for f in ((a, b, c), (a, c, d)) if len(set(f)) == 3]
    return closed(points, faces)


def swept(places, ways, radius, sectors, is_ring):
    """A circle along places in the plane of x and z; `ways` point out of their curve."""
    points, faces, count = [], [], len(places)
    for (x, z), (wx, wz) in zip(places, ways):
        for k in range(sectors):
            across, along = radius * math.cos(2 * math.pi * k / sectors), radius * math.sin(2 * math.pi * k / sectors)
            points.append((x + across * wx, along, z + across * wz))
    for i in range(count if is_ring else count - 1):
        for k in range(sectors):
            a, b = i * sectors + k, i * sectors + (k + 1) % sectors
            c, d = (i + 1) % count * sectors + k, (i + 1) % count * sectors + (k + 1) % sectors
            faces += [(a, c, d), (a, d, b)]
    if not is_ring:
        last = (count - 1) * sectors
        for k in range(1, sectors - 1):
            faces += [(0, k, k + 1), (last, last + k + 1, last + k)]
    return closed(points, faces)


def bowl(radius, wall, sectors, rings):
    angles = [i * math.pi / 2 / rings for i in range(rings + 1)]
    outside = [(radius * math.sin(a), -radius * math.cos(a)) for a in angles]
    inside = [((radius - wall) * math.sin(a), (wall - radius) * math.cos(a)) for a in reversed(angles)]
    outside[0], inside[-1] = (0, -radius), (0, wall - radius)
    return revolved(outside + inside, sectors, -0.6 * radius)


def mug(radius, height, wall):
    cup = revolved([(0, 0), (radius, 0), (radius, height), (radius - wall, height), (radius - wall, wall), (0, wall)],
                   24, 0.45 * height)
    angles = [math.pi * (i / 8 - 0.5) for i in range(9)]
    places = [(radius - wall / 2 + 0.27 * height * math.cos(a), height * (0.05 + 0.3 * math.sin(a))) for a in angles]
    handle = swept(places, [(math.cos(a), math.sin(a)) for a in angles], 0.8 * wall, 8, False)
    first = len(cup[0])
    return cup[0] + handle[0], cup[1] + [tuple(first + i for i in face) for face in handle[1]]


def ring(radius, wire, sectors):
    angles = [2 * math.pi * i / sectors for i in range(sectors)]
    ways = [(math.cos(a), math.sin(a)) for a in angles]
    return swept([(radius * x, radius * z) for x, z in ways], ways, wire, 10, True)


def hook(radius, wire, shank):
    angles = [-1.15 * math.pi * i / 17 for i in range(18)]
    places = [(radius, shank * (1 - i / 5)) for i in range(5)]
    places += [(radius * math.cos(a), radius * math.sin(a)) for a in angles]
    points, faces = swept(places, [(1, 0)] * 5 + [(math.cos(a), math.sin(a)) for a in angles], wire, 10, False)
    mx, mz = (sum(p[i] for p in points) / len(points) for i in (0, 2))
    return [(x - mx, y, z - mz) for x, y, z in points], faces


def bracket(leg, wall, width):
    outline = [(0, 0), (leg, 0), (leg, wall), (wall, wall), (wall, leg), (0, leg)]
    points = [(x - 0.3 * leg, y, z - 0.3 * leg) for y in (-width / 2, width / 2) for x, z in outline]
    faces = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces += [tuple(6 + i for i in reversed(face)) for face in faces]
    for i in range(6):
        faces += [(i, i + 6, (i + 1) % 6 + 6), (i, (i + 1) % 6 + 6, (i + 1) % 6)]
    return closed(points, faces)


def write_meshes(folder):
    made = [bowl(0.11, 0.012, 20, 8), mug(0.045, 0.1, 0.008), bracket(0.15, 0.03, 0.06), ring(0.08, 0.015, 28),
            hook(0.05, 0.012, 0.14), bowl(0.07, 0.01, 16, 6), ring(0.04, 0.01, 24)]
    for kind, (points, faces) in zip(KINDS, made):
        with open(os.path.join(folder, kind + ".obj"), "w") as file:
            file.writelines("v %.9g %.9g %.9g\n" % p for p in points)
            file.writelines("f %d %d %d\n" % tuple(i + 1 for i in face) for face in faces)


def model(name, geometry, pose, static):
    return (f"<model name='{name}'><pose>{' '.join('%g' % x for x in pose)}</pose><static>{static}</static>"
            f"<link name='link'><collision name='all'><geometry>{geometry}</geometry>"
            "<surface><friction><ode><mu>0.5</mu></ode></friction></surface></collision></link></model>\n")


def write_scene(path, bodies, seed):
    """Four bodies a layer, turned at random, above a bin of boxes."""
    chance = random.Random(seed)
    box = "<box><size>%g %g %g</size></box>"
    models = [model("floor", box % (2, 2, 0.2), (0, 0, -0.1, 0, 0, 0), "true")]
    for i, (x, y) in enumerate([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        size = (0.1, 2 * BIN + 0.2, 1.2) if x else (2 * BIN + 0.2, 0.1, 1.2)
        models.append(model(f"wall {i}", box % size, ((BIN + 0.05) * x, (BIN + 0.05) * y, 0.6, 0, 0, 0), "true"))
    for i in range(bodies):
        place = [0.16 * (2 * (i % 2) - 1), 0.16 * (2 * (i // 2 % 2) - 1), 0.18 + 0.27 * (i // 4)]
        pose = [x + chance.uniform(-0.02, 0.02) for x in place] + [chance.uniform(-3, 3) for _ in range(3)]
        geometry = f"<mesh><uri>{KINDS[i % len(KINDS)]}.obj</uri></mesh>"
        models.append(model(f"body {i}", geometry, pose, "false"))
    with open(path, "w") as file:
        file.write("<sdf version='1.9'><world name='pour'><gravity>0 0 -9.81</gravity>\n" + "".join(models) +
                   "</world></sdf>\n")


def last_second(path, seconds):
    """Speeds of the bodies' fastest moments in it, slowest first, and how many end in the bin."""
    fastest, inside = {}, set()
    with open(path) as file:
        for row in csv.DictReader(file):
            if float(row["time"]) < seconds - 1 or not row["body"].startswith("body"):
                continue
            speed = math.hypot(float(row["vx"]), float(row["vy"]), float(row["vz"]))
            fastest[row["body"]] = max(speed, fastest.get(row["body"], 0))
            isin = max(abs(float(row["x"])), abs(float(row["y"]))) < BIN and float(row["z"]) > 0
            (inside.add if isin else inside.discard)(row["body"])
    return sorted(fastest.values()), len(inside)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--program", default="build-release/demos/cloudcontact")
    options.add_argument("--bodies", type=int, default=60)
    options.add_argument("--steps", type=float, nargs="+", default=[60, 240], help="steps a second")
    options.add_argument("--methods", nargs="+", default=["cloud", "hacd", "gimpact"])
    options.add_argument("--seconds", type=float, default=10)
    options.add_argument("--seed", type=int, default=5)
    options.add_argument("--check", action="store_true")
    options = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        scene, trajectory = os.path.join(folder, "pour.sdf"), os.path.join(folder, "run.csv")
        write_meshes(folder)
        write_scene(scene, options.bodies, options.seed)
        print("method      Hz  narrow [ms]  solver [ms]  gained [J]  fastest  a tenth above [mm/s]  in the bin")
        for rate in options.steps:
            for method in options.methods:
                run = subprocess.run([options.program, "simulate", scene, "--method", method, "--threads", "1", "--step",
                                      str(1 / rate), "--seconds", str(options.seconds), "--trajectory", trajectory,
                                      "--json"], check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
                result = json.loads(run.stdout)
                per_step = 1e3 / result["steps"]
                speeds, inside = last_second(trajectory, options.seconds)
                print("%-8s %5g %12.2f %12.2f %11.2f %8.1f %21.1f %11d" % (
                    method, rate, per_step * result["narrowPhaseSeconds"], per_step * result["solverSeconds"],
                    result["energyMax"] - result["energyStart"], 1e3 * speeds[-1], 1e3 * speeds[int(0.9 * len(speeds))],
                    inside), flush=True)
                gained = result["energyMax"] > result["energyStart"] * (1 + 1e-6)
                if options.check and (gained or inside < options.bodies):
                    sys.exit(f"{method} at {rate:g} Hz: bodies {'gained energy' if gained else 'left the bin'}")


if __name__ == "__main__":
    main()
