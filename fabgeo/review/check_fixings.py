"""Products of fixings: pieces in line on each other, and bolts in the holes of panel and flange.

Glossary
--------
piece
    A solid of a product: base plate, stand-off, disc, washer, bolt, nut (`measured.Piece`).
axis
    Where a bolt stands, seen along the fixing's own axis, in the product's frame.
stack
    The pieces around one axis from below to above. Each lies on the one before, or panel or
    flange is between them.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np

from fabgeo.arrays import Array
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured, Piece
from fabgeo.review.package import WrittenPackage
from fabgeo.review.solid_plate import SolidPlate

PIECES = {"base plate", "stand-off", "disc", "washer", "bolt", "nut"}
NEEDED = {"base plate", "stand-off", "bolt"}
MOST = 4  # kinds of these that a product has to be one of ours
ROUND, HEXAGON = {"stand-off", "disc", "washer"}, {"bolt", "nut"}
VARIED = {"stand-off", "bolt"}  # their heights differ from product to product
CORNERS = 2.0 / np.sqrt(3.0)  # width across corners over width across flats
PLACE = 0.02  # mm: sound pieces were 1e-4 off at most
SHAPE = 0.005  # relative: heads with rounded corners were 1e-4 off
BORED = 0.05  # mm: 3,300 fixings' bolts were 1e-4 off the middles of their holes at most
FREE = "a hole without bolt"
DEEP = 100.0  # mm: holes farther along the axis are of other parts
WITHIN = 8.0  # mm: holes so far within the base plate's outline have a bolt

type Product = tuple[Piece, ...]


def check_fixings(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Check every product that is built of known pieces; users' own have others."""
    products = {name: own for name, own in measured.pieces.items() if _is_known(own)}
    thick = [plate.thickness for plate in measured.plates.values()]
    sheets = np.unique(np.round(thick, 2))
    for name, own in products.items():
        for kind in sorted(NEEDED - {piece.kind for piece in own}):
            findings.add(name, f"its {kind}", "present", "missing")
    whole = {name: own for name, own in products.items() if {p.kind for p in own} >= NEEDED}
    for name, own in whole.items():
        _shapes(name, own, findings)
        _stacks(name, own, sheets, findings)
    _alike(whole, findings)
    _in_holes(package, measured, whole, findings)


def _is_known(pieces: Product) -> bool:
    kinds = {piece.kind for piece in pieces}
    return kinds <= PIECES and len(kinds) >= MOST


def _shapes(name: str, pieces: Product, findings: Findings) -> None:
    """Round pieces are as wide as they are deep, hexagons wider by two over root three."""
    for piece in pieces:
        sides = np.sort((piece.high - piece.low)[:2])
        ratio = {**dict.fromkeys(ROUND, 1.0), **dict.fromkeys(HEXAGON, CORNERS)}.get(piece.kind)
        if ratio and not abs(sides[1] / (sides[0] * ratio) - 1.0) <= SHAPE:
            words = "round" if piece.kind in ROUND else "hexagonal"
            findings.add(name, f"shape of its {piece.name}", words, f"{sides[0]:g} x {sides[1]:g}")


def _axes(pieces: Product) -> Array:
    """Axes (a, 2) of the bolts."""
    return np.array([piece.place for piece in pieces if piece.kind == "bolt"])


def _stacks(name: str, pieces: Product, sheets: Array, findings: Findings) -> None:
    """All pieces on axes of bolts, the base plate about its own; no gaps or overlaps in height."""
    base = next(piece for piece in pieces if piece.kind == "base plate")
    axes = _axes(pieces)
    _near(name, "base plate about its axis", base.place, np.zeros(2), findings)
    _near(name, "base plate on the flange", base.low[2:], np.zeros(1), findings)
    for piece in pieces:
        away = np.linalg.norm(axes - piece.place, axis=1).min()
        if piece is not base and not away <= PLACE:
            findings.add(name, f"{piece.name} on a bolt", "in line", f"{away:.3f} mm off")
    top = max(piece.high[2] for piece in pieces if piece.kind == "stand-off")
    stated = name.rpartition("-")[2]
    if re.fullmatch(r"[\d.]+", stated):
        _near(name, "stand-off of its name", np.array([top]), np.array([float(stated)]), findings)
    for bolt in (piece for piece in pieces if piece.kind == "bolt"):
        there = [p for p in pieces if np.linalg.norm(p.place - bolt.place) <= PLACE or p is base]
        stack = sorted((p for p in there if p.kind != "bolt"), key=lambda piece: piece.low[2])
        _stack(name, bolt, stack, sheets, findings)


def _stack(name: str, bolt: Piece, stack: list[Piece], sheets: Array, findings: Findings) -> None:
    """Pieces below the head of one bolt, its length that of its name, a nut where it ends free."""
    open_ = np.append(sheets, 0.0)
    for below, above in pairwise(stack):
        gap = above.low[2] - below.high[2]
        if not np.abs(open_ - gap).min() <= PLACE:
            what = f"between {below.name} and {above.name} in mm"
            findings.add(name, what, "nothing, or panel or flange", float(gap))
    length = re.search(r" x ([\d.]+)", bolt.name)
    if length is not None:
        reach = np.array([stack[-1].high[2] - bolt.low[2]])
        _near(name, f"length of its {bolt.name}", reach, np.array([float(length[1])]), findings)
    if bolt.low[2] < -PLACE and stack[0].kind != "nut":
        findings.add(name, f"lowest piece on its {bolt.name}", "a nut", stack[0].name)


def _near(name: str, what: str, found: Array, expected: Array, findings: Findings) -> None:
    away = float(np.linalg.norm(found - expected))
    if not away <= PLACE:
        findings.add(name, what, "in place", f"{away:.3f} mm off")


def _alike(products: dict[str, Product], findings: Findings) -> None:
    """Pieces of one name have one size in all products; so have most of them."""
    sizes: dict[str, dict[str, tuple[float, ...]]] = defaultdict(dict)
    for name, own in products.items():
        for piece in own:
            size = np.round(piece.high - piece.low, 1) + 0.0
            title = piece.name.partition(" x ")[0] if " x " in piece.name else piece.name
            sizes[title][name] = tuple(size[:2] if piece.kind in VARIED else size)
    for title, found in sizes.items():
        counts = Counter(found.values())
        usual, most = counts.most_common(1)[0]
        for name, size in found.items():
            if size != usual or (most == 1 and len(found) > 1):
                words = " x ".join(f"{side:g}" for side in usual)
                findings.add(name, f"size of its {title}, elsewhere", words,
                             " x ".join(f"{side:g}" for side in size))  # fmt: skip


def _in_holes(
    package: WrittenPackage,
    measured: Measured,
    products: dict[str, Product],
    findings: Findings,
) -> None:
    """Every bolt of a placed fixing is in a hole, every hole below its base plate has a bolt.

    Where most fixings of a product are off, it is the product; what is bolted to a plate that was
    named before is not looked at.
    """
    named = {found.part for found in findings.items}
    flanges: dict[str, list[str]] = defaultdict(list)
    for row in package.tables["plates"]:
        if row.get("role") == "flange_outer":
            flanges[row.get("parent", "")].append(row.get("mark", ""))
    frames = {path[-1]: frame for path, frame in measured.fixings.items()}
    off: dict[str, dict[str, str]] = defaultdict(dict)
    count: Counter[str] = Counter()
    for row in package.tables["connectors"]:
        mark, plates = row.get("mark", ""), [row.get("panel", ""), *flanges[row.get("beam", "")]]
        product = next(iter(measured.products.get(mark, ())), "")
        own = products.get(product)
        known = [measured.plates[m] for m in plates if m in measured.plates]
        if own is None or mark not in frames or len(known) < len(plates) or named & set(plates):
            continue
        count[product] += 1
        for words in _missed(own, frames[mark], known):
            off[product][mark] = words
    for product, marks in off.items():
        if 2 * len(marks) > count[product]:
            marks = {product: next(iter(marks.values()))}
        else:  # a hole without bolt may be that of a fixing beside
            marks = {mark: words for mark, words in marks.items() if words != FREE}
        for mark, words in marks.items():
            findings.add(mark, "its bolts in the holes of panel and flange", "in all", words)


def _missed(pieces: Product, frame: Array, plates: Iterable[SolidPlate]) -> Iterator[str]:
    """What is wrong between a placed product's bolts and the plates' holes."""
    base = next(piece for piece in pieces if piece.kind == "base plate")
    axes, holes = _axes(pieces), list(_holes(frame, plates, base))
    if not holes:
        yield "no holes there"
        return
    apart = np.linalg.norm(axes[:, None] - np.array(holes), axis=2)
    if not apart.min(axis=1).max() <= BORED:
        yield f"a bolt {apart.min(axis=1).max():.2f} mm off"
    elif apart.min(axis=0).max() > BORED:
        yield FREE


def _holes(frame: Array, plates: Iterable[SolidPlate], base: Piece) -> Iterator[Array]:
    """Middles (2,) of holes within the base plate's outline, in the product's frame."""
    for plate in plates:
        if not plate.openings:
            continue
        rough = (np.array([rim[0] for rim in plate.openings]) - frame[:3, 3]) @ frame[:3, :3]
        low, high = base.low[:2] - WITHIN, base.high[:2] + WITHIN
        near = np.all((rough[:, :2] > low) & (rough[:, :2] < high), axis=1)
        for k in np.flatnonzero(near & (np.abs(rough[:, 2]) < DEEP)):
            rim = ((plate.openings[k] - frame[:3, 3]) @ frame[:3, :3])[:, :2]
            middle = 0.5 * (rim.min(axis=0) + rim.max(axis=0))
            if np.all((middle > base.low[:2] + WITHIN) & (middle < base.high[:2] - WITHIN)):
                yield middle
