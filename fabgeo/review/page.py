"""index.html: one offline file for the meeting in which fabrication is released.

Everything is in the file: data as JSON (`page_data`), flat parts as SVG paths that sheets refer to
(`page_flats`), charts as SVG, three.js as committed in `assets`. A content security policy forbids
any request.
"""

from __future__ import annotations

import base64
import hashlib
import json
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.review import charts, palette, svg
from fabgeo.review.page_data import page_data
from fabgeo.review.page_flats import flat_symbols, sheet_pictures
from fabgeo.review.picture import picture_of, view_of
from fabgeo.review.record import ReviewRecord
from fabgeo.review.verdicts import judged, package_verdicts, review_of

SCRIPTS = ("colour.js", "view.js", "table.js", "detail.js", "main.js")


def write_page(path: Path, record: ReviewRecord) -> Path:
    """Write the review page.

    Parameters
    ----------
    path : Path
        Usually ``DIR/index.html``.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page_of(record), encoding="utf-8")
    return path


def page_of(record: ReviewRecord) -> str:
    """The whole page as text."""
    record = judged(record)
    review = review_of(record)
    library = _asset("three.min.js")
    script = "(()=>{'use strict';\n" + "\n".join(_asset(name) for name in SCRIPTS) + "\n})();"
    marks = sorted(record.flats)
    numbers = {mark: k for k, mark in enumerate(marks)}
    fields = {
        "csp": _policy(library, script),
        "title": svg.text(record.name),
        "css": _asset("page.css"),
        "head": _head(record, review),
        "still": _still(record),
        "charts": _charts(record),
        "sheets": sheet_pictures(record, numbers),
        "flats": flat_symbols(record, numbers),
        "limits": _limits(review),
        "summary": _summary(review),
        "data": _json(page_data(record, marks)),
        "library": library,
        "script": script,
    }
    page = _asset("page.html")
    head, *rest = page.split("{{")
    pieces = [head]
    for piece in rest:
        name, _, tail = piece.partition("}}")
        pieces += [fields[name], tail]
    return "".join(pieces)


def _asset(name: str) -> str:
    return resources.files("fabgeo.review").joinpath("assets", name).read_text(encoding="utf-8")


def _policy(*scripts: str) -> str:
    """A policy that runs these scripts alone and loads nothing from anywhere."""
    hashes = [
        base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts
    ]
    allowed = " ".join(f"'sha256-{value}'" for value in hashes)
    return (
        f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; img-src data:; "
        "connect-src 'none'; form-action 'none'; base-uri 'none'"
    )


def _json(data: Any) -> str:
    """JSON that can stand inside a script element."""
    raw = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    for character, code in (("<", "003c"), (">", "003e"), ("&", "0026"), ("\u2028", "2028")):
        raw = raw.replace(character, f"\\u{code}")
    return raw.replace("\u2029", "\\u2029")


def _head(record: ReviewRecord, review: dict[str, Any]) -> str:
    """Verdict summary: counts by verdict and the worst parts with their reasons."""
    parts = review["parts"]
    whole = {k: own for k, own in package_verdicts(review).items() if own[0] in ("warn", "fail")}
    labels = {limit.key: limit.label or limit.key for limit in record.limits}
    broken = [labels.get(key, key) for key, (verdict, _) in whole.items() if verdict == "fail"]
    counts = {key: sum(p["verdict"] == key for p in parts.values()) for key in palette.SIGNS}
    worst = "fail" if counts["fail"] or broken else "warn" if counts["warn"] else "good"
    words = {
        "fail": (
            f"{counts['fail']} of {len(parts)} parts fail a limit"
            if counts["fail"]
            else "No part fails, but the package does"
        )
        + (f": {'; '.join(broken)}" if broken else ""),
        "warn": f"No part fails; {counts['warn']} of {len(parts)} parts carry a warning",
        "good": "All figures are within their limits"
        if counts["good"]
        else "No limits were asked for: figures are reported only",
    }
    tiles = "".join(
        f'<button class="tile {key.replace(" ", "-")}" data-verdict="{key}">'
        f"<b>{palette.SIGNS[key]} {count}</b><span>{key}</span></button>"
        for key, count in counts.items()
    )
    bad = [(m, p) for m, p in parts.items() if p["verdict"] in ("fail", "warn")]
    bad.sort(key=lambda item: (item[1]["verdict"] != "fail", item[0]))
    lines = "".join(
        f'<li class="{verdict}"><b>{palette.SIGNS[verdict]} package</b> {svg.text(reason)}'
        + (f": {svg.text(record.where[key])}" if key in record.where else "")
        + "</li>"
        for key, (verdict, reason) in whole.items()
    )
    lines += "".join(
        f'<li class="{p["verdict"]}"><button class="mark" data-mark="{svg.text(m)}">'
        f"{palette.SIGNS[p['verdict']]} {svg.text(m)}</button> {svg.text(p['reason'])}</li>"
        for m, p in bad[:60]
    )
    more = f"<p class=note>and {len(bad) - 60} more: filter the tables.</p>" if bad[60:] else ""
    why = f'<ul class="reasons">{lines}</ul>{more}' if lines else ""
    remarks = "".join(f"<li>{svg.text(remark)}</li>" for remark in record.remarks)
    known = f'<div class="remarks"><h3>Remarks</h3><ul>{remarks}</ul></div>' if remarks else ""
    asked = ", ".join(record.not_asked)
    absent = f"<p class=note>Not asked for: {svg.text(asked)}.</p>" if asked else ""
    return (
        f'<div class="verdict {worst}"><h2>{palette.SIGNS[worst]} {words[worst]}</h2>'
        f'<div class="tiles">{tiles}</div>{why}{known}{absent}</div>'
    )


def _summary(review: dict[str, Any]) -> str:
    rows = []
    verdicts = package_verdicts(review)
    for key, value in review["summary"].items():
        shown = "not asked for" if value is None else f"{value:.6g}"
        verdict, _ = verdicts.get(key, ("not asked", ""))
        limit = review["limits"].get(key, {}).get("good")
        judged_by = "" if limit is None or value is None else f"limit {limit:g}"
        sign = "" if verdict == "not asked" else f"{palette.SIGNS[verdict]} {verdict}"
        rows.append(
            f"<tr><th scope=row>{svg.text(key)}</th><td>{shown}</td>"
            f"<td>{judged_by}</td><td>{sign}</td></tr>"
        )
    seconds = "".join(
        f"<tr><th scope=row>{svg.text(stage)}</th><td>{value:.2f} s</td></tr>"
        for stage, value in review["seconds"].items()
    )
    times = f"<div><h3>Seconds by stage</h3><table class=plain>{seconds}</table></div>"
    return (
        "<div><h3>Worst over the package</h3><table class=plain>"
        + "".join(rows)
        + f"</table></div>{times if seconds else ''}"
    )


def _limits(review: dict[str, Any]) -> str:
    rows = "".join(
        f"<tr><th scope=row>{svg.text(limit['label'] or key)}</th><td>{svg.text(key)}</td>"
        f"<td>{_bound(limit['good'], 'reported only')}</td><td>{_bound(limit['warn'], '')}</td>"
        f"<td>{svg.text(limit['origin'])}</td></tr>"
        for key, limit in review["limits"].items()
    )
    return (
        "<table class=plain><thead><tr><th>limit</th><th>figure</th><th>good</th><th>warn</th>"
        f"<th>origin</th></tr></thead><tbody>{rows}</tbody></table>"
    )


def _bound(value: float | None, absent: str) -> str:
    return absent if value is None else f"{value:g}"


def _charts(record: ReviewRecord) -> str:
    figures = charts.histograms(record)
    if record.deviation is not None:
        chart = charts.deviation_chart(record.deviation)
        figures.append(("Deviation from the design surface", chart))
    figures.append(("Fit history", charts.history_chart(record.history)))
    figures.append(("Panel classes over the tolerance", charts.tradeoff_chart(record.tradeoff)))
    return "".join(
        f"<figure><figcaption>{svg.text(title)}</figcaption>{chart}</figure>"
        for title, chart in figures
        if chart
    )


def _still(record: ReviewRecord) -> str:
    """The still picture: what is seen without WebGL and on paper."""
    panels = [p for p in record.shown if p.family == "panels"] or list(record.shown)
    if not panels:
        return "<p>There are no parts to show.</p>"
    polygons = picture_of(panels, view_of())
    points = np.concatenate([p.points for p in polygons])
    low, high = points.min(axis=0), points.max(axis=0)
    unit = max(float((high - low).max()) / 4000.0, 1e-9)
    width, height = np.ceil((high - low) / unit).astype(int).tolist()
    paths = "".join(
        f'<path data-mark="{svg.text(p.mark)}" data-shade="{p.shade:.2f}" '
        f'd="{svg.path((p.points - [low[0], high[1]]) * [1.0, -1.0], unit, closed=True)}"/>'
        for p in polygons
    )
    return (
        f'<svg id="still" viewBox="-20 -20 {width + 40} {height + 40}" role="img">'
        f"<title>Still picture of {svg.text(record.name)}</title>{paths}</svg>"
    )
