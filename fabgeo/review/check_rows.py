"""The schedules against the solids: masses, centres, thickness, radii and classes."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from fabgeo.arrays import Array, cross, unit
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.solid_plate import SolidPlate, polyline_length

CENTRE = "centre of gravity"
MASS = 5e-4  # relative
PLACE = 0.15  # mm, the columns carry one decimal
RADIUS = 0.01  # relative
CURVATURE = 2e-7  # 1/mm: what a nearly flat plate's curvature is measured to
TWIST = 0.003  # degrees
GAUSSIAN = 1e-6  # times size squared: of a rise of 0.25 mm along and across 2 m
UNEVEN = 4.0  # how much faster than evenly normals may turn somewhere along a ruling
ASKEW = 1.03  # of a flange's thickness: what a web reaches through it, up to 14 degrees off square
DEPTH = 0.02  # mm: two decimals are written; 503 beams were off by 2e-4 at most besides
SHAPED = {"half_angle_deg": ("cone",)}  # columns that panels of some classes have
FLAT_RADIUS = 1e6  # mm: a radius beyond is not compared


def check_rows(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Compare every row that has a measured solid."""
    densities = _densities(package, measured)
    for mark, row in package.cut_rows.items():
        plate = measured.plates.get(mark)
        if plate is None:
            continue
        _plain(mark, row, plate, densities, findings)
        if plate.rails() is not None:
            _bent(package, mark, row, plate, measured, findings)
    _beams(package, measured, findings)
    _cells(package, measured, findings)


def _densities(package: WrittenPackage, measured: Measured) -> dict[str, float]:
    """kg/mm3 by material: the project's, else the median of what the rows say."""
    found: dict[str, list[float]] = defaultdict(list)
    for mark, row in package.cut_rows.items():
        mass, plate = number(row, "mass_kg"), measured.plates.get(mark)
        if mass and plate is not None:
            found[row.get("material", "")].append(mass / plate.volume)
    return {material: float(np.median(values)) for material, values in found.items()}


def _plain(
    mark: str,
    row: dict[str, str],
    plate: SolidPlate,
    densities: dict[str, float],
    findings: Findings,
) -> None:
    mass, density = number(row, "mass_kg"), densities.get(row.get("material", ""))
    if mass is not None and density:
        expected = density * plate.volume
        findings.near(mark, "mass_kg by its solid", expected, mass, MASS * expected + 1e-3)
    thickness = number(row, "thickness_mm")
    if thickness is not None:
        findings.near(mark, "thickness_mm of its solid", plate.thickness, thickness, 0.02)
    _centre(mark, row, plate.centre, findings)


def _centre(mark: str, row: dict[str, str], centre: Array, findings: Findings) -> None:
    stated = [number(row, f"cog_{axis}_mm") for axis in "xyz"]
    known = [value for value in stated if value is not None]
    if len(known) == 3:
        away = float(np.linalg.norm(np.array(known) - centre))
        if not away <= PLACE:
            words = " ".join(f"{v:.1f}" for v in centre)
            findings.add(mark, CENTRE, words, " ".join(f"{v:.1f}" for v in known))


def _bent(
    package: WrittenPackage,
    mark: str,
    row: dict[str, str],
    plate: SolidPlate,
    measured: Measured,
    findings: Findings,
) -> None:
    """Radii, twist and class of the mid-surface."""
    first, second = plate.normals
    sine = np.linalg.norm(cross(first, second), axis=1)
    twist = np.degrees(np.arcsin(np.minimum(sine, 1.0)))
    if row.get("class"):
        measured.worst("panel_twist_max_deg", float(twist.max()))
    stated = number(row, "twist_max_deg")
    if stated is not None:
        within = TWIST + 0.05 * stated
        findings.near(mark, "twist_max_deg of its solid", float(twist.max()), stated, within)
    _developable(package, mark, plate, findings)
    radii = plate.radii
    low, high = number(row, "radius_min_mm"), number(row, "radius_max_mm")
    kind = row.get("class", "developable")
    if low is not None and 0.0 < low < FLAT_RADIUS and kind != "flat":
        findings.near(mark, "radius_min_mm of its solid", float(radii.min()), low,
                      _within(radii.min()) + _between(radii))  # fmt: skip
    if high is not None and 0.0 < high < FLAT_RADIUS and kind in ("cylinder", "cone"):
        findings.near(mark, "radius_max_mm of its solid", float(radii.max()), high,
                      _within(radii.max()))  # fmt: skip
    for key, kinds in SHAPED.items():
        if row.get("class") and bool((row.get(key) or "").strip()) != (kind in kinds):
            words = "stated" if kind in kinds else f"none for class {kind}"
            findings.add(mark, key, words, row.get(key) or "none")
    if kind in ("flat", "cylinder", "cone"):
        _class(package, mark, kind, row, plate, unit(first + second), findings)


def _developable(package: WrittenPackage, mark: str, plate: SolidPlate, findings: Findings) -> None:
    """Gaussian curvature of the skins: none but what the twist along rulings brings with it.

    Normals that turn by t along a ruling of length w bend a skin by -(t / w)^2.
    """
    first, second = plate.four_sided
    width = float(np.linalg.norm(second - first, axis=1).min())
    size = float(plate.lengths.sum()) / 4.0
    part = (package.review.get("parts") or {}).get(mark) or {}
    twist = np.radians(float(part.get("twist_max_deg") or 0.0))
    limit = max(GAUSSIAN, float(UNEVEN * twist * size / max(width, 1e-9)) ** 2)
    if plate.gaussian > limit:
        what, words = "Gaussian curvature times size squared", f"at most {limit:.3g}"
        findings.add(mark, what, words, plate.gaussian)


def _between(radii: Array) -> float:
    """How much the radius changes beside its least sample (rails, n): so much less it may get."""
    rail, least = np.unravel_index(radii.argmin(), radii.shape)
    return float(np.ptp(radii[rail, max(least - 1, 0) : least + 2]))


def _within(radius: float) -> float:
    return float(RADIUS * radius + CURVATURE * radius**2)


def _class(
    package: WrittenPackage,
    mark: str,
    kind: str,
    row: dict[str, str],
    plate: SolidPlate,
    normals: Array,
    findings: Findings,
) -> None:
    """Normals of a plane are equal, of a cylinder in a plane, of a cone at one angle to an axis."""
    tolerance = np.radians(float(package.setting("panels", "angle", 1.0)))
    centred = normals - normals.mean(axis=0)
    if kind == "flat":
        spread = float(np.linalg.norm(centred, axis=1).max())
        if spread > tolerance:
            findings.add(mark, "class", "flat", f"normals turn by {np.degrees(2 * spread):.3f} deg")
        return
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    axis = axes[2]
    off = float(np.abs(centred @ axis).max())
    if off > tolerance:
        findings.add(mark, "class", kind, f"normals off a circle by {np.degrees(off):.3f} deg")
    rails = plate.rails()
    if kind == "cylinder" and rails is not None and float(np.ptp(normals @ axes[0])) > 0.02:
        rulings = rails[1] - rails[0]
        along = np.sum(rulings * axis, axis=1)
        across = np.sqrt(np.maximum(np.sum(rulings**2, axis=1) - along**2, 0.0))
        # A chord across the axis sags from the cylinder by its half squared over 2 R.
        away = float(((0.5 * across) ** 2 / (2.0 * plate.radii)).max())
        allowed = float(package.setting("panels", "tolerance", 1.0))
        if away > allowed:
            findings.add(mark, "class", "cylinder", f"rulings sag by {away:.3f} mm")
    half = number(row, "half_angle_deg")
    if kind == "cone" and half is not None and float(np.ptp(normals @ axes[0])) > 0.05:
        found = float(np.degrees(np.arcsin(min(abs(float(normals.mean(axis=0) @ axis)), 1.0))))
        findings.near(mark, "half_angle_deg of its solid", found, half, max(0.5, 0.05 * found))


def _beams(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """A beam's mass is its plates' mass; its centre theirs."""
    children: dict[str, list[dict[str, str]]] = defaultdict(list)
    for row in package.tables["plates"]:
        children[row.get("parent", "")].append(row)
    for row in package.tables["beams"]:
        mark, mass = row.get("mark", ""), number(row, "mass_kg")
        own = children.get(mark, [])
        masses = [number(plate, "mass_kg") or 0.0 for plate in own]
        count = number(row, "plates")
        if count is not None:
            findings.near(mark, "plates in plates.csv", len(own), count, 0.0)
        if mass is not None and own:
            findings.near(mark, "mass_kg of its plates", sum(masses), mass, 1e-3 * sum(masses))
        _section(mark, row, own, measured, findings)
        marks = [plate.get("mark", "") for plate in own]
        if own and sum(masses) > 0.0 and all(m in measured.centres for m in marks):
            centres = np.array([measured.centres[m] for m in marks])
            _centre(mark, row, np.array(masses) @ centres / sum(masses), findings)


def _section(
    mark: str,
    row: dict[str, str],
    own: list[dict[str, str]],
    measured: Measured,
    findings: Findings,
) -> None:
    """Length and depth of a beam by its web: rulings and what the flanges add to them at most."""
    webs = [measured.plates.get(plate.get("mark", "")) for plate in own
            if plate.get("role") == "web"]  # fmt: skip
    if len(webs) != 1 or webs[0] is None or webs[0].rails() is None:
        return
    first, second = webs[0].four_sided
    rulings = np.linalg.norm(second - first, axis=1)
    flanges = [number(plate, "thickness_mm") or 0.0 for plate in own
               if plate.get("role", "").startswith("flange")]  # fmt: skip
    most = ASKEW * sum(flanges)
    for key, least in (("depth_min_mm", rulings.min()), ("depth_max_mm", rulings.max())):
        depth = number(row, key)
        if depth is not None and not least - DEPTH <= depth <= least + most + DEPTH:
            words = f"{least:.2f} to {least + most:.2f}"
            findings.add(mark, f"{key} of its web and flanges", words, depth)
    length = number(row, "length_mm")
    rails = [polyline_length(rail) for rail in (first, second)]
    if length is not None and not 0.95 * min(rails) <= length <= 1.05 * max(rails):
        words = f"near {min(rails):.1f} to {max(rails):.1f}"
        findings.add(mark, "length_mm of its web", words, length)


def _cells(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """A cell's volume and centre are its solid's."""
    for row in package.tables["cells"]:
        mark, stated = row.get("mark", ""), number(row, "volume_m3")
        if mark in measured.centres:
            _centre(mark, row, measured.centres[mark], findings)
        if mark in measured.volumes and stated is not None:
            found = measured.volumes[mark] / 1e9
            findings.near(mark, "volume_m3 of its solid", found, stated, MASS * found + 1e-6)
