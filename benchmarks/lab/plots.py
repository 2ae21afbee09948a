# Draws the laboratory's pictures from its JSON files: plots.py FOLDER. `cloudcontact chart` runs it.
import json
import math
import os
import sys
import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

# Colors of Okabe and Ito, for color-blind readers.
STYLES = {
    "cloud": ("#0072b2", "o", "CloudContact"),
    "paper": ("#000000", "p", "CloudContact, base vectors"),
    "primitive": ("#999999", "s", "Bullet's primitives"),
    "gjk": ("#009e73", "^", "Bullet GJK/EPA on the hull"),
    "gimpact": ("#d55e00", "D", "Bullet GImpact"),
    "hacd": ("#cc79a7", "v", "Bullet, HACD parts"),
    "sdf": ("#56b4e9", "P", "Bullet btSdf"),
    "fcl": ("#e69f00", "X", "FCL"),
    "ode": ("#a6761d", "<", "ODE"),
    "mujoco": ("#7570b3", ">", "MuJoCo"),
}
plt.rcParams.update({"font.family": "DejaVu Sans", "font.size": 9, "svg.hashsalt": "cloudcontact", "svg.fonttype": "none"})


def style(method):
    return STYLES.get(method, ("#000000", "*", method))


def span(times):
    """"25" or "3 to 25"."""
    low, high = (f"{t:.0f}" if t >= 9.5 else f"{t:.2g}" for t in (min(times), max(times)))
    return low if low == high else f"{low} to {high}"


def save(figure, folder, name):
    figure.savefig(os.path.join(folder, name + ".svg"), metadata={"Date": None})
    figure.savefig(os.path.join(folder, name + ".png"), dpi=110)
    plt.close(figure)


def panels(count, height):
    columns = min(3, count)
    rows = math.ceil(count / columns)
    figure, axes = plt.subplots(rows, columns, figsize=(max(9.5, 4.3 * columns), height * rows + 1.4), squeeze=False)
    flat = [axis for row in axes for axis in row]
    for axis in flat[count:]:
        axis.axis("off")
    return figure, flat[:count]


def chart(folder, data, field, floor, label, title, name):
    families = list(dict.fromkeys(mark["family"] for mark in data["families"]))
    if not families:  # a run of stability scenes only
        figure = plt.figure(figsize=(9.5, 0.8))
        figure.text(0.01, 0.5, "No reference case was run.", fontsize=11, va="center")
        return save(figure, folder, name)
    figure, axes = panels(len(families), 3.5)
    used = []
    for family, axis in zip(families, axes):
        marks = [m for m in data["families"] if m["family"] == family and m["cases"] > 0 and m.get(field) is not None]
        for method in STYLES:
            own = [m for m in marks if m["method"] == method]
            if not own:
                continue
            used.append(method)
            color, shape, _ = style(method)
            whole = [m for m in own if m["cannot"] == 0]
            part = [m for m in own if m["cannot"] > 0]
            wrong = [m for m in own if m["wrong"] > 0]
            line = sorted(whole, key=lambda m: m["microseconds"])
            if method == "cloud":
                axis.plot([m["microseconds"] for m in line], [max(floor, m[field]) for m in line], color=color, lw=1, alpha=0.5)
            for group, face in ((whole, color), (part, "white")):
                axis.scatter([m["microseconds"] for m in group], [max(floor, m[field]) for m in group], s=42, marker=shape,
                             color=face, edgecolors=color, linewidths=1.3, zorder=3)
            axis.scatter([m["microseconds"] for m in wrong], [max(floor, m[field]) for m in wrong], s=70, marker="x", color="#c00000", linewidths=1.4, zorder=4)
            if method in ("cloud", "paper"):  # voxels in the size, radius of the window
                for m in line:
                    axis.annotate(m["setting"].replace("/", " ").split()[-1], (m["microseconds"], max(floor, m[field])), textcoords="offset points",
                                  xytext=(5, 4), fontsize=7, color=color)
        front = sorted((m for m in marks if m["frontier"]), key=lambda m: m["microseconds"])
        if field == "normalDeg" and front:
            axis.step([m["microseconds"] for m in front], [max(floor, m[field]) for m in front], where="post", color="#444444", lw=0.9, ls="--", zorder=1)
        able = {m["method"] for m in data["families"] if m["family"] == family and m["cases"] > 0}
        cannot = sorted({style(m["method"])[2] for m in data["families"] if m["family"] == family} - {style(m)[2] for m in able})
        notes = ["cannot: " + ", ".join(cannot)] if cannot else []
        deep = {}
        for m in data["families"]:
            if m["family"] == family and m["depthTimes"] > 0:
                deep.setdefault(m["method"], []).append(m["depthTimes"])
        notes += [f"{style(m)[2]}: {span(times)} times the true depth" for m, times in deep.items()]
        if notes:
            text = "\n".join(line for note in notes for line in textwrap.wrap(note, 62))
            axis.text(0.0, -0.26, text, transform=axis.transAxes, fontsize=6.5, color="#666666", va="top")
        cases = max((m["cases"] + m["cannot"] for m in data["families"] if m["family"] == family), default=0)
        axis.set_title(f"{family} ({cases} case{'s' if cases != 1 else ''})", fontsize=10, loc="left", fontweight="bold")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.grid(True, which="major", color="#dddddd", lw=0.6)
        axis.set_axisbelow(True)
        axis.margins(0.12)
        for side in ("top", "right"):
            axis.spines[side].set_visible(False)
    for axis in axes:
        axis.set_xlabel("time of the narrow phase [\u00b5s]")
        axis.set_ylabel(label)
    handles = [Line2D([], [], color=style(m)[0], marker=style(m)[1], ls="", label=style(m)[2]) for m in STYLES if m in used]
    handles.append(Line2D([], [], color="#666666", marker="o", markerfacecolor="white", ls="", label="hollow: answers some of the cases"))
    if any(m["wrong"] > 0 for m in data["families"]):
        handles.append(Line2D([], [], color="#c00000", marker="x", ls="", label="wrong depth or missed contact"))
    if field == "normalDeg":
        handles.append(Line2D([], [], color="#444444", ls="--", label="frontier"))
    figure.suptitle(title, fontsize=13, fontweight="bold", x=0.01, ha="left", y=0.995)
    figure.legend(handles=handles, loc="lower center", ncol=5, frameon=False, fontsize=8.5)
    figure.tight_layout(rect=(0, 0.02 + 0.22 / figure.get_figheight() * 3, 1, 0.985))
    save(figure, folder, name)


def failures(folder, data):
    rows = data["rows"]
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    columns = sorted({(row["method"], row["mode"], row["step"]) for row in rows},
                     key=lambda c: (list(STYLES).index(c[0]) if c[0] in STYLES else 99, c[1], -c[2]))
    cells = {(row["scene"], (row["method"], row["mode"], row["step"])): row for row in rows}
    colors = {"holds": "#4c9f70", "fails": "#d1495b", "cannot": "#c9ccd3"}
    figure, axis = plt.subplots(figsize=(3.4 + 0.62 * len(columns), 1.9 + 0.27 * len(scenes)))
    for y, scene in enumerate(scenes):
        for x, column in enumerate(columns):
            row = cells.get((scene, column))
            if row is None:
                continue
            axis.add_patch(plt.Rectangle((x + 0.04, y + 0.06), 0.92, 0.88, color=colors[row["outcome"]]))
            figure_text = "\u221e" if row["figure"] is None else f"{row['figure']:.2g}"  # JSON has no infinity
            text = "\u2013" if row["outcome"] == "cannot" else figure_text
            axis.text(x + 0.5, y + 0.52, text, ha="center", va="center", fontsize=6.5, color="#333333" if row["outcome"] == "cannot" else "white")
    axis.set_xlim(0, len(columns))
    axis.set_ylim(len(scenes), 0)
    axis.set_yticks([y + 0.5 for y in range(len(scenes))], scenes, fontsize=8)
    axis.set_xticks([x + 0.5 for x in range(len(columns))], [f"{m}\n{mode}\n{1 / step:.0f} Hz" for m, mode, step in columns], fontsize=6.5)
    axis.xaxis.tick_top()
    axis.tick_params(length=0)
    for spine in axis.spines.values():
        spine.set_visible(False)
    last = None
    for x, column in enumerate(columns):
        if last is not None and column[0] != last:
            axis.axvline(x, color="#555555", lw=0.8)
        last = column[0]
    figure.suptitle("Stability: what holds, what fails", fontsize=13, fontweight="bold", x=0.01, ha="left", y=0.995)
    figure.legend(handles=[Patch(color=colors["holds"], label="holds"), Patch(color=colors["fails"], label="fails"),
                           Patch(color=colors["cannot"], label="cannot"), Patch(color="white", label="numbers: units and limits in failures.json"),
                           Patch(color="white", label="cloud and paper: NewtonSolver, others: Bullet's solver, ten iterations each")],
                  loc="lower left", ncol=5, frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0.03, 1, 0.98))
    save(figure, folder, "failures")


def running(folder, rows):
    """What a step of a running scene costs, by method: the best trial that holds, else the best that fails."""
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    figure, axes = panels(len(scenes), 2.6)
    used = []
    for scene, axis in zip(scenes, axes):
        bars = []
        for method in STYLES:
            own = [row for row in rows if row["scene"] == scene and row["method"] == method and row["steps"] > 0]
            holding = [row for row in own if row["outcome"] == "holds"]
            if own:
                bars.append((method, bool(holding), min(holding or own, key=lambda row: row["narrowPhaseMicroseconds"])))
        for y, (method, holds, row) in enumerate(bars):
            color, _, name = style(method)
            used.append(method)
            axis.barh(y, row["narrowPhaseMicroseconds"], color=color if holds else "white", edgecolor=color, linewidth=1.3,
                      hatch="" if holds else "////", height=0.7)
            axis.plot([row["stepMicroseconds"]] * 2, [y - 0.35, y + 0.35], color="#222222", lw=1.6)
            axis.text(row["stepMicroseconds"] * 1.12, y, f"{row['mode']}, {1 / row['step']:.0f} Hz" + ("" if holds else ", fails"), fontsize=7, va="center")
        axis.set_yticks(range(len(bars)), [style(method)[2] for method, _, _ in bars], fontsize=8)
        axis.invert_yaxis()
        axis.set_xscale("log")
        costs = [row[key] for _, _, row in bars for key in ("narrowPhaseMicroseconds", "stepMicroseconds") if row[key] > 0]
        if costs:
            axis.set_xlim(min(costs) / 2, max(costs) * 12)
        axis.grid(True, axis="x", which="major", color="#dddddd", lw=0.6)
        axis.set_axisbelow(True)
        axis.set_title(scene, fontsize=10, loc="left", fontweight="bold")
        axis.set_xlabel("time a step [\u00b5s]")
        for side in ("top", "right"):
            axis.spines[side].set_visible(False)
    handles = [Patch(facecolor="#888888", edgecolor="#888888", label="narrow phase, where the scene holds"),
               Patch(facecolor="white", edgecolor="#888888", hatch="////", label="narrow phase, where it fails at every setting"),
               Line2D([], [], color="#222222", lw=1.6, label="whole step")]
    figure.suptitle("Running scenes: what a step costs", fontsize=13, fontweight="bold", x=0.01, ha="left", y=0.995)
    figure.legend(handles=handles, loc="lower center", ncol=3, frameon=False, fontsize=8.5)
    figure.tight_layout(rect=(0, 0.02 + 0.22 / figure.get_figheight(), 1, 0.985))
    save(figure, folder, "running")


def main():
    folder = sys.argv[1]
    with open(os.path.join(folder, "chart.json"), encoding="utf-8") as file:
        data = json.load(file)
    chart(folder, data, "normalDeg", 1e-3, "mean error of the normal [deg]", "Error of the contact normal against time", "chart")
    chart(folder, data, "wrench", 1e-5, "relative error of force or torque", "Error of force and torque against time", "chart_force")
    if os.path.exists(os.path.join(folder, "failures.json")):
        with open(os.path.join(folder, "failures.json"), encoding="utf-8") as file:
            data = json.load(file)
        if data["rows"]:
            failures(folder, data)
        timed = [row for row in data["rows"] if row["timed"]]
        if any(row["steps"] > 0 for row in timed):
            running(folder, timed)


main()
