# Plots the growth of a step's time from scale's JSON: growth.py SCALE.json OUT (writes OUT.svg and OUT.png).
import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

plt.rcParams.update({"font.family": "DejaVu Sans", "font.size": 9, "svg.hashsalt": "cloudcontact", "svg.fonttype": "none"})


def panel(axis, data, count, label):
    """Times over a count, with a fitted line, compared with convex parts."""
    rows = data["byBodies"]
    x = [row[count] for row in rows]
    fits = data["byBodiesExponents"]
    for name, key, color in (("whole step", "stepSeconds", "#0072b2"), ("narrow phase", "narrowPhaseSeconds", "#56b4e9")):
        slope = fits[key][count]
        y = [1e3 * row[key] for row in rows]
        axis.loglog(x, y, "o", color=color, label=f"{name}: exponent {slope:.2f}")
        middle = len(x) // 2
        axis.loglog(x, [y[middle] * (v / x[middle]) ** slope for v in x], color=color, lw=1)
    parts = data.get("hacd", [])
    if parts:
        axis.loglog([row[count] for row in parts], [1e3 * row["stepSeconds"] for row in parts], "v", color="#cc79a7",
                    label=f"{data['hacdParts']} convex parts (HACD)")
    axis.set_xlabel(label)
    axis.grid(alpha=0.25)


def voxels(axis, data):
    rows = data["byVoxels"]
    x = [row["bandVoxels"] for row in rows]
    y = [1e3 * row["narrowPhaseSeconds"] for row in rows]
    slope = data["byVoxelsExponents"]["narrowPhaseSeconds"]["bandVoxels"]
    axis.loglog(x, y, "o-", color="#56b4e9", lw=1, label=f"narrow phase: exponent {slope:.2f}")
    for row, v, t in zip(rows, x, y):
        axis.annotate(f"{1e3 * row['voxel']:g} mm, {row['fieldBytes'] / 1e6:.1f} MB", (v, t), textcoords="offset points",
                      xytext=(0, 7), ha="center", fontsize=8)
    axis.set_xlabel("surface voxels of a nut (100 nuts)")
    axis.margins(x=0.25, y=0.3)
    axis.grid(alpha=0.25)


def main():
    with open(sys.argv[1]) as file:
        data = json.load(file)
    figure, axes = plt.subplots(1, 4, figsize=(15, 4.4))
    for axis, (count, label) in zip(axes, (("bodies", "bodies"), ("pairs", "touching pairs"), ("contacts", "contact points"))):
        panel(axis, data, count, label)
    voxels(axes[3], data)
    axes[0].set_ylabel("milliseconds")
    for axis in axes:
        axis.set_ylim(top=axis.get_ylim()[1] * 6)
        axis.legend(loc="upper left", fontsize=7.5)
    threads = data["threads"]
    figure.suptitle(f"M16 nuts in a box, ten layers deep, voxels of {1e3 * data['byBodies'][0]['voxel']:g} mm, {threads} "
                    f"thread{'s' if threads > 1 else ''}: time of a step; one field of "
                    f"{data['bytesPerBandVoxel']:.0f} bytes per surface voxel serves all nuts", fontsize=11)
    figure.tight_layout()
    figure.savefig(sys.argv[2] + ".svg", metadata={"Date": None})
    figure.savefig(sys.argv[2] + ".png", dpi=110)


main()
