"""Shape checks on entry and freezing of arrays: the one helper every noun uses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from fabgeo.errors import InputError

type Array = npt.NDArray[np.float64]
type IntArray = npt.NDArray[np.int64]
type BoolArray = npt.NDArray[np.bool_]
type IndexArray = npt.NDArray[np.intp]
type ComplexArray = npt.NDArray[np.complex128]


def checked(
    name: str,
    value: npt.ArrayLike,
    shape: Sequence[int | str | None],
    sizes: dict[str, int] | None = None,
) -> Array:
    """Return `value` as a finite float64 array of the given shape.

    Parameters
    ----------
    name : str
        How the argument is called in messages.
    value : array_like
        Anything numpy understands.
    shape : sequence of int, str or None
        An int fixes a dimension, None leaves it free, a string links it: equal strings must have
        equal sizes, over all calls that share `sizes`.
    sizes : dict, optional
        The linked dimensions seen so far; updated.

    Raises
    ------
    InputError
        If the value is not numeric, has another shape or holds a value that is not finite.
    """
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(name, f"expected numbers of shape {_words(shape)}: {error}") from error
    sizes = {} if sizes is None else sizes
    if array.ndim != len(shape):
        raise InputError(name, f"expected shape {_words(shape)}, found {array.shape}")
    for found, expected in zip(array.shape, shape, strict=True):
        wanted = sizes.setdefault(expected, found) if isinstance(expected, str) else expected
        if wanted is not None and found != wanted:
            raise InputError(name, f"expected shape {_words(shape)}, found {array.shape}")
    if not np.isfinite(array).all():
        at = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InputError(name, f"holds a value that is not finite at index {at}", "remove it")
    return array


def frozen(
    name: str,
    value: npt.ArrayLike,
    shape: Sequence[int | str | None],
    sizes: dict[str, int] | None = None,
) -> Array:
    """Like `checked`, but a private copy that can't be written to."""
    array = np.array(checked(name, value, shape, sizes), dtype=np.float64, copy=True)
    array.flags.writeable = False
    return array


def set_frozen(
    noun: Any,
    name: str,
    shape: Sequence[int | str | None],
    sizes: dict[str, int] | None = None,
) -> None:
    """Check, copy and freeze the array attribute `name` of a frozen dataclass in place."""
    label = f"{type(noun).__name__}.{name}"
    object.__setattr__(noun, name, frozen(label, getattr(noun, name), shape, sizes))


def unit(vectors: Array) -> Array:
    """Vectors divided by their length, along the last axis; a zero vector stays zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)


def dot(a: Array, b: Array) -> Array:
    """Scalar products along the last axis."""
    return np.einsum("...k,...k->...", a, b)


def cross(a: Array, b: Array) -> Array:
    """Vector products along the last axis (numpy's own spends most of its time on axes)."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    out[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    out[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return out


def _words(shape: Sequence[int | str | None]) -> str:
    return "(" + ", ".join("any" if s is None else str(s) for s in shape) + ")"
