"""Uniform cubic B-splines (paper eq. 1): bases, evaluation, refinement, exact clamped form.

Glossary
--------
segment
    One knot span: for integer knots the parameter runs over [j, j + 1] in segment j.
control points
    Open curve of m segments: m + 3 points, u in [0, m]. Closed curve: m points, u in [0, m),
    periodic; the curve near u = j is shaped by points j, j + 1, j + 2, j + 3 (modulo m).

The basis is the cubic one for integer knots, so the point at the integer parameter j is
(b[j] + 4 b[j+1] + b[j+2]) / 6.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_banded

from fabgeo.arrays import (
    Array,
    IntArray,
    as_numbers,
    checked,
    checked_count,
    checked_flag,
    checked_number,
)
from fabgeo.errors import InputError

MOST_SEGMENTS = 1_000_000  # of one curve
LARGEST = 1e100  # coordinate, so that a curve's points are numbers
FARTHEST_U = 1e7  # parameter: farther from its knots a cubic cancels to nothing
# Rows: powers of the local parameter t; columns: the four control points of a segment.
_POWERS = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6.0


def segments_of(count: int, closed: bool) -> int:
    """Number of segments of a curve with `count` control points."""
    least = 3 if checked_flag("closed", closed) else 4
    return checked_count("control points of a curve", count, least) - (0 if closed else 3)


def basis(u: Array, segments: int, closed: bool, derivative: int = 0) -> tuple[IntArray, Array]:
    """Control point indices and basis values at parameters.

    Parameters
    ----------
    u : (k,) array
        Parameters; of an open curve in [0, segments] (a little beyond is extrapolated), of a
        closed one anything.
    segments : int
        Number of segments m.
    closed : bool
        Whether the curve is periodic in u.
    derivative : int
        Order of the derivative by u, 0 to 3.

    Returns
    -------
    index : (k, 4) int array
        Which control points act.
    value : (k, 4) array
        With which weight.

    Raises
    ------
    InputError
        If a parameter is not finite, or one of the others is something else.
    """
    u = checked_parameters("u", u)
    checked_count("segments", segments, 1, MOST_SEGMENTS)
    checked_count("derivative", derivative, 0, 3)
    if checked_flag("closed", closed):
        u = np.mod(u, segments)
    span = np.clip(np.floor(u).astype(np.int64), 0, segments - 1)
    t = u - span
    powers = np.zeros((*u.shape, 4))
    for p in range(derivative, 4):
        factor = float(np.prod(np.arange(p, p - derivative, -1))) if derivative else 1.0
        powers[..., p] = factor * t ** (p - derivative)
    index = span[..., None] + np.arange(4)
    if closed:
        index = index % segments
    return index, powers @ _POWERS


def evaluate(control: Array, u: Array, closed: bool = False, derivative: int = 0) -> Array:
    """Points or derivatives of many curves at the same parameters.

    Parameters
    ----------
    control : (..., c, d) array
        Control points, the one before the last axis along the curve.
    u : (k,) array
        Parameters.

    Returns
    -------
    (..., k, d) array

    Raises
    ------
    InputError
        If these are no control points and parameters, or hold a value that is not finite.
    """
    control, u = _curves("evaluate", control, closed), checked_parameters("u", u, 1)
    index, value = basis(u, segments_of(control.shape[-2], closed), closed, derivative)
    return np.einsum("...kad,ka->...kd", control[..., index, :], value)


def refine(control: Array, closed: bool = False) -> Array:
    """Exact knot refinement: every segment is halved; parameters double.

    An open curve of m + 3 points becomes one of 2 m + 3, a closed one of m points one of 2 m.
    Lane-Riesenfeld subdivision; open curves keep exactly the parts that act on [0, m].
    """
    control = _curves("refine", control, closed)
    b = np.concatenate([control, control[..., :2, :]], axis=-2) if closed else control
    mid = (b[..., :-1, :] + b[..., 1:, :]) / 2.0
    vertex = (b[..., :-2, :] + 6.0 * b[..., 1:-1, :] + b[..., 2:, :]) / 8.0
    count = mid.shape[-2] + vertex.shape[-2]
    out = np.empty((*b.shape[:-2], count, b.shape[-1]))
    out[..., 0::2, :] = mid
    out[..., 1::2, :] = vertex
    return out[..., : 2 * control.shape[-2], :] if closed else out


def interpolate(points: Array, closed: bool = False) -> Array:
    """Control points of the cubic through given points at integer parameters 0, 1, 2, ...

    Parameters
    ----------
    points : (..., m + 1, d) array, closed: (..., m, d)
        Open curves end with the not-a-knot condition (so that cubics are reproduced and the error
        falls with the fourth power of the spacing), m >= 3.

    Raises
    ------
    InputError
        If there are too few points, or one is not finite.
    """
    points = _numbers("interpolate", points, 2)
    count = points.shape[-2]
    checked_flag("interpolate closed", closed)
    if count < (3 if closed else 4):
        raise InputError("interpolate", f"needs {3 if closed else 4} points or more, found {count}")
    flat = np.moveaxis(points, -2, 0).reshape(count, -1)
    if closed:
        # Point j is (b[j] + 4 b[j+1] + b[j+2]) / 6: circulant, solved by the discrete Fourier way.
        kernel = np.zeros(count)
        kernel[[0, 1 % count, 2 % count]] += np.array([1.0, 4.0, 1.0]) / 6.0
        spectrum = np.conj(np.fft.fft(kernel))
        solved = np.fft.ifft(np.fft.fft(flat, axis=0) / spectrum[:, None], axis=0).real
    else:
        solved = _interpolate_open(flat)
    return np.moveaxis(solved.reshape(-1, *points.shape[:-2], points.shape[-1]), 0, -2)


def _interpolate_open(flat: Array) -> Array:
    count = len(flat)
    unknowns = count + 2
    rows = np.zeros((unknowns, unknowns)) if unknowns <= 9 else None
    # Not-a-knot: the third derivative is continuous at the second and the last but one point.
    third = np.array([-1.0, 4.0, -6.0, 4.0, -1.0])
    right = np.concatenate([np.zeros((1, flat.shape[1])), flat, np.zeros((1, flat.shape[1]))])
    if rows is not None:
        rows[0, :5] = third
        rows[-1, -5:] = third
        for j in range(count):
            rows[j + 1, j : j + 3] = np.array([1.0, 4.0, 1.0]) / 6.0
        return np.linalg.solve(rows, right)
    band = np.zeros((9, unknowns))  # 4 above, 4 below the diagonal

    def put(row: int, start: int, values: Array) -> None:
        for k, value in enumerate(values):
            band[4 + row - (start + k), start + k] = value

    put(0, 0, third)
    put(unknowns - 1, unknowns - 5, third)
    for j in range(count):
        put(j + 1, j, np.array([1.0, 4.0, 1.0]) / 6.0)
    return solve_banded((4, 4), band, right)


def greville(knots: Array, degree: int = 3) -> Array:
    """Greville points of a clamped knot vector: as many as control points."""
    knots = checked_parameters("greville", knots, 1)
    if (np.diff(knots) < 0.0).any():
        raise InputError("greville", "expected ascending knots")
    checked_count("greville degree", degree, 1, max(len(knots) - 2, 1))
    windows = np.lib.stride_tricks.sliding_window_view(knots[1:-1], degree)
    # Means of equal knots may round past the ends.
    return np.clip(windows.mean(axis=-1), knots[0], knots[-1])


def clamped_knots(u0: float, u1: float, segments: int) -> Array:
    """Clamped cubic knot vector with `segments` equal spans on [u0, u1], u0 < u1."""
    _check_interval("clamped_knots", u0, u1)
    checked_parameters("clamped_knots", np.array([u0, u1]))
    checked_count("clamped_knots segments", segments, 1, MOST_SEGMENTS)
    inner = np.linspace(u0, u1, segments + 1)
    if not (np.diff(inner) > 0.0).all():
        raise InputError("clamped_knots", f"no room for {segments} spans between {u0} and {u1}")
    return np.concatenate([[u0] * 3, inner, [u1] * 3])


def to_clamped(control: Array, closed: bool = False) -> tuple[Array, Array]:
    """Exact conversion to clamped knots.

    Returns
    -------
    knots : (m + 7,) array
        0, 0, 0, 0, 1, ..., m, m, m, m.
    poles : (..., m + 3, d) array
        The same curve with its end points as first and last pole (a closed curve: the seam
        repeated).
    """
    control = _curves("to_clamped", control, closed)
    if closed:
        control = np.concatenate([control, control[..., :3, :]], axis=-2)
    segments = segments_of(control.shape[-2], False)
    poles = np.array(control, dtype=np.float64)
    for side in (1, -1):  # raise the first knot to full multiplicity, then the last
        end = _end_bezier(control[..., ::side, :], segments)
        for k in range(3):
            poles[..., ::side, :][..., k, :] = end[k]
    return clamped_knots(0.0, float(segments), segments), poles


def _end_bezier(b: Array, segments: int) -> tuple[Array, Array, Array]:
    """First three clamped poles of a uniform cubic, by blossoming at its own knots.

    The blossom f of segment 0 has f(-2,-1,0), f(-1,0,1), f(0,1,2), f(1,2,3) as control points;
    the clamped poles are f(0,0,0), f(0,0,1) and f(0,1,x) with x the next knot (2, or the end).
    """
    b0, b1, b2 = b[..., 0, :], b[..., 1, :], b[..., 2, :]
    f001 = (2.0 * b1 + b2) / 3.0
    f000 = (b0 + 4.0 * b1 + b2) / 6.0
    f011 = (b1 + 2.0 * b2) / 3.0
    return f000, f001, (b2 if segments >= 2 else f011)


def checked_control(name: str, control: Array, closed: bool) -> Array:
    """Check an array of control points (..., c, 3): enough points for one segment."""
    array = _numbers(name, control, 2)
    return _curves(name, checked(name, array, (None,) * (array.ndim - 1) + (3,)), closed)


def _curves(name: str, control: Array, closed: bool) -> Array:
    """Control points (..., c, d): enough for one segment."""
    control = _numbers(name, control, 2)
    checked_flag(f"{name} closed", closed)
    least, found = 3 if closed else 4, control.shape[-2]
    if found < least:
        raise InputError(name, f"needs {least} control points a curve, found {found}")
    return control


def checked_parameters(name: str, u: Array, dimensions: int | None = None) -> Array:
    """Return parameters of a curve as finite numbers; raise InputError if they are none."""
    array = _numbers(name, u, dimensions or 0, FARTHEST_U)
    if dimensions is not None and array.ndim != dimensions:
        raise InputError(name, f"expected parameters (k,), found shape {array.shape}")
    return array


def _numbers(name: str, value: Array, least: int, most: float = LARGEST) -> Array:
    """Finite numbers up to `most` as an array of `least` or more dimensions."""
    array = as_numbers(name, value)
    if array.ndim < least:
        raise InputError(name, f"expected {least} dimensions or more, found shape {array.shape}")
    if not (np.abs(array) <= most).all():
        raise InputError(name, f"holds a value that is not finite, or beyond {most:g}")
    return array


def _check_interval(name: str, u0: float, u1: float) -> None:
    if not checked_number(f"{name} u0", u0) < checked_number(f"{name} u1", u1):
        raise InputError(name, f"expected u0 < u1, found {u0:g} and {u1:g}")


def clip(control: Array, closed: bool, u0: float, u1: float) -> tuple[Array, Array]:
    """The exact piece of curves over [u0, u1] as clamped B-splines.

    Parameters
    ----------
    control : (..., c, d) array
        Control points of uniform cubics.
    u0, u1 : float
        Interval, u0 < u1; of a closed curve it may pass the seam (u1 up to u0 + m).

    Returns
    -------
    knots : (k + 4,) array
        u0 and u1 fourfold, the integers between them once.
    poles : (..., k, d) array
    """
    control = _curves("clip", control, closed)
    _check_interval("clip", u0, u1)
    if closed:
        rounds = (u1 - u0) / control.shape[-2]
        if rounds > 2.0:
            raise InputError("clip", f"expected u1 within a round of u0, found {rounds:.3g} rounds")
        checked_parameters("clip", np.array([u0, u1]))
        start = int(np.floor(u0))
        count = int(np.ceil(u1)) - start
        index = (start + np.arange(count + 3)) % control.shape[-2]
    else:
        segments = segments_of(control.shape[-2], False)
        if u0 < -1e-9 or u1 > segments + 1e-9:
            raise InputError("clip", f"expected 0 <= u <= {segments}, found [{u0}, {u1}]")
        start = min(max(int(np.floor(u0)), 0), segments - 1)
        count = max(min(int(np.ceil(u1)), segments), start + 1) - start
        index = start + np.arange(count + 3)
    tiny = 1e-9
    integers = np.arange(np.ceil(u0 + tiny), np.floor(u1 - tiny) + 1.0)
    knots = np.concatenate([[u0] * 4, integers, [u1] * 4])
    return knots, _blossoms(control[..., index, :], knots, start)


def _blossoms(control: Array, knots: Array, start: int) -> Array:
    """Poles for new knots: the blossom of the uniform cubic at three consecutive new knots."""
    windows = np.lib.stride_tricks.sliding_window_view(knots[1:-1], 3)
    segments = control.shape[-2] - 3
    # The polynomial piece of any one segment that the window touches gives the same pole.
    middle = (knots[:-4] + knots[4:]) / 2.0
    middle = np.clip(middle, windows[:, 0], windows[:, 2])
    span = np.clip(np.floor(middle - start).astype(np.int64), 0, segments - 1)
    x = windows - start - span[:, None]
    d = [control[..., span + a, :] for a in range(4)]
    for r in range(3):  # de Boor's triangle on the local knots -2, -1, 0, 1, 2, 3
        for a in range(3 - r):
            low = a - 2 + r
            t = ((x[:, r] - low) / (3 - r))[:, None]
            d[a] = (1.0 - t) * d[a] + t * d[a + 1]
    return d[0]
