"""Which points of neighbouring edges should share a ruling: conjugate parameters.

Glossary
--------
conjugate
    A ruling r is conjugate to the edge's tangent t on a surface with shape tensor S if t . S r = 0.
    Then the tangent plane is constant along the ruling to first order, and the strip developable.

Between two given edges this is the condition det(t_i, t_{i+1}, e) = 0: both tangents and the ruling
in one plane. Between planar parallel sections it says that corresponding tangents are parallel
(paper, "Initializing optimization").
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, eye_array, kron, vstack
from scipy.sparse.linalg import spsolve

from fabgeo.arrays import Array, BoolArray, IntArray, cross, dot, unit
from fabgeo.fitting.starts.net import Net

LEAST_GAP = 0.35  # of the even spacing: closer stations count as not monotone
MOST_RATIO = 1.8  # of neighbouring gaps: more makes a uniform spline swing


def conjugate_parameters(
    net: Net, s: Array, segments: int, ends: str = "held", steps: int = 12
) -> tuple[Array, str]:
    """Parameters t of edges s = const that make the rulings between them conjugate.

    All edges at once, by Gauss-Newton on the sine of the twist plus a fairness of the parameters
    that is relaxed as long as they stay monotone and the twist falls.

    Parameters
    ----------
    net : Net
        Where the edges lie.
    s : (E,) array
        Places of the edges across the net.
    segments : int
        Number of segments along the edges.
    ends : "held" or "free"
        Whether the first and last points of open edges stay at t = 0 and 1, or move to where the
        rulings that end no edge short of [0, 1] lead (the model overhangs at all others).

    Returns
    -------
    t : (E, segments + 1) array, closed: (E, segments)
        Parameters; even stations where nothing better stays monotone.
    note : str
        What was gained, or why the even stations were kept.
    """
    even = np.broadcast_to(net.stations(segments), (len(s), _columns(net, segments))).copy()
    start = _rms(_sine(net, s, even))
    free = np.ones(even.shape, dtype=bool)
    if not net.closed_t:
        # With none held at an end all rulings would slide into one.
        free[slice(None) if ends == "held" else len(s) // 2, [0, -1]] = False
    best, least = _relaxed(net, s, even, free, steps)
    if ends == "free" and not net.closed_t:
        least_far = np.argmax(best[:, 0]), np.argmin(best[:, -1])
        free[:, [0, -1]] = True
        free[least_far, [0, -1]] = False
        best, least = _relaxed(net, s, even, free, steps)
    if best is even:
        return even, "even stations kept: conjugate ones were not monotone or no better"
    return best, (
        f"rulings made conjugate: twist {np.degrees(start):.2f} to {np.degrees(least):.2f} deg rms"
    )


def _relaxed(net: Net, s: Array, even: Array, free: BoolArray, steps: int) -> tuple[Array, float]:
    """The best parameters from even ones on while their fairness is relaxed, and their twist."""
    best, least = even, _rms(_sine(net, s, even))
    scale = 1.0 / (even.shape[1] - (not net.closed_t))
    for fairness in (1.0, 0.3, 0.1, 0.03, 0.01):
        found = _solve(net, s, best, fairness, np.flatnonzero(free), steps, scale)
        if not _smooth(found, net.closed_t, scale):
            break
        level = _rms(_sine(net, s, found))
        if level < least:
            best, least = found, level
    return best, least


def _solve(
    net: Net, s: Array, t: Array, fairness: float, free: IntArray, steps: int, scale: float
) -> Array:
    """Gauss-Newton with step control on twist and fairness, from parameters t."""
    fair = fairness / scale * _fairness(t.shape, net.closed_s, net.closed_t)
    base = t if net.closed_t else np.broadcast_to(np.linspace(0, 1, t.shape[1]), t.shape)
    damping = 1e-6

    def total(at: Array) -> tuple[Array, float]:
        rest = np.concatenate([_sine(net, s, at).ravel(), fair @ (at - base).ravel()])
        return rest, float(rest @ rest)

    residual, value = total(t)
    for _ in range(steps):
        jacobian = vstack([_jacobian(net, s, t, scale), fair]).tocsr()[:, free]
        normal = jacobian.T @ jacobian
        right = jacobian.T @ residual
        step = np.zeros(t.size)
        weight = damping * float(normal.diagonal().mean())
        system = (normal + weight * eye_array(len(free))).tocsc()
        step[free] = np.asarray(spsolve(system, -right), dtype=np.float64)
        new = t + step.reshape(t.shape)
        rest, less = total(new)
        if less < value and _gaps(new, net.closed_t).min() > 0.0:
            gain = (value - less) / max(value, 1e-300)
            t, residual, value, damping = new, rest, less, damping / 4.0
            if gain < 1e-4:
                break
        else:
            damping = max(damping, 1e-6) * 30.0
    return t


def _sine(net: Net, s: Array, t: Array) -> Array:
    """det(t_i, t_{i+1}, e), about the sine of the twist: (strips, k)."""
    return _pair_sine(*_sides(net, s, t))


def _sides(net: Net, s: Array, t: Array) -> tuple[Array, Array, Array, Array]:
    grid = np.broadcast_to(s[:, None], t.shape)
    p, d = net.evaluate(grid, t), unit(net.evaluate(grid, t, 0, 1))
    if net.closed_s:
        return p, np.roll(p, -1, axis=0), d, np.roll(d, -1, axis=0)
    return p[:-1], p[1:], d[:-1], d[1:]


def _pair_sine(p0: Array, p1: Array, d0: Array, d1: Array) -> Array:
    e = unit(p1 - p0)
    across = np.linalg.norm(cross(d0, e), axis=-1) * np.linalg.norm(cross(d1, e), axis=-1)
    return dot(cross(d0, d1), e) / np.maximum(across, 0.05)


def _jacobian(net: Net, s: Array, t: Array, scale: float) -> csr_array:
    """By central differences: each residual depends on the two ends of its ruling."""
    h = 1e-4 * scale
    p0, p1, d0, d1 = _sides(net, s, t)
    plus, minus = _sides(net, s, t + h), _sides(net, s, t - h)
    first = _pair_sine(plus[0], p1, plus[2], d1) - _pair_sine(minus[0], p1, minus[2], d1)
    second = _pair_sine(p0, plus[1], d0, plus[3]) - _pair_sine(p0, minus[1], d0, minus[3])
    strips, k = first.shape
    row = np.arange(strips * k)
    i, j = np.divmod(row, k)
    other = ((i + 1) % len(s)) * k + j
    values = np.concatenate([first.ravel(), second.ravel()]) / (2.0 * h)
    place = (np.concatenate([row, row]), np.concatenate([row, other]))
    return csr_array((values, place), shape=(strips * k, t.size))


def _fairness(shape: tuple[int, int], closed_s: bool, closed_t: bool) -> csr_array:
    """Second differences of the parameters along the edges and first ones across."""
    rows, columns = shape
    along = kron(eye_array(rows), _difference(columns, 2, closed_t))
    across = kron(_difference(rows, 1, closed_s), eye_array(columns))
    return csr_array(vstack([along, 0.3 * across]))


def _difference(count: int, order: int, closed: bool) -> csr_array:
    weights = {1: (-1.0, 1.0), 2: (1.0, -2.0, 1.0)}[order]
    rows = count if closed else max(count - order, 0)
    row = np.repeat(np.arange(rows), order + 1)
    column = (row + np.tile(np.arange(order + 1), rows)) % count
    return csr_array((np.tile(weights, rows), (row, column)), shape=(rows, count))


def _gaps(t: Array, closed: bool) -> Array:
    return np.diff(np.concatenate([t, t[:, :1] + 1.0], axis=1) if closed else t, axis=1)


def _smooth(t: Array, closed: bool, scale: float) -> bool:
    """Whether stations are monotone, and evenly enough spaced for a uniform spline."""
    gaps = _gaps(t, closed)
    if gaps.min() < LEAST_GAP * scale:
        return False
    ratio = gaps[:, 1:] / gaps[:, :-1]
    return bool(np.all(np.maximum(ratio, 1.0 / ratio) < MOST_RATIO))


def _columns(net: Net, segments: int) -> int:
    return segments if net.closed_t else segments + 1


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
