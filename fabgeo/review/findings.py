"""What the check of a written package reports.

Glossary
--------
finding
    One difference: the part, what was measured, what was expected, what was found.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class Finding:
    """One difference between a package and itself."""

    part: str
    what: str
    expected: str
    found: str
    file: str = ""

    def __str__(self) -> str:
        place = f" ({self.file})" if self.file else ""
        return f"{self.part}: {self.what}: expected {self.expected}, found {self.found}{place}"


@dataclass
class Findings:
    """Collects findings; numbers are compared through `near`."""

    items: list[Finding] = field(default_factory=list)

    def add(self, part: str, what: str, expected: object, found: object, file: str = "") -> None:
        """Note one difference."""
        self.items.append(Finding(part, what, _words(expected), _words(found), file))

    def near(
        self, part: str, what: str, expected: float, found: float, within: float, file: str = ""
    ) -> None:
        """Note a difference larger than `within`, or one that can't be compared."""
        if not abs(expected - found) <= within:
            self.add(part, what, expected, found, file)


@dataclass(frozen=True)
class CheckReport:
    """What `check_package` found.

    Attributes
    ----------
    findings : tuple of Finding
        Empty: the package agrees with itself.
    measured : mapping
        Figures of the package as measured here, under the keys of review.json's summary.
    seconds : mapping of step to seconds
    counts : mapping
        How much was measured: solids, panels, flat parts, sheets, files.
    """

    findings: tuple[Finding, ...]
    measured: Mapping[str, float]
    seconds: Mapping[str, float]
    counts: Mapping[str, int] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        """Whether nothing was found."""
        return not self.findings

    @property
    def parts(self) -> tuple[str, ...]:
        """The marks that findings name, in order."""
        return tuple(dict.fromkeys(finding.part for finding in self.findings))

    def lines(self) -> Iterable[str]:
        """The report for people: a line a finding, a line a figure, and the verdict last."""
        for finding in self.findings:
            yield str(finding)
        for key, value in self.measured.items():
            yield f"measured {key} = {value:.6g}"
        counted = ", ".join(f"{count} {name}" for name, count in self.counts.items())
        what = "nothing found" if self.ok else f"{len(self.findings)} findings"
        seconds = sum(self.seconds.values())
        yield f"package: {what}, {counted}, in {seconds:.1f} s"

    def as_dict(self) -> dict[str, Any]:
        """Plain data for scripts."""
        return {
            "ok": self.ok,
            "counts": dict(self.counts),
            "findings": [asdict(finding) for finding in self.findings],
            "measured": dict(self.measured),
            "seconds": dict(self.seconds),
        }


def _words(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
