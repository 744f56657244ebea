"""A solid as the build keeps it between stages and processes."""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from fabgeo.cad.report import SolidReport
from fabgeo.errors import InputError

if TYPE_CHECKING:
    from fabgeo.cad.kernel import Shape


@dataclass(frozen=True)
class Built:
    """One solid as measured, or why there is none.

    Its shape stays on the disk where the build has a folder: memory does not grow with parts.

    Attributes
    ----------
    mark : str
    data : bytes
        The shape as the kernel's bytes; empty if it failed, or if it is kept in `file`.
    report : SolidReport or None
    volume_error : float or None
        Relative difference of the solid's volume and the integral by formula, holes taken off.
    failure : str
    file : Path or None
        The entry of the cache that holds the shape.
    """

    mark: str
    data: bytes = b""
    report: SolidReport | None = None
    volume_error: float | None = None
    failure: str = ""
    file: Path | None = None

    @property
    def made(self) -> bool:
        """Whether there is a solid."""
        return bool(self.data) or self.file is not None

    @property
    def identity(self) -> str:
        """Equal for equal shapes."""
        return sha256(self.data).hexdigest() if self.file is None else self.file.name

    def shape(self) -> Shape:
        """The shape.

        Raises
        ------
        InputError
            If it is not there, or its file is gone.
        """
        from fabgeo.cad import kernel

        data = self.data
        if self.file is not None:
            from fabgeo.build.cache import read_entry

            kept = read_entry(self.file)
            data = kept.data if isinstance(kept, Built) else b""
        if not data:
            raise InputError(
                self.mark, self.failure or "its solid is gone from the cache", "build again"
            )
        return kernel.from_bytes(data)
