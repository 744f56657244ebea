"""Checks on entry, of arrays, numbers, paths and texts, and freezing of arrays."""

from __future__ import annotations

import os
from collections.abc import Sequence
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fabgeo.errors import InputError

type Array = npt.NDArray[np.float64]
type IntArray = npt.NDArray[np.int64]
type BoolArray = npt.NDArray[np.bool_]
type IndexArray = npt.NDArray[np.intp]
type ComplexArray = npt.NDArray[np.complex128]

FARTHEST = 1e12  # coordinate in any unit of length: products of several of them stay numbers


def checked(
    name: str,
    value: npt.ArrayLike,
    shape: Sequence[int | str | None],
    sizes: dict[str, int] | None = None,
    most: float = np.inf,
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
    most : float, optional
        Largest absolute value that it may hold.

    Raises
    ------
    InputError
        If the value is not numeric, has another shape or holds a value that is not finite, or is
        larger than `most`.
    """
    array = as_numbers(name, value, f" of shape {_words(shape)}")
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
    if np.isfinite(most) and array.size and (found := float(np.abs(array).max())) > most:
        raise InputError(name, f"expected numbers up to {most:g}, found one of {found:.3g}")
    return array


def as_numbers(name: str, value: npt.ArrayLike, what: str = "") -> Array:
    """Return `value` as a float64 array, whatever its shape; raise InputError if it is none.

    Text, truth values, dates and what a mask hides are no numbers, though numpy makes some of them.
    """
    try:
        array = np.asarray(value)
        kind = array.dtype.kind
        if kind not in "fiu" and not (kind == "O" and all(map(_is_real, array.flat))):
            raise TypeError(f"found {_NO_NUMBERS.get(kind, shown(value))}")
        if np.ma.is_masked(value):
            raise TypeError("found masked ones")
        return np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(name, f"expected numbers{what}: {error}") from error


_NO_NUMBERS = {"b": "truth values", "c": "complex ones", "U": "text", "S": "bytes"}


def _is_real(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def frozen(
    name: str,
    value: npt.ArrayLike,
    shape: Sequence[int | str | None],
    sizes: dict[str, int] | None = None,
    most: float = np.inf,
) -> Array:
    """Like `checked`, but a private copy that can't be written to."""
    array = np.array(checked(name, value, shape, sizes, most), dtype=np.float64, copy=True)
    array.flags.writeable = False
    return array


def set_frozen(
    noun: Any,
    name: str,
    shape: Sequence[int | str | None],
    sizes: dict[str, int] | None = None,
    most: float = np.inf,
) -> None:
    """Check, copy and freeze the array attribute `name` of a frozen dataclass in place."""
    label = f"{type(noun).__name__}.{name}"
    object.__setattr__(noun, name, frozen(label, getattr(noun, name), shape, sizes, most))


def checked_count(name: str, value: Any, least: int = 1, most: int | None = None) -> int:
    """Return `value` as a whole number within its bounds; `True` is none.

    Raises
    ------
    InputError
        With what was expected and found.
    """
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not whole or value < least or (most is not None and value > most):
        bounds = f"{least:,} or more" if most is None else f"from {least:,} to {most:,}"
        raise InputError(name, f"expected a whole number {bounds}, found {shown(value)}")
    return int(value)


def checked_flag(name: str, value: Any) -> bool:
    """Return `value` if it is True or False; raise InputError else."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(name, f"expected True or False, found {shown(value)}")
    return bool(value)


def checked_number(
    name: str, value: Any, above: float | None = None, least: float | None = None
) -> float:
    """Return `value` as a finite number, more than `above`, and `least` or more.

    Raises
    ------
    InputError
        With what was expected and found.
    """
    number = float("nan")
    if isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = float("inf")
    low = (above is None or number > above) and (least is None or number >= least)
    if not (np.isfinite(number) and low):
        words = f" more than {above:g}" if above is not None else ""
        words += f", {least:g} or more" if least is not None else ""
        raise InputError(name, f"expected a finite number{words}, found {shown(value)}")
    return number


def checked_path(name: str, value: Any) -> Path:
    """Return `value` as a path, if it can be one.

    Raises
    ------
    InputError
        If it is neither text nor a path, or holds a null character.
    """
    if not isinstance(value, str | os.PathLike) or "\0" in str(value):
        raise InputError(name, f"expected a path, found {shown(value)}")
    return Path(value)


def read_text(path: Path, cure: str, largest: int) -> str:
    """The text of a file in UTF-8, with or without the mark of its byte order.

    Parameters
    ----------
    cure : str
        What to do where there is no such file.
    largest : int
        Bytes that it may have.

    Raises
    ------
    InputError
        If it is missing, no file (a pipe would be waited for, a device has no end), too large, or
        in another encoding.
    """
    where = str(path)[:200]
    if not os.path.isfile(path):
        problem = "is no file" if os.path.lexists(path) else "no such file"
        raise InputError(where, f"cannot be read: {problem}", cure)
    if (size := path.stat().st_size) > largest:
        raise InputError(where, f"has {size:,} bytes, expected {largest:,} at most")
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(where, f"cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(
            where, f"cannot be read as UTF-8 text: {error}", "save it as UTF-8"
        ) from error


def shown(value: Any) -> str:
    """A value for a message, cut where it is long."""
    try:
        text = repr(value)
    except ValueError:  # an int of more digits than Python writes
        return "a number of thousands of digits"
    return text if len(text) <= 200 else f"{text[:199]}\u2026{text[-1]}"


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
