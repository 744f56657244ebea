"""Where a functional is sampled on a strip model, and how values there depend on control points.

Glossary
--------
site
    A parameter u at which all edge curves are evaluated: (element, q), q sites to an element;
    all sites of one element lie in one knot span, so they depend on the same control points.
stencil
    The consecutive edges that a residual depends on: 1 (edge), 2 (strip) or 3 (edge and both
    neighbours).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo import spline
from fabgeo.arrays import Array, IntArray
from fabgeo.strips.model import StripModel


@dataclass(frozen=True)
class Net:
    """The shape of a model without its control points."""

    edges: int
    segments: int
    closed_u: bool
    closed_i: bool

    @classmethod
    def of(cls, model: StripModel) -> Net:
        """The net of a model."""
        return cls(model.edges, model.segments, model.closed_u, model.closed_i)

    @property
    def columns(self) -> int:
        """Control points of one edge."""
        return self.segments + (0 if self.closed_u else 3)

    def windows(self, width: int) -> IntArray:
        """Edges of every stencil of `width` consecutive edges, (n, width)."""
        count = self.edges if self.closed_i and width > 1 else self.edges - width + 1
        return (np.arange(count)[:, None] + np.arange(width)) % self.edges


def coarsened(net: Net, control: Array) -> tuple[Net, Array]:
    """The net of half as many segments, and the model on it through every other knot's points."""
    u = np.arange(0.0, net.segments + (0 if net.closed_u else 1), 2.0)
    points = spline.evaluate(control, u, net.closed_u)
    coarse = Net(net.edges, net.segments // 2, net.closed_u, net.closed_i)
    return coarse, spline.interpolate(points, net.closed_u)


def refined(net: Net, control: Array) -> tuple[Net, Array]:
    """The net of twice as many segments, and the same model on it."""
    finer = Net(net.edges, net.segments * 2, net.closed_u, net.closed_i)
    return finer, spline.refine(control, net.closed_u)


class Sites:
    """Sites of a net, with the spline's basis values there.

    Parameters
    ----------
    net : Net
    u : (elements, q) array
        Parameters, those of one row within one knot span.
    weight : (elements, q) array
        Quadrature weights; their sum is 1 over all sites.
    """

    def __init__(self, net: Net, u: Array, weight: Array) -> None:
        self.net, self.u, self.weight = net, u, weight / weight.sum()
        middle = u.mean(axis=1)
        self.index = spline.basis(middle, net.segments, net.closed_u)[0]
        span = np.minimum(np.floor(middle), net.segments - 1)
        # Local parameters, so that a site at a knot is seen from its own element's side.
        local = u - span[:, None]
        self.basis = [spline.basis(local, 1, False, order)[1] for order in range(3)]
        self._nodes: dict[bytes, IntArray] = {}

    @classmethod
    def gauss(cls, net: Net, count: int) -> Sites:
        """`count` Gauss points in every knot span."""
        t, weight = np.polynomial.legendre.leggauss(count)
        u = np.arange(net.segments)[:, None] + (t + 1.0) / 2.0
        return cls(net, u, np.broadcast_to(weight, u.shape))

    @classmethod
    def chebyshev(cls, net: Net, count: int) -> Sites:
        """`count` Chebyshev points in every knot span.

        What vanishes there is smallest in the largest norm: constraints are met at these.
        """
        t = -np.cos((np.arange(count) + 0.5) * np.pi / count)
        u = np.arange(net.segments)[:, None] + (t + 1.0) / 2.0
        return cls(net, u, np.ones_like(u))

    @classmethod
    def at_end(cls, net: Net, last: bool) -> Sites:
        """The end u = 0 or u = m of an open net."""
        u = np.array([[float(net.segments) if last else 0.0]])
        return cls(net, u, np.ones_like(u))

    def evaluate(self, control: Array, derivative: int = 0) -> Array:
        """Points or derivatives (edges, elements, q, 3) of control (edges, columns, 3)."""
        local = control[:, self.index]  # (edges, elements, 4, 3)
        return self.basis[derivative] @ local

    def nodes(self, window: IntArray) -> IntArray:
        """Nodes of every element of stencils (n, width): (n * elements, width * 4), kept."""
        key = window.tobytes() + bytes([window.shape[1]])
        if key not in self._nodes:
            grid = window[:, None, :, None] * self.net.columns + self.index[None, :, None, :]
            nodes = grid.reshape(-1, window.shape[1] * 4)
            self._nodes[key] = np.ascontiguousarray(nodes)
        return self._nodes[key]

    def jacobian(self, gradients: dict[int, Array]) -> Array:
        """Local Jacobians from gradients by points (0), first (1) and second derivatives (2).

        Parameters
        ----------
        gradients : dict of (n, elements, q, r, width, 3) arrays

        Returns
        -------
        (3, n * elements, q * r, width * 4) array
            By x, y and z of the nodes.
        """
        n, elements, q, r, width = next(iter(gradients.values())).shape[:5]
        out = np.empty((3, n, elements, q, r, width, 4))
        for axis in range(3):
            parts = (
                gradient[..., axis, None] * self.basis[order][:, :, None, None, :]
                for order, gradient in gradients.items()
            )
            out[axis] = sum(parts)
        return out.reshape(3, n * elements, q * r, width * 4)


def normed(vectors: Array) -> tuple[Array, Array]:
    """Unit vectors and lengths (kept with a last axis of 1), never dividing by zero."""
    length = np.sqrt(np.einsum("...k,...k->...", vectors, vectors))[..., None]
    length = np.maximum(length, 1e-300)
    return vectors / length, length


def through_unit(direction: Array, length: Array, gradient: Array) -> Array:
    """Gradient by a vector from the gradient by its unit vector `direction`."""
    along = np.einsum("...k,...k->...", direction, gradient)[..., None]
    return (gradient - along * direction) / length
