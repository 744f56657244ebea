"""Every file of the manifest is present and unaltered, and none is beside them."""

from __future__ import annotations

from fabgeo.review.findings import Findings
from fabgeo.review.manifest import package_files, sha256_of
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage


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
    for name in sorted(set(present) - set(stated)):
        findings.add(_subject(name), "file", "none that the manifest omits", "extra", name)


def _subject(name: str) -> str:
    """The part's mark for a cut part's file, else the file itself."""
    if name.startswith("cut/parts/"):
        return name.rsplit("/", 1)[1].split(".", 1)[0]
    return name
