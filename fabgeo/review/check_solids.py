"""The STEP model: valid, closed solids, named as the schedules name them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor
from functools import partial
from itertools import chain, islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from fabgeo.errors import InputError
from fabgeo.review.check_work import each, noted
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured, Piece
from fabgeo.review.package import WrittenPackage
from fabgeo.review.solid_plate import VOLUME_EPS, solid_plate
from fabgeo.review.step_faces import turned_faces

if TYPE_CHECKING:
    from fabgeo.cad.readback import ReadPart

LOOSE = 5e-3  # mm: sound packages have up to 3.5e-4, at ends off their planes
FAMILIES = {
    "P-": ("panels", "layers"),
    "C-": ("cells",),
    "W-": ("walls",),
    "B-": ("beams",),
    "K-": ("connectors",),
}


def check_solids(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Read the model back; fill `measured` with volumes, centres and plates."""
    if not package.step.is_file():
        for mark in package.cut_rows:
            findings.add(mark, "solid in model/facade.step", "present", "no model file")
        return
    from joblib import effective_n_jobs

    from fabgeo.cad.isolated import read_isolated
    from fabgeo.cad.stepshare import step_shares

    jobs: Any = package.jobs  # joblib takes None too: as `parallel_config` says
    task = partial(_measure_share, frozenset(package.cut_rows))
    shares = step_shares(package.step)
    begun = list(islice(shares, 2))
    shares = chain(begun, shares)
    try:
        if len(begun) > 1 and effective_n_jobs(jobs) > 1:
            each(task, shares, jobs, measured, findings, few=0, batch=1)
        else:
            for share in shares:
                own, notes = read_isolated(package.step, noted, task, share)
                measured.take(own)
                findings.items += notes.items
    except (InputError, BrokenExecutor) as error:
        why = error.problem if isinstance(error, InputError) else "is damaged: its reader crashed"
        findings.add("model/facade.step", "STEP file", "readable", why)
        return
    measured.names.update(Counter(path[-1] for path in measured.fixings))
    measured.figures["solids"] = float(measured.parts)
    measured.figures["invalid_solids"] = float(len(measured.unsound))
    titles = {package.project.get("name"), package.manifest.get("name")} - {None}
    for root in sorted(measured.roots - titles) if titles else ():
        findings.add("model/facade.step", "name of its root", " or ".join(map(str, titles)), root)
    _names(package, measured, findings)


def _measure_share(
    cut: frozenset[str], text: bytes, measured: Measured, findings: Findings
) -> None:
    """Read and measure the solids of one share of the model, or of all of it."""
    from fabgeo.cad.readback import read_package_step

    with TemporaryDirectory() as folder:
        file = Path(folder) / "facade.step"
        file.write_bytes(text)
        parts = read_package_step(file)
    pieces: Counter[tuple[str, ...]] = Counter()
    for part in parts:
        k = _fixing(part)
        if k is None:
            measured.names[part.name] = measured.names.get(part.name, 0) + 1
            _in_family(part.name, part.path[:-1], findings)
        else:  # a connector holds its product, which is placed in it
            measured.fixings[part.path[: k + 1]] = part.frames[: k + 2][-1]
            measured.products[part.path[k]] = part.path[k + 1 :][:1]
            pieces[part.path] += 1
    for path in measured.fixings:
        _in_family(path[-1], path[:-1], findings)
    measured.roots.update(part.path[0] for part in parts if len(part.path) > 1)
    _placed_once(pieces, findings)
    measured.pieces.update(_pieces(parts))
    measured.parts = len(parts)
    for part in _products(parts):
        _measure(part, part.name in cut, measured, findings)
    try:
        turned = turned_faces(text.decode("utf-8", errors="replace"))
    except (LookupError, ValueError) as error:  # of references that lead nowhere
        findings.add("model/facade.step", "entities of its faces", "complete", repr(error))
        return
    for name, count in turned.items():
        findings.add(name, "faces of its solid turned inside out", 0, count)


def _in_family(name: str, above: tuple[str, ...], findings: Findings) -> None:
    """Every mark below the assembly of its family, that below the project's (handover.md)."""
    families = FAMILIES.get(name[:2])
    if families and (len(above) < 2 or above[1] not in families):
        findings.add(name, "assembly in the model", " or ".join(families), " / ".join(above[1:]))


def _placed_once(pieces: Counter[tuple[str, ...]], findings: Findings) -> None:
    """A connector of which every piece is there twice was placed twice."""
    least: dict[str, int] = {}
    for path, count in pieces.items():
        mark = next(name for name in path if name.startswith("K-"))
        least[mark] = min(least.get(mark, count), count)
    for mark, count in least.items():
        if count > 1:
            findings.add(mark, "times in the model", 1, count)


def _pieces(parts: list[ReadPart]) -> dict[str, tuple[Piece, ...]]:
    """Pieces of every product of fixings, those of the first connector that holds it."""
    first: dict[str, tuple[str, ...]] = {}
    found: dict[str, list[Piece]] = {}
    for part in parts:
        k = _fixing(part)
        if k is None or len(part.path) < k + 3:  # a product of one solid has no pieces
            continue
        product = part.path[k + 1]
        if first.setdefault(product, part.path[: k + 1]) == part.path[: k + 1]:
            piece = Piece(part.name, *part.bounding_box(part.frames[k + 1]))
            found.setdefault(product, []).append(piece)
    return {product: tuple(own) for product, own in found.items()}


def _products(parts: list[ReadPart]) -> Iterator[ReadPart]:
    """All parts, but of equal fixings, which are one product, only the first."""
    seen: set[int] = set()
    for part in parts:
        if _fixing(part) is None:
            yield part
        elif part.definition not in seen:
            seen.add(part.definition)
            yield part


def _measure(part: ReadPart, cut: bool, measured: Measured, findings: Findings) -> None:
    """Measure one solid; as a plate if it is cut flat."""
    if not _sound(part, measured, findings):
        measured.unsound.add("/".join(part.path[-2:]))
    elif cut:
        of_part = measured.volumes[part.name], measured.centres[part.name]
        plate = solid_plate(part, *of_part)
        if plate is None:
            findings.add(part.name, "solid", "a plate with two skins", "another shape")
            return
        measured.plates[part.name] = plate
        measured.worst("gaussian_curvature_size2", plate.gaussian)
    elif part.name.startswith("C-"):
        measured.cells[part.name] = part.edge_points()


def _fixing(part: ReadPart) -> int | None:
    """Place in the part's path of the connector that it belongs to."""
    return next((k for k, name in enumerate(part.path) if name.startswith("K-")), None)


def _subject(part: ReadPart) -> tuple[str, str]:
    """Whom findings about a part name: itself, or the product of fixings that it is a piece of."""
    k = _fixing(part)
    if k is None:
        return part.name, ""
    return part.path[min(k + 1, len(part.path) - 1)], f" of its {part.name}"


def _sound(part: ReadPart, measured: Measured, findings: Findings) -> bool:
    """Whether a part is one valid, closed solid turned outwards; notes what it is not."""
    from fabgeo.cad import kernel, measure

    before, (name, of) = len(findings.items), _subject(part)
    solids = len(kernel.solids(part.shape))
    if solids != 1:
        findings.add(name, f"solids in the model{of}", 1, solids)
    if not measure.is_valid(part.shape):
        findings.add(name, f"solid in the model{of}", "valid", "not valid")
    loose = measure.max_tolerance(part.shape)
    if loose > LOOSE:  # a reader makes what does not fit valid by wide tolerances
        findings.add(name, f"edges off their faces in mm{of}", f"at most {LOOSE}", loose)
    if not measure.is_closed(part.shape):
        findings.add(name, f"solid in the model{of}", "closed", "open or turned faces")
    if of:  # threads take long to integrate, and no row states them
        return len(findings.items) == before
    volume, centre = measure.volume(part.shape, VOLUME_EPS)
    if volume <= 0.0:
        findings.add(part.name, "volume", "positive", volume)
    measured.volumes[part.name] = volume
    measured.centres[part.name] = centre
    return len(findings.items) == before


def _names(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Marks of the model against marks of the schedules."""
    tables = package.tables
    expected = {row.get("mark", "") for row in (*tables["panels"], *tables["plates"])}
    expected |= {row.get("mark", "") for row in (*tables["connectors"], *tables["cells"])}
    for mark in sorted(expected):
        count = measured.names.get(mark, 0)
        if count != 1:
            findings.add(mark, "solids of this name in the model", 1, count)
    for row in tables["connectors"]:
        mark, stated = row.get("mark", ""), row.get("product", "")
        for found in measured.products.get(mark, ()):
            if found != stated:
                findings.add(mark, "product in connectors.csv", found, stated)
    known = expected | {row.get("mark", "") for row in tables["beams"]}
    for name in sorted(set(measured.names) - known):
        findings.add(name, "row in the schedules", "present", "missing")
