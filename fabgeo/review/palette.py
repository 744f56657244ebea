"""Colours that colour-blind people tell apart: Okabe and Ito's for classes, cividis for figures.

Sources: M. Okabe, K. Ito, Color Universal Design (2008); J. R. Nunez, C. R. Anderton, R. S.
Renslow, PLoS ONE 13 (2018) e0199239 (cividis, here by a few of its values, interpolated linearly).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fabgeo.arrays import Array

CLASSES = {
    "flat": "#56b4e9",
    "cylinder": "#009e73",
    "cone": "#e69f00",
    "developable": "#cc79a7",
    "other": "#999999",
}
VERDICTS = {"good": "#4a90b8", "warn": "#e69f00", "fail": "#c8401e", "not asked": "#a0a0a0"}
SIGNS = {"good": "✓", "warn": "!", "fail": "✗", "not asked": "–"}
CIVIDIS = ("#00224e", "#2a3f6d", "#575d6d", "#7d7c78", "#a59c74", "#d2c060", "#fee838")
DIVERGING = ("#08417c", "#4a8fc4", "#b5d4e9", "#f5f5f2", "#f6c08a", "#d97a2b", "#8c3b04")


def rgb(colour: str) -> tuple[int, int, int]:
    """Red, green, blue (0..255) of ``#rrggbb``."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def ramp(colours: tuple[str, ...], values: Array) -> npt.NDArray[np.uint8]:
    """Colours (..., 3) of values in 0..1, linear between the given ones."""
    table = np.array([rgb(colour) for colour in colours], dtype=float)
    sites = np.linspace(0.0, 1.0, len(table))
    clipped = np.clip(values, 0.0, 1.0)
    channels = [np.interp(clipped, sites, table[:, c]) for c in range(3)]
    return np.rint(np.stack(channels, axis=-1)).astype(np.uint8)
