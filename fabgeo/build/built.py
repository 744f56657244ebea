"""A solid as the build keeps it between stages and processes."""

from __future__ import annotations

from dataclasses import dataclass

from fabgeo.cad.measure import SolidReport


@dataclass(frozen=True)
class Built:
    """One solid as measured, or why there is none.

    Attributes
    ----------
    mark : str
    data : bytes
        The shape as the kernel's bytes; empty if it failed.
    report : SolidReport or None
    volume_error : float or None
        Relative difference of the solid's volume and the integral by formula (without holes).
    failure : str
    """

    mark: str
    data: bytes = b""
    report: SolidReport | None = None
    volume_error: float | None = None
    failure: str = ""
