"""Charts as SVG: histograms against limits, fit history, trade-off of classes, deviation map."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fabgeo.review import palette, svg
from fabgeo.review.record import DeviationMap, Limit, ReviewRecord, Row
from fabgeo.review.verdicts import verdict_of

W, H = 360.0, 190.0
LEFT, RIGHT, TOP, BOTTOM = 46.0, 22.0, 14.0, 34.0


class Axes:
    """A plot area with linear or logarithmic axes; collects SVG elements."""

    def __init__(
        self,
        x: tuple[float, float],
        y: tuple[float, float],
        log_y: bool = False,
        counts: bool = False,
        powers_x: bool = False,
    ) -> None:
        self.x, self.y, self.log_y, self.counts, self.powers_x = x, y, log_y, counts, powers_x
        self.parts: list[str] = []

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Picture coordinates of a data point."""
        low, high = self.y
        if self.log_y:
            low, high, y = math.log10(low), math.log10(high), math.log10(max(y, self.y[0]))
        fx = (x - self.x[0]) / ((self.x[1] - self.x[0]) or 1.0)
        fy = (y - low) / ((high - low) or 1.0)
        return LEFT + fx * (W - LEFT - RIGHT), H - BOTTOM - fy * (H - TOP - BOTTOM)

    def bar(self, x0: float, x1: float, y: float, kind: str, title: str) -> None:
        """A histogram's bar from zero to y."""
        (px, py), (qx, base) = self.at(x0, y), self.at(x1, 0.0)
        self.parts.append(
            f'<rect class="{kind}" x="{px:.1f}" y="{py:.1f}" '
            f'width="{max(qx - px - 0.6, 0.4):.1f}" '
            f'height="{max(base - py, 0.0):.1f}"><title>{svg.text(title)}</title></rect>'
        )

    def line(self, x: Sequence[float], y: Sequence[float], colour: str, dash: str = "") -> None:
        """A polyline through data points."""
        points = " ".join("{:.1f},{:.1f}".format(*self.at(a, b)) for a, b in zip(x, y, strict=True))
        extra = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<polyline fill="none" stroke="{colour}" stroke-width="1.8"{extra} points="{points}"/>'
        )

    def rule(self, x: float, kind: str, label: str) -> None:
        """A vertical line at a limit."""
        px, _ = self.at(x, self.y[1])
        self.parts.append(
            f'<line class="rule {kind}" x1="{px:.1f}" x2="{px:.1f}" y1="{TOP:.0f}" '
            f'y2="{H - BOTTOM:.0f}"/><text class="tick" x="{px:.1f}" y="{TOP - 4:.0f}" '
            f'text-anchor="middle">{svg.text(label)}</text>'
        )

    def render(self, label: str, x_label: str) -> str:
        """The whole SVG with ticks."""
        parts = [f'<svg class="chart" viewBox="0 0 {W:.0f} {H:.0f}" role="img">']
        parts.append(f"<title>{svg.text(label)}</title>")
        for value in _ticks(*self.x):
            if self.powers_x and value != int(value):
                continue
            px, _ = self.at(value, self.y[0])
            shown = 10.0**value if self.powers_x else value
            parts.append(
                f'<text class="tick" x="{px:.1f}" y="{H - BOTTOM + 13:.1f}" '
                f'text-anchor="middle">{shown:.6g}</text>'
            )
        for value in _decades(*self.y) if self.log_y else _ticks(*self.y):
            if self.counts and value != int(value):
                continue
            _, py = self.at(self.x[0], value)
            parts.append(
                f'<line class="grid" x1="{LEFT}" x2="{W - RIGHT}" y1="{py:.1f}" y2="{py:.1f}"/>'
                f'<text class="tick" x="{LEFT - 5}" y="{py + 3.5:.1f}" '
                f'text-anchor="end">{value:.4g}</text>'
            )
        parts += self.parts
        parts.append(
            f'<text class="tick" x="{(LEFT + W - RIGHT) / 2:.0f}" y="{H - 5:.0f}" '
            f'text-anchor="middle">{svg.text(x_label)}</text></svg>'
        )
        return "".join(parts)


def histograms(record: ReviewRecord) -> list[tuple[str, str]]:
    """Title and SVG of one histogram a limit that any part's figure differs from."""
    result = []
    for limit in record.limits:
        own = [(f.get(limit.key), mark) for mark, f in record.figures.items()]
        known = [(float(v), mark) for v, mark in own if v is not None and math.isfinite(v)]
        if any(value != limit.good for value, _ in known):
            result.append((limit.label or limit.key, _histogram(limit, known)))
    return result


def _histogram(limit: Limit, known: list[tuple[float, str]]) -> str:
    values = np.array([value for value, _ in known])
    bounds = [b for b in (limit.good, limit.warn) if b is not None]
    low = min(float(values.min()), 0.0) if limit.sense == "max" else float(values.min())
    high = float(values.max())
    near = [b for b in bounds if b <= 4.0 * max(high, 1e-12)]
    low, high = min([low, *near]), max([high * 1.02, *(1.06 * b for b in near)])
    if high <= low:
        high = low + 1.0
    counts, edges = np.histogram(values, bins=28, range=(low, high))
    axes = Axes((low, high), (0.0, float(counts.max()) * 1.08), counts=True)
    for count, x0, x1 in zip(counts.tolist(), edges[:-1], edges[1:], strict=True):
        if count:
            kind = verdict_of(limit, float(x1 if limit.sense == "max" else x0))
            inside = values[(values >= x0) & (values <= x1)]
            worst = inside.max() if limit.sense == "max" else inside.min()
            kind = verdict_of(limit, float(worst))
            axes.bar(x0, x1, count, kind.replace(" ", "-"), f"{count} parts, {x0:.4g} to {x1:.4g}")
    for bound, kind in zip(bounds, ("good", "warn"), strict=False):
        if bound in near:
            axes.rule(bound, kind, f"{kind} {bound:g}")
    worst, mark = (max if limit.sense == "max" else min)(known)
    beyond = "" if near or not bounds else f"; limit {bounds[0]:g}, off the scale"
    return axes.render(limit.label or limit.key, f"worst {worst:.4g} ({mark}){beyond}")


def history_chart(history: Sequence[Row]) -> str:
    """What the fit lowers over its iterations, on a logarithmic scale: all but the counters."""
    first = history[0] if history else {}
    names = [name for name in first if any(isinstance(r.get(name), float) for r in history)]
    series: dict[str, tuple[list[float], list[float]]] = {}
    for name in names:
        pairs = [(float(r.get("iteration", k)), r.get(name)) for k, r in enumerate(history)]
        good = [(x, float(y)) for x, y in pairs if y is not None and _positive(y)]
        if len(good) > 1:
            series[name] = [x for x, _ in good], [y for _, y in good]
    if not series:
        return ""
    every = [y for _, ys in series.values() for y in ys]
    last = max(x for xs, _ in series.values() for x in xs)
    low = 10.0 ** math.floor(math.log10(min(every)))
    axes = Axes((0.0, last), (low, 10.0 ** math.ceil(math.log10(max(every) * 1.0001))), log_y=True)
    colours = list(palette.CLASSES.values())
    legend = []
    for k, (name, (xs, ys)) in enumerate(list(series.items())[:8]):
        colour, dash = colours[k % len(colours)], "" if k < len(colours) else "4 3"
        axes.line(xs, ys, colour, dash)
        legend.append(_key(colour, name))
    return axes.render("Fit history", "iteration") + f'<p class="keys">{"".join(legend)}</p>'


def tradeoff_chart(rows: Sequence[Row]) -> str:
    """Share of every panel class over the class tolerance."""
    if len(rows) < 2:
        return ""
    x = [float(row["tolerance_mm"]) for row in rows]
    names = [key for key in rows[0] if key != "tolerance_mm"]
    totals = [sum(float(row[n]) for n in names) or 1.0 for row in rows]
    log_x = [math.log10(v) for v in x]
    axes = Axes((min(log_x), max(log_x)), (0.0, 100.0), powers_x=True)
    legend = []
    for name in names:
        share = [100.0 * float(r[name]) / t for r, t in zip(rows, totals, strict=True)]
        colour = palette.CLASSES.get(name, palette.CLASSES["other"])
        axes.line(log_x, share, colour)
        legend.append(_key(colour, name))
    chart = axes.render("Panel classes over tolerance", "tolerance in mm; share of the panels in %")
    note = "<p class=note>Every panel by itself, by its deviation alone.</p>"
    return chart + f'<p class="keys">{"".join(legend)}</p>{note}'


def deviation_chart(deviation: DeviationMap) -> str:
    """The deviation over the strips (upwards) and along them (to the right), as a picture."""
    values = deviation.values
    step = [max(1, math.ceil(n / limit)) for n, limit in zip(values.shape, (200, 400), strict=True)]
    values = values[:: step[0], :: step[1]]
    known = np.abs(deviation.values[np.isfinite(deviation.values)])
    bound = float(known.max(initial=0.0)) or 1.0
    level = values[::-1] / bound
    pixels = palette.ramp(palette.DIVERGING, 0.5 + 0.5 * np.nan_to_num(level))
    pixels[np.isnan(level)] = palette.rgb(palette.CLASSES["other"])
    over = " Grey: beyond the surface." if np.isnan(level).any() else ""
    scale = palette.ramp(palette.DIVERGING, np.linspace(0.0, 1.0, 64)[None])
    return (
        f'<img class="map" alt="Deviation from the design surface, -{bound:.3g} to {bound:.3g} mm" '
        f'src="{svg.png_uri(pixels)}"><p class="scale"><span>-{bound:.3g} mm</span>'
        f'<img alt="" src="{svg.png_uri(scale)}"><span>+{bound:.3g} mm</span></p>'
        "<p class=note>Upwards: across the strips. To the right: along them."
        f"{over}</p>"
    )


def _key(colour: str, name: str) -> str:
    return f'<span><i style="background:{colour}"></i>{svg.text(name)}</span>'


def _positive(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value) and value > 0.0


def _ticks(low: float, high: float) -> list[float]:
    """About five round numbers within [low, high]."""
    span = (high - low) or 1.0
    step = 10.0 ** math.floor(math.log10(span / 4.0))
    step *= next(f for f in (1.0, 2.0, 5.0, 10.0) if span / (f * step) <= 5.0)
    first = math.ceil(low / step - 1e-9)
    return [round(k * step, 12) for k in range(first, math.floor(high / step + 1e-9) + 1)]


def _decades(low: float, high: float) -> list[float]:
    first, last = round(math.log10(low)), round(math.log10(high))
    step = max(1, (last - first) // 5)
    return [10.0**k for k in range(first, last + 1, step)]
