"""Gaps and kinks of panels that have changed since they were chosen, such as those cut."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fabgeo.panels.carrier import Carriers
from fabgeo.panels.classify import PanelChoice
from fabgeo.panels.joints import joints_of
from fabgeo.panels.pool import CLASSES, Pool, pair_limits
from fabgeo.panels.samples import PanelInput
from fabgeo.panels.shapes import Plane
from fabgeo.panels.worst import worst_of


def measured_again(
    choices: Sequence[PanelChoice], panels: Sequence[PanelInput]
) -> list[PanelChoice]:
    """The choices with gaps and kinks of what is left of their panels and of their joints."""
    none = Plane(np.zeros(3), np.eye(3), 0.0, 0.0)
    carriers = Carriers.joined([(choice.shape or none).batch for choice in choices])
    kinds = np.array([CLASSES.index(choice.cls) for choice in choices])
    zero = np.zeros(len(choices))
    pool = Pool(np.arange(len(choices)), kinds, carriers, zero, zero, zero)
    joints = joints_of(panels)
    ends = joints.panels[:, 0], joints.panels[:, 1]
    worst = worst_of(joints, *pair_limits(pool, joints, np.arange(len(joints)), *ends), len(panels))
    return [
        replace(
            choice,
            fitted=panel.patch,
            gap_mm=seen.gap,
            gap_edge=seen.gap_edge,
            kink_added_deg=float(np.degrees(seen.added)),
            kink_own_deg=float(np.degrees(seen.own)),
            kink_edge=seen.kink_edge,
        )
        for choice, panel, seen in zip(choices, panels, worst, strict=True)
    ]
