"""Every file of the manifest is present, unaltered and whole, and none is beside them."""

from __future__ import annotations

from pathlib import Path

from fabgeo.review.findings import Findings
from fabgeo.review.manifest import package_files, sha256_of
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage

ENDS = {".pdf": b"%%EOF", ".html": b"</html>", ".svg": b"</svg>", ".step": b"END-ISO-10303-21;"}
"""What files of a kind end with."""


def check_files(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Compare the manifest with the folder; marks are read off file names of cut parts."""
    stated = package.manifest.get("files")
    if not isinstance(stated, dict) or not stated:
        findings.add("manifest.json", "sha256 of every file", "a list of files", "none")
        return
    present = package_files(package.folder)
    for name, value in stated.items():
        if name not in present:
            findings.add(_subject(name), "file of the manifest", "present", "missing", name)
        elif sha256_of(present[name]) != value:
            findings.add(_subject(name), "sha256 of the file", "as in the manifest", "other", name)
        elif not _whole(present[name]):
            findings.add(_subject(name), "end of the file", "present", "missing", name)
    for name in sorted(set(present) - set(stated)):
        findings.add(_subject(name), "file", "none that the manifest omits", "extra", name)


def _whole(path: Path) -> bool:
    """Whether a file of a kind whose end is known has it: it was not cut off."""
    end, size = ENDS.get(path.suffix, b""), path.stat().st_size
    with path.open("rb") as stream:
        if path.suffix == ".glb":  # its header tells its length
            return int.from_bytes(stream.read(12)[8:], "little") == size
        stream.seek(max(size - len(end) - 2, 0))
        return end in stream.read()


def _subject(name: str) -> str:
    """The part's mark for a cut part's file, else the file itself."""
    if name.startswith("cut/parts/"):
        return name.rsplit("/", 1)[1].split(".", 1)[0]
    return name
