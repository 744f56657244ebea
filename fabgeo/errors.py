"""The errors fabgeo raises: each names the part, what was expected and what to do.

Glossary
--------
where
    What the error is about, as its owner knows it: a file and line, or a mark such as
    ``panel P-03-04``.
cure
    What the reader can do about it, in the imperative.
"""

from __future__ import annotations


class FabgeoError(Exception):
    """Base of every error that fabgeo raises on purpose.

    Parameters
    ----------
    where : str
        File, line or part that is concerned.
    problem : str
        What is wrong, and what was expected instead.
    cure : str, optional
        What to do about it.
    """

    def __init__(self, where: str, problem: str, cure: str = "") -> None:
        self.where = where
        self.problem = problem
        self.cure = cure
        super().__init__(f"{where}: {problem}" + (f"; {cure}" if cure else ""))

    def __reduce__(self) -> tuple[type, tuple[str, str, str]]:
        return type(self), (self.where, self.problem, self.cure)


class InputError(FabgeoError, ValueError):
    """Input that cannot be worked with: a file, a project setting, an argument (exit code 2)."""


class GeometryError(FabgeoError, ValueError):
    """Geometry that does not exist as asked: a folded offset, a degenerate envelope (exit 2)."""


class PartError(FabgeoError, RuntimeError):
    """One part could not be made although its input is sound; the others are built."""


class MissingExtraError(FabgeoError, ImportError):
    """An optional library is needed for this input or output."""

    def __init__(self, where: str, extra: str, problem: str = "") -> None:
        self.extra = extra
        super().__init__(
            where,
            problem or f"needs the optional libraries of the extra '{extra}'",
            f'install them with: pip install "fabgeo[{extra}]"',
        )

    def __reduce__(self) -> tuple[type, tuple[str, str, str]]:
        return type(self), (self.where, self.extra, self.problem)
