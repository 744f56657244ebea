"""What an unfolding is worth: measured lengths, area, angles, stretch and refolding.

Every figure compares the delivered outline (its points and tangents, as cubic Hermite curves) with
the patch in space by a second route; nothing is taken from the integration that made it.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.panels.flat import FlatEdge
from fabgeo.panels.unfold_develop import Development, hermite
from fabgeo.panels.unfold_quadrature import Quadrature
from fabgeo.strips.ruled import RuledPatch

_X, _W = legendre.leggauss(6)
_X, _W = (_X + 1.0) / 2.0, _W / 2.0

HALVINGS, SETTLED = 8, 1e-3  # of the refolded pieces at most, mm that their error may still change


def hermite_length(edge: FlatEdge) -> float:
    """Length of the delivered edge, by quadrature of its Hermite curves' speed."""
    h = np.diff(edge.arc)[:, None, None]
    t = _X[None, :, None]
    d = (edge.points[1:] - edge.points[:-1])[:, None]
    v, w = edge.tangents[:-1, None], edge.tangents[1:, None]
    speed = (
        6.0 * (t - t**2) * d + (1.0 - 4.0 * t + 3.0 * t**2) * h * v + (3.0 * t**2 - 2.0 * t) * h * w
    )
    return float(np.einsum("k,pk->", _W, np.linalg.norm(speed, axis=-1)))


def hermite_area(outline: tuple[FlatEdge, ...]) -> float:
    """Signed area within the outline's Hermite curves, exactly, by Green's theorem."""
    total = 0.0
    for edge in outline:
        p, q = edge.points[:-1], edge.points[1:]
        h = np.diff(edge.arc)[:, None]
        v, w = h * edge.tangents[:-1], h * edge.tangents[1:]
        # Bezier points p, p + v/3, q - w/3, q of each piece.
        a, b = p + v / 3.0, q - w / 3.0
        total += float(
            np.sum(6 * _cross(p, a) + 3 * _cross(p, b) + _cross(p, q) + 3 * _cross(a, b))
            + np.sum(3 * _cross(a, q) + 6 * _cross(b, q))
        )
    return total / 20.0


def _cross(a: Array, b: Array) -> Array:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def certificate(
    mid: RuledPatch, flat: Development, outline: tuple[FlatEdge, ...], side: int
) -> dict[str, float]:
    """All figures of one part (keys: see `FlatPart.certificate`)."""
    fine = flat.rule.halved()
    lengths = _lengths_in_space(mid, fine)
    named = {edge.name: edge for edge in outline}
    error = {
        f"{name}_length_error_mm": abs(hermite_length(named[name]) - length)
        for name, length in lengths.items()
    }
    area = area_in_space(mid, fine)
    return {
        "edge_length_error_mm": max(error.values()),
        **error,
        "area_error_rel": abs(abs(hermite_area(outline)) - area) / area,
        "angle_error_deg": angle_error(mid, flat),
        "stretch_max": stretch(mid, fine),
        "twist_max_deg": twist(mid, fine),
        "refold_error_mm": refold_error(mid, flat, outline, side),
    }


def _lengths_in_space(mid: RuledPatch, rule: Quadrature) -> dict[str, float]:
    u = rule.nodes
    speed = np.linalg.norm(mid.edges(u.ravel(), 1), axis=-1).reshape(2, *u.shape)
    a, b = mid.edges(np.array([mid.u0, mid.u1]))
    ruling = np.linalg.norm(b - a, axis=-1)
    return {
        "first": float(rule.integral(speed[0])),
        "second": float(rule.integral(speed[1])),
        "start": float(ruling[0]),
        "end": float(ruling[1]),
    }


def area_in_space(mid: RuledPatch, rule: Quadrature) -> float:
    """Area of the patch: the integral of |x_u cross x_v|."""
    u = rule.nodes.ravel()
    a, b = mid.edges(u)
    da, db = mid.edges(u, 1)
    v = _X[:, None, None]
    density = np.linalg.norm(cross((1.0 - v) * da + v * db, b - a), axis=-1)
    return float(rule.integral(np.einsum("k,kn->n", _W, density).reshape(rule.nodes.shape)))


def angle_error(mid: RuledPatch, flat: Development) -> float:
    """Largest difference, in degrees, of the angle between edge and ruling, space against plane."""
    a, b = mid.edges(flat.rule.breaks)
    speed = mid.edges(flat.rule.breaks, 1)
    moving = np.linalg.norm(speed, axis=-1) > 1e-9
    e, flat_e = unit(b - a), unit(flat.edges[1] - flat.edges[0])
    t = unit(speed)
    space = np.arctan2(np.linalg.norm(cross(t, e), axis=-1), dot(t, e))
    plane = np.arctan2(
        np.abs(flat.tangents[..., 0] * flat_e[:, 1] - flat.tangents[..., 1] * flat_e[:, 0]),
        dot(flat.tangents, flat_e),
    )
    return float(np.degrees(np.where(moving, np.abs(space - plane), 0.0).max()))


def _perpendicular(mid: RuledPatch, u: Array) -> Array:
    a, b = mid.edges(u)
    e = unit(b - a)
    speed = mid.edges(u, 1)
    return speed - dot(speed, e)[..., None] * e


def stretch(mid: RuledPatch, rule: Quadrature) -> float:
    """Largest principal stretch minus one from patch to plane.

    The two metrics differ only in the speed at right angles to the ruling, which is linear in v in
    the plane; their quotient is the principal stretch.
    """
    p, q = _perpendicular(mid, rule.nodes.ravel())
    v = np.linspace(0.0, 1.0, 9)[:, None, None]
    space = np.linalg.norm((1.0 - v) * p + v * q, axis=-1)
    v = v[..., 0]
    plane = (1.0 - v) * np.linalg.norm(p, axis=-1) + v * np.linalg.norm(q, axis=-1)
    keep = space > 1e-6 * space.max()
    return float(np.abs(plane[keep] / space[keep] - 1.0).max(initial=0.0))


def twist(mid: RuledPatch, rule: Quadrature) -> float:
    """Largest angle, in degrees, between the normals at the two ends of one ruling."""
    p, q = _perpendicular(mid, rule.nodes.ravel())
    size = np.linalg.norm(p, axis=-1) * np.linalg.norm(q, axis=-1)
    sine = np.linalg.norm(cross(p, q), axis=-1)
    keep = size > 1e-9 * size.max()
    return float(np.degrees(np.arctan2(sine[keep], dot(p, q)[keep]).max(initial=0.0)))


def normals(mid: RuledPatch, u: Array) -> tuple[Array, Array, Array]:
    """Unit normals n along the middle line, their bending rate and the speed across the ruling.

    The rate is n' along the direction across the ruling: it turns the tangent plane about the
    ruling. Curvature of the middle line's section at right angles to the ruling: rate / speed.
    """
    a, b = mid.edges(u)
    velocity, acceleration = mid.edges(u, 1), mid.edges(u, 2)
    ruling = b - a
    x_u, x_uu = velocity.mean(axis=0), acceleration.mean(axis=0)
    normal = cross(x_u, ruling)
    size = np.linalg.norm(normal, axis=-1, keepdims=True)
    n = normal / size
    change = cross(x_uu, ruling) + cross(x_u, velocity[1] - velocity[0])
    change = (change - dot(change, n)[:, None] * n) / size
    across = cross(unit(ruling), n)
    return n, dot(change, across), size[:, 0] / np.linalg.norm(ruling, axis=-1)


def refold_error(
    mid: RuledPatch, flat: Development, outline: tuple[FlatEdge, ...], side: int
) -> float:
    """Bend the flat part about its rulings and measure it against the patch, in mm.

    A frame is carried from ruling to ruling by the flat part's own motion in its plane, while it
    turns about the ruling by what the normals of the patch turn: between two rulings one screw.
    Best rigid motion onto the patch, then the largest distance of both edge curves. Rulings get
    closer until that distance settles: bending in steps of constant radius is the measurement's
    own error, of second order. What is left is the patch's twist: along a length s it turns the
    patch out of every developable shape by about twist s^2 / width.
    """
    fine, before, error = flat.rule.halved(), np.inf, np.inf
    for _ in range(HALVINGS):
        fine = fine.halved()
        folded = _folded(mid, fine.breaks, _flat_edges(mid, flat, fine))
        target = mid.edges(fine.breaks)
        error = float(np.linalg.norm(_fitted(folded, target) - target, axis=-1).max())
        if abs(before - error) < SETTLED:
            break
        before = error
    return error


def _flat_edges(mid: RuledPatch, flat: Development, fine: Quadrature) -> Array:
    """Points (2, k, 2) of the delivered edges where the patch has the same arc length."""
    u = fine.nodes
    speed = np.linalg.norm(mid.edges(u.ravel(), 1), axis=-1).reshape(2, *u.shape)
    each = (len(fine.breaks) - 1) // (len(flat.rule.breaks) - 1)
    edges = []
    for k in range(2):
        at = fine.cumulative(speed[k])[1]
        inner = hermite(flat.arcs[k], flat.edges[k], flat.tangents[k], at[:-1].reshape(-1, each))
        edges.append(np.concatenate([inner.reshape(-1, 2), flat.edges[k, -1:]]))
    return np.stack(edges)


def _folded(mid: RuledPatch, u: Array, edges: Array) -> Array:
    """Edge curves (2, k, 3) of flat edges (2, k, 2) at parameters u, folded about their rulings."""
    e = unit(edges[1] - edges[0])
    middle = edges.mean(axis=0)
    half = np.linalg.norm(edges[1] - edges[0], axis=-1) / 2.0
    across = np.stack([e[:, 1], -e[:, 0]], axis=-1)
    nodes = Quadrature(u, 4)
    fold = nodes.cumulative(normals(mid, nodes.nodes.ravel())[1].reshape(nodes.nodes.shape))[1]
    step = np.diff(fold)
    turn = np.diff(np.unwrap(np.arctan2(e[:, 1], e[:, 0])))
    move = np.diff(middle, axis=0)
    local = np.stack([dot(move, across[:-1]), dot(move, e[:-1])], axis=-1)
    motions = _screw(local, turn, step)
    frame = np.eye(4)
    frames = [frame]
    for motion in motions:
        frame = frame @ motion
        frames.append(frame)
    stack = np.array(frames)
    centre, ruling = stack[:, :3, 3], stack[:, :3, 1]
    return np.stack([centre - half[:, None] * ruling, centre + half[:, None] * ruling])


def _screw(local: Array, turn: Array, fold: Array) -> Array:
    """Motions (k, 4, 4) whose plane part moves by `local` and turns by `turn`, folding evenly.

    The planar motion is written as a constant planar twist (an arc); the fold about the ruling
    joins it, and the exponential of the whole is one screw: the piece bent to a constant radius.
    """
    half = turn / 2.0
    # A planar motion with displacement d and turn t is the exponential of velocity J(t)^-1 d.
    factor = np.where(np.abs(half) > 1e-8, half / np.tan(np.where(half == 0.0, 1.0, half)), 1.0)
    vx = factor * local[:, 0] + half * local[:, 1]
    vy = -half * local[:, 0] + factor * local[:, 1]
    generator = np.zeros((len(turn), 4, 4))
    # Body axes: x across, y ruling, z normal. Turning about z by `turn`, about y by `-fold`.
    generator[:, 0, 1], generator[:, 1, 0] = -turn, turn
    generator[:, 0, 2], generator[:, 2, 0] = fold, -fold
    generator[:, 0, 3], generator[:, 1, 3] = vx, vy
    power, total = np.eye(4), np.eye(4) + generator
    power = generator
    for k in range(2, 12):
        power = power @ generator / k
        total = total + power
    return total


def _fitted(points: Array, target: Array) -> Array:
    """Points (2, k, 3) after the best rigid motion onto the target (Kabsch)."""
    p, q = points.reshape(-1, 3), target.reshape(-1, 3)
    pc, qc = p.mean(axis=0), q.mean(axis=0)
    left, _, right = np.linalg.svd((p - pc).T @ (q - qc))
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    return ((p - pc) @ (left @ sign @ right) + qc).reshape(points.shape)
