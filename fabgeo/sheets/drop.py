"""Sheets filled from below: pieces dropped on the outline of what lies there already.

Glossary
--------
column
    One of even slices of the sheet along x.
profile
    Lowest and highest point of a piece in every column it covers, grown by half the spacing: two
    profiles that do not meet belong to pieces that keep their spacing.
sky
    Height reached so far, column by column. A piece dropped at a column comes to rest where its
    lower profile first meets the sky.
worth
    What placing a piece is worth: its area, or its price in `fabgeo.sheets.cover`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import shapely

from fabgeo.arrays import Array
from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.stock import Placement, Stock

COLUMNS = 256
TRIED = 64  # pieces that are tried at a time
PLACES = 5  # along the sheet where a piece is dropped, the two ends among them
SAFE = 0.02  # mm, grown beyond half the spacing: round corners are polygons

type Float32Array = npt.NDArray[np.float32]
type Index = np.ndarray[tuple[int], np.dtype[np.intp]]
type Drop = tuple[int, int, float]  # row of the profiles, column, height


@dataclass(frozen=True)
class Profiles:
    """All pieces in all their trial rotations, on the columns of one sheet.

    Attributes
    ----------
    piece : (p,) array
        Number of the piece.
    rotation : (p,) array
        Radians.
    low, high : (p, c) arrays
        Profiles from column 0 on, with the lowest point at 0; +inf and -inf beyond the piece.
    corner : (p, 2) array
        Where the box's lower left corner lies, the piece turned about its origin.
    length, height : (p,) arrays
        Of the grown box.
    room : (2,) array
        Length and height of the sheet for grown pieces.
    place : (p, `PLACES`) array
        Columns where it is dropped.
    width : (p,) array
        How many it covers.
    sum_high : (p,) array
        Sum of `high` over them.
    """

    piece: Index
    rotation: Array
    low: Float32Array
    high: Float32Array
    corner: Array
    length: Array
    height: Array
    room: Array
    place: np.ndarray[tuple[int, int], np.dtype[np.intp]]
    width: Index
    sum_high: Array

    @property
    def step(self) -> float:
        """Width of a column in mm."""
        return float(self.room[0]) / self.low.shape[1]


def profiles(pieces: Sequence[Piece], stock: Stock, spacing: float, margin: float) -> Profiles:
    """Profiles of all pieces that fit the stock, in the rotations that do."""
    grow = spacing / 2.0 + SAFE
    room = np.array([stock.length, stock.width]) - 2.0 * margin + 2.0 * grow
    step = room[0] / COLUMNS
    rows: list[tuple[int, float, Array, Array, Array, Array]] = []
    for number, piece in enumerate(pieces):
        exact = shapely.Polygon(piece.contour.points(0.05, outside=True))
        grown = shapely.get_coordinates(shapely.buffer(exact, grow, quad_segs=8).exterior)
        for rotation in piece.trials():
            c, s = np.cos(rotation), np.sin(rotation)
            points = grown @ np.array([[c, s], [-s, c]])
            corner, size = points.min(axis=0), np.ptp(points, axis=0)
            if np.all(size <= room + 2.0 * SAFE):
                low, high = _envelopes((points - corner), step)
                rows.append((number, rotation, low, high, corner, size))
    count = len(rows)
    low = np.array([row[2] for row in rows], dtype=np.float32).reshape(count, COLUMNS)
    high = np.array([row[3] for row in rows], dtype=np.float32).reshape(count, COLUMNS)
    sizes = np.array([row[5] for row in rows]).reshape(count, 2)
    covers = np.isfinite(low)
    width = covers.sum(axis=1)
    spread = (COLUMNS - width)[:, None] * np.linspace(0.0, 1.0, PLACES)
    place = np.round(spread).astype(np.intp)
    return Profiles(
        np.array([row[0] for row in rows], dtype=np.intp),
        np.array([row[1] for row in rows]),
        low,
        high,
        np.array([row[4] for row in rows]).reshape(count, 2),
        sizes[:, 0],
        sizes[:, 1],
        room,
        place,
        width,
        np.where(covers, high, 0.0).sum(axis=1),
    )


def _envelopes(points: Array, step: float) -> tuple[Array, Array]:
    """Least and greatest y of a closed polygon in every column."""
    low, high = np.full(COLUMNS, np.inf), np.full(COLUMNS, -np.inf)
    p, q = points[:-1], points[1:]
    left = np.where((p[:, 0] <= q[:, 0])[:, None], p, q)
    right = np.where((p[:, 0] <= q[:, 0])[:, None], q, p)
    first = np.clip((left[:, 0] / step).astype(int), 0, COLUMNS - 1)
    last = np.clip((right[:, 0] / step).astype(int), 0, COLUMNS - 1)
    count = last - first + 1
    edge = np.repeat(np.arange(len(p)), count)
    column = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count) + first[edge]
    run = np.maximum(right[edge, 0] - left[edge, 0], 1e-12)
    rise = right[edge, 1] - left[edge, 1]
    for at in (column, column + 1):
        share = np.clip((at * step - left[edge, 0]) / run, 0.0, 1.0)
        y = left[edge, 1] + share * rise
        np.minimum.at(low, column, y)
        np.maximum.at(high, column, y)
    return low, high


def drop_sheet(
    made: Profiles,
    worth: Array,
    left: Array,
    random: np.random.Generator,
    keen: float,
    begin: Sequence[int] = (),
) -> list[Drop]:
    """Fill one sheet: again and again the piece worth most for the room it takes.

    Parameters
    ----------
    worth : (pieces,) array
        Of each piece; pieces of no worth are not placed.
    left : (pieces,) array
        How many of each may be placed.
    keen : float
        Exponent of the worth against the room taken (1: worth per area); random numbers of a few
        percent are multiplied to it, so that every call finds another sheet.
    begin : sequence of int
        Rows of `made` to drop first, in this order, where they fit.
    """
    columns = made.low.shape[1]
    left = left.copy()
    sky = np.zeros(2 * columns, dtype=np.float32)  # as much again beyond, where nothing lies
    under = np.lib.stride_tricks.sliding_window_view(sky, columns)  # from every column on
    noise = np.exp(random.normal(0.0, 0.08, len(worth)))
    weight = np.maximum(worth * noise, 0.0)[made.piece] ** keen
    alive = np.flatnonzero((left[made.piece] > 0) & (weight > 0.0))
    gone = np.zeros(len(made.piece), dtype=bool)
    out: list[Drop] = []
    ahead = list(begin)
    while len(alive):
        tried = alive
        if ahead:
            row = ahead.pop(0)
            tried = alive[alive == row]
        elif len(alive) > TRIED:  # drawn by worth; the first piece of a sheet alone
            share = weight[alive] / weight[alive].sum()
            few = TRIED if out else 1
            tried = random.choice(alive, min(few, int(np.count_nonzero(share))), False, share)
        if not len(tried):
            continue
        rest = _resting(made, under, tried)
        fits = rest + made.height[tried][:, None] <= made.room[1] + SAFE
        some = fits.any(axis=1)
        if some.any():
            taken = _room_taken(made, sky, tried, rest)
            gain = np.where(fits, weight[tried][:, None] / taken, -1.0)
            k, j = np.unravel_index(int(np.argmax(gain)), gain.shape)
            row, column, y = int(tried[k]), int(made.place[tried[k], j]), float(rest[k, j])
            wide = int(made.width[row])
            sky[column : column + wide] = y + made.high[row, :wide]
            out.append((row, column, y))
            left[made.piece[row]] -= 1
        gone[tried[~some]] = True
        alive = alive[~gone[alive] & (left[made.piece[alive]] > 0)]
    return out


def _resting(made: Profiles, under: Float32Array, tried: Index) -> Array:
    """Heights (rows, places) where pieces come to rest on the sky `under` them."""
    wide = int(made.width[tried].max())
    above = under[made.place[tried], :wide]
    above -= made.low[tried, None, :wide]
    return np.maximum(above.max(axis=2), 0.0)


def _room_taken(made: Profiles, sky: Float32Array, tried: Index, rest: Array) -> Array:
    """From the sky as it is to the piece's upper profile, column by column: (rows, places)."""
    sums = np.append(0.0, np.cumsum(sky[: made.low.shape[1]]))
    start = made.place[tried]
    filled = sums[start + made.width[tried][:, None]] - sums[start]
    raised = rest * made.width[tried][:, None] + made.sum_high[tried][:, None]
    return np.maximum((raised - filled) * made.step, 1e-6)


def placements(
    made: Profiles,
    sheet: Sequence[Drop],
    pieces: Sequence[Piece],
    spacing: float,
    margin: float,
) -> list[Placement]:
    """The dropped pieces as placements on the sheet."""
    off = margin - spacing / 2.0 - SAFE
    return [
        Placement(
            pieces[int(made.piece[row])].mark,
            float(column * made.step - made.corner[row, 0] + off),
            float(y - made.corner[row, 1] + off),
            float(made.rotation[row]),
        )
        for row, column, y in sheet
    ]
