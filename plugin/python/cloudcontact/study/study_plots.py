"""Plots of a study: where it succeeds, and how contact forces are distributed. They need matplotlib."""

from __future__ import annotations

import importlib
import os
import re
from typing import Any, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from .errors import StudyError, meant
from .results import Column, Results
from .summary import bins_of

YES, NO, NONE = "#1f77b4", "#e6862a", "#d0d0d0"
PREFIXES = ((1.0, ""), (1e3, "m"), (1e6, "\u00b5"))
LEAST = 0.1  # of the largest value of an axis, in its unit
BARS = 30
MOST_CLASSES, IN_CLASS = 10, 8  # of a parameter; trials in each, at least
Doubles = npt.NDArray[np.float64]
File = Union[None, str, "os.PathLike[str]"]


def new_figure(width: float, height: float) -> Any:
    try:
        return importlib.import_module("matplotlib.figure").Figure(figsize=(width, height), layout="constrained")
    except ImportError:
        raise StudyError("plots need matplotlib: pip install matplotlib") from None


def saved(figure: Any, file: File) -> Any:
    if file is not None:
        figure.savefig(file, dpi=120)
    return figure


class Axis:
    """A column as an axis: numbers in a unit that suits their size, or texts at 0, 1, 2 ..."""

    def __init__(self, name: str, values: Column, unit: str) -> None:
        self.ticks: Optional[list[str]] = None
        if values.dtype == object:
            texts, places = np.unique(values.astype(str), return_inverse=True)
            self.ticks, self.values = list(texts), places.astype(float)
            self.label = name
            return
        factor, prefix = 1.0, ""
        largest = max(np.abs(values[np.isfinite(values)]), default=0.0)
        for factor, prefix in PREFIXES if unit and unit != "rad" else PREFIXES[:1]:
            if largest * factor >= LEAST:
                break
        if largest == 0:
            factor, prefix = 1.0, ""
        self.values = values * factor
        self.label = f"{name} [{prefix}{unit}]" if unit else name

    def mark(self, axis: Any) -> None:
        axis.set_label_text(self.label.replace("_", " "))
        if self.ticks is not None:
            axis.set_ticks(range(len(self.ticks)), self.ticks)


def axis_of(results: Results, columns: dict[str, Column], name: str) -> Axis:
    if name not in columns:
        raise StudyError(f"plot: no column '{name}'{meant(name, columns)}")
    return Axis(name, columns[name], results.unit(name))


def first_of(results: Results) -> str:
    """The first parameter that varies, or the first."""
    if not results.parameters:
        raise StudyError("plot: the study has no parameters, over which to draw")
    return (results.varied or results.parameters)[0]


def edges_of(middles: Doubles) -> Doubles:
    """Between values, and as far beyond the outer ones."""
    if len(middles) == 1:
        return np.array([middles[0] - 0.5, middles[0] + 0.5])
    inner = (middles[1:] + middles[:-1]) / 2
    return np.array([2 * middles[0] - inner[0], *inner, 2 * middles[-1] - inner[-1]])


def shares(x: Doubles, y: Doubles, success: Doubles) -> Optional[tuple[Doubles, Doubles, Doubles]]:
    """Of success on a grid of x and y, (len(y), len(x)); none where they make no grid."""
    xs, ys = np.unique(x), np.unique(y)
    if len(xs) * len(ys) > len(x):
        return None
    column, row = np.searchsorted(xs, x), np.searchsorted(ys, y)
    ended = np.isfinite(success)
    sums, counts = np.zeros((len(ys), len(xs))), np.zeros((len(ys), len(xs)))
    np.add.at(sums, (row[ended], column[ended]), success[ended])
    np.add.at(counts, (row, column), 1)
    if (counts == 0).any():
        return None
    runs = np.zeros_like(counts)
    np.add.at(runs, (row[ended], column[ended]), 1)
    return xs, ys, np.where(runs > 0, sums / np.maximum(runs, 1), np.nan)


def success_over_one(axes: Any, x: Axis, success: Doubles) -> None:
    ended = np.isfinite(success)
    rows = [
        (x.values[ended & who].mean(), success[ended & who].mean())
        for _, who in bins_of(x.values, 20)
        if (ended & who).any()
    ]
    axes.plot(*zip(*rows), "o-", color=YES)
    axes.set_ylabel("share of trials that succeed")
    axes.set_ylim(-0.03, 1.03)


def success_over_two(figure: Any, axes: Any, x: Axis, y: Axis, success: Doubles) -> None:
    grid = shares(x.values, y.values, success)
    if grid is not None and np.isin(grid[2][np.isfinite(grid[2])], (0, 1)).all():
        colors = importlib.import_module("matplotlib.colors").ListedColormap([NO, YES])
        axes.pcolormesh(edges_of(grid[0]), edges_of(grid[1]), grid[2], cmap=colors, vmin=0, vmax=1)
        axes.set_facecolor(NONE)
        legend(axes, bool(np.isnan(grid[2]).any()), "s")
    elif grid is not None:
        drawn = axes.pcolormesh(edges_of(grid[0]), edges_of(grid[1]), grid[2], cmap="viridis", vmin=0, vmax=1)
        axes.set_facecolor(NONE)
        figure.colorbar(drawn, ax=axes, label="share of trials that succeed")
    else:
        for which, color, marker in ((success == 0, NO, "x"), (success == 1, YES, "o"), (np.isnan(success), NONE, ".")):
            axes.scatter(x.values[which], y.values[which], color=color, marker=marker, s=22)
        legend(axes, bool(np.isnan(success).any()), "ox.")


def legend(axes: Any, some_open: bool, markers: str) -> None:
    """What the colors mean, above the axes. markers: of success, failure and no result."""
    line = importlib.import_module("matplotlib.lines").Line2D
    kinds = [("succeeds", YES), ("does not succeed", NO)] + ([("no result", NONE)] if some_open else [])
    marks = [
        line([], [], linestyle="", marker=markers[min(i, len(markers) - 1)], color=color, markersize=8, label=label)
        for i, (label, color) in enumerate(kinds)
    ]
    axes.legend(
        handles=marks,
        loc="lower right",
        bbox_to_anchor=(1, 1),
        ncol=len(kinds),
        frameon=False,
        columnspacing=1,
        handletextpad=0,
    )


def plot_success(results: Results, x: Optional[str] = None, y: Optional[str] = None, file: File = None) -> Any:
    """Success over one or two parameters: a map where they make a grid, else a mark for each trial.

    x, y: names; none: the first two that vary. file: to save it in (.png, .svg, .pdf). Returns matplotlib's
    Figure. Raises StudyError where the study states no success or a name is not known.
    """
    names = [name for name in (x, y) if name] or results.varied[:2] or [first_of(results)]
    columns = results.columns(None)
    success = columns.get("success")
    if success is None:
        raise StudyError("plot: no trial states success; state it in the study")
    axes_of = [axis_of(results, columns, name) for name in names]
    figure = new_figure(6.4, 4.8)
    axes = figure.subplots()
    if len(axes_of) == 1:
        success_over_one(axes, axes_of[0], success)
    else:
        success_over_two(figure, axes, axes_of[0], axes_of[1], success)
        axes_of[1].mark(axes.yaxis)
    axes_of[0].mark(axes.xaxis)
    share = float(np.nanmean(success)) if np.isfinite(success).any() else np.nan
    axes.set_title(
        f"{results.statement['name']}: {100 * share:.0f} % of {len(success)} trials succeed", loc="left", fontsize=11
    )
    return saved(figure, file)


def wrench_names(results: Results) -> list[str]:
    """Columns of forces and torques that are magnitudes: numbers whose names end in force or torque."""
    columns = results.columns()
    names = [name for name in results.outcomes if re.search(r"(force|torque)$", name)]
    return [n for n in names if columns[n].dtype != object and np.isfinite(columns[n]).any()]


def plot_wrenches(
    results: Results, against: Optional[str] = None, file: File = None, names: Optional[Sequence[str]] = None
) -> Any:
    """Distributions of forces and torques: above by success, below against a parameter.

    against: a parameter; none: the first that varies. names: of columns; none: those that end in force or
    torque. file: to save it in. Returns matplotlib's Figure.
    """
    names = list(names or wrench_names(results))
    if not names:
        raise StudyError("plot: no trial has an outcome whose name ends in force or torque; give names")
    columns = results.columns()
    across = axis_of(results, columns, against or first_of(results))
    success = columns.get("success")
    figure = new_figure(1.2 + 4.2 * len(names), 6.4)
    panels = figure.subplots(2, len(names), squeeze=False)
    for n, name in enumerate(names):
        values = axis_of(results, columns, name)
        if not np.isfinite(values.values).any():
            raise StudyError(f"plot: no trial has a value of '{name}'")
        draw_histogram(panels[0, n], values, success)
        draw_bands(panels[1, n], across, values)
    panels[0, 0].set_ylabel("trials")
    panels[1, 0].legend(frameon=False, fontsize=8)
    if success is not None:
        legend(panels[0, 0], False, "ss")
    figure.suptitle(
        f"{results.statement['name']}: forces and torques of {len(across.values)} trials",
        x=0.01,
        ha="left",
        fontsize=11,
    )
    return saved(figure, file)


def draw_histogram(axes: Any, values: Axis, success: Optional[Doubles]) -> None:
    known = values.values[np.isfinite(values.values)]
    steps = np.linspace(0, np.quantile(known, 0.995) * 1.02 or 1.0, BARS + 1)
    inside = np.minimum(values.values, steps[-1])  # the last bar holds what lies beyond
    parts = [(inside, YES)] if success is None else [(inside[success == 1], YES), (inside[success == 0], NO)]
    axes.hist([v for v, _ in parts], steps, stacked=True, color=[c for _, c in parts])
    values.mark(axes.xaxis)
    axes.set_xlim(0, steps[-1])


def draw_bands(axes: Any, across: Axis, values: Axis) -> None:
    """Median, middle half and middle nine tenths of the trials, by classes of the parameter."""
    rows = []
    classes = max(2, min(MOST_CLASSES, len(across.values) // IN_CLASS))
    for _, who in bins_of(across.values, classes):
        who = who & np.isfinite(values.values)
        if who.any():
            rows.append([across.values[who].mean(), *np.quantile(values.values[who], [0.05, 0.25, 0.5, 0.75, 0.95])])
    at, low, quarter, median, upper, high = np.array(rows).T
    axes.fill_between(at, low, high, color=YES, alpha=0.18, linewidth=0, label="9 of 10 trials")
    axes.fill_between(at, quarter, upper, color=YES, alpha=0.35, linewidth=0, label="half of the trials")
    axes.plot(at, median, "o-", color=YES, markersize=4, label="median")
    axes.set_ylim(bottom=0)
    across.mark(axes.xaxis)
    values.mark(axes.yaxis)
