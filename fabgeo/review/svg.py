"""Small pieces of SVG and PNG that the page is put together from."""

from __future__ import annotations

import base64
import html
import struct
import zlib

import numpy as np
import numpy.typing as npt

from fabgeo.arrays import Array


def text(value: object) -> str:
    """User text made harmless for HTML and SVG, in content and in quoted attributes."""
    return html.escape(str(value), quote=True)


def path(points: Array, unit: float = 1.0, closed: bool = False) -> str:
    """Path data through points (k, 2), as integers of `unit`; relative steps keep it short."""
    steps = np.rint(np.asarray(points) / unit).astype(int)
    moves = np.diff(steps, axis=0)
    moves = moves[np.any(moves != 0, axis=1)]
    body = " ".join(f"{dx} {dy}" for dx, dy in moves.tolist()).replace(" -", "-")
    return f"M{steps[0, 0]} {steps[0, 1]}l{body}" + ("z" if closed else "")


def lines(starts: Array, ends: Array, unit: float = 1.0) -> str:
    """Path data of lines from `starts` (k, 2) to `ends`; a line of no length is a point."""
    words, last = [], np.zeros(2, dtype=int)
    p, q = (np.rint(np.asarray(a).reshape(-1, 2) / unit).astype(int) for a in (starts, ends))
    for begin, end in zip(p, q, strict=True):
        (x, y), (dx, dy) = (begin - last).tolist(), (end - begin).tolist()
        words.append(f"m{x} {y}" + (f"l{dx} {dy}" if dx or dy else "h0"))
        last = end
    return "".join(words).replace(" -", "-")


def png_uri(pixels: npt.NDArray[np.uint8]) -> str:
    """An (h, w, 3) image as a data address."""
    height, width, _ = pixels.shape
    lines = np.zeros((height, 1 + 3 * width), dtype=np.uint8)
    lines[:, 1:] = pixels.reshape(height, -1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    data = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header)
    data += chunk(b"IDAT", zlib.compress(lines.tobytes(), 9)) + chunk(b"IEND", b"")
    return "data:image/png;base64," + base64.b64encode(data).decode()
