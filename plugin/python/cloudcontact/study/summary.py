"""A study in a few lines: how many trials, how many succeed, where, and what was measured."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from .results import Column, Results

MOST_BINS = 5
Doubles = npt.NDArray[np.float64]


def bins_of(values: Doubles, most: int) -> list[tuple[str, npt.NDArray[np.bool_]]]:
    """Values in up to `most` classes of about as many each: a label and who belongs to it."""
    known = np.unique(values[np.isfinite(values)])
    if len(known) <= most:
        return [(f"{v:.4g}", values == v) for v in known]
    edges = np.quantile(known, np.linspace(0, 1, most + 1))
    out = []
    for i in range(most):
        inside = (values >= edges[i]) & ((values < edges[i + 1]) if i < most - 1 else (values <= edges[-1]))
        out.append((f"{edges[i]:.3g} to {edges[i + 1]:.3g}", inside))
    return out


def classes_of(values: Column, most: int) -> list[tuple[str, npt.NDArray[np.bool_]]]:
    """The same for texts: a class each."""
    if values.dtype == object:
        return [(v, values.astype(str) == v) for v in sorted(set(values.astype(str)))]
    return bins_of(values, most)


@dataclass
class Summary:
    """A study's figures.

    counts: trials by status. success: share of those done, where the study states it. by: for each varied
    parameter the share and number of trials by class. outcomes: 5 %, median and 95 % of each.
    """

    name: str
    counts: dict[str, int]
    success: Optional[float] = None
    by: dict[str, list[tuple[str, float, int]]] = field(default_factory=dict)
    outcomes: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    versions: list[str] = field(default_factory=list)
    digest: str = ""

    def label(self, name: str) -> str:
        unit = self.units.get(name)
        return f"{name} [{unit}]" if unit else name

    def __str__(self) -> str:
        total = sum(self.counts.values())
        lines = [f"{self.name}: " + ", ".join(f"{n} {status}" for status, n in self.counts.items()) + f" of {total}"]
        if self.success is not None:
            lines.append(f"success: {100 * self.success:.1f} %")
            for name, rows in self.by.items():
                shares = "   ".join(f"{label}: {100 * share:.0f} %" for label, share, _ in rows)
                lines.append(f"  by {self.label(name)}   {shares}")
        if self.outcomes:
            wide = max(len(self.label(name)) for name in self.outcomes)
            lines.append(f"  {'':{wide}} {'5 %':>11} {'median':>11} {'95 %':>11}")
            for name, figures in self.outcomes.items():
                lines.append(f"  {self.label(name):{wide}} " + " ".join(f"{v:11.4g}" for v in figures))
        if len(self.versions) > 1:
            lines.append(f"rows of {len(self.versions)} versions: " + "; ".join(self.versions))
        return "\n".join([*lines, f"digest of all rows: {self.digest[:16]}"])

    def json(self) -> dict[str, Any]:
        """For programs."""
        return {
            "name": self.name,
            "trials": sum(self.counts.values()),
            "counts": self.counts,
            "success": self.success,
            "successBy": {
                name: [{"class": label, "share": share, "trials": n} for label, share, n in rows]
                for name, rows in self.by.items()
            },
            "outcomes": {n: {"p5": a, "median": b, "p95": c} for n, (a, b, c) in self.outcomes.items()},
            "versions": self.versions,
            "digest": self.digest,
        }


def summarize(results: Results) -> Summary:
    """The figures of a file of results as it is now."""
    columns = results.columns()
    out = Summary(results.statement["name"], results.counts, digest=results.digest())
    out.versions = sorted({v for v in columns["versions"] if isinstance(v, str)})
    out.units = {name: unit for name in columns if (unit := results.unit(name))}
    success = columns.get("success")
    if success is not None and np.isfinite(success).any():
        out.success = float(np.nanmean(success))
        for name in results.varied:
            rows = [(label, success[who]) for label, who in classes_of(columns[name], MOST_BINS)]
            out.by[name] = [(label, float(np.nanmean(s)), len(s)) for label, s in rows if np.isfinite(s).any()]
    for name in results.outcomes:
        values = columns[name]
        if name != "success" and values.dtype != object and np.isfinite(values).any():
            a, b, c = np.nanquantile(values, [0.05, 0.5, 0.95])
            out.outcomes[name] = (float(a), float(b), float(c))
    return out
