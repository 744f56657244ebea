"""The schedules against the solids: masses, centres, thickness, radii and classes."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from fabgeo.arrays import Array, cross, unit
from fabgeo.review.check_axes import check_axis
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.rails import diagonals_apart
from fabgeo.review.solid_plate import SolidPlate, developed

CENTRE = "centre of gravity"
MASS = 5e-4  # relative
PLACE = 0.15  # mm, the columns carry one decimal
RADIUS = 0.01  # relative
CURVATURE = 2e-7  # 1/mm: what a nearly flat plate's curvature is measured to
TWIST = 0.003  # degrees
GAUSSIAN = 1e-6  # times size squared: of a rise of 0.25 mm along and across 2 m
UNEVEN = 4.0  # how much faster than evenly normals may turn somewhere along a ruling
SHAPED = {"half_angle_deg": ("cone",)}  # columns that panels of some classes have
FLAT_RADIUS = 1e6  # mm: a radius beyond is not compared
NEAR = 4  # samples of a web beside which its largest radius was looked for
DIAGONALS = 0.01, 0.1  # mm, and relative
FLANGE = 0.05  # mm: of 2,500 panels none changed more than it deviates
CAMBER = 0.02, 6e-4  # mm, and relative: 350 plates were off by rounding and 2e-4 at most


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
    _cells(package, measured, findings)


def _densities(package: WrittenPackage, measured: Measured) -> dict[str, float]:
    """kg/mm3 by material: the project's, else the median of what the rows say."""
    found: dict[str, list[float]] = defaultdict(list)
    for mark, row in package.cut_rows.items():
        mass, plate = number(row, "mass_kg"), measured.plates.get(mark)
        if mass is not None and mass > 0.0 and plate is not None:
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
    check_centre(mark, row, plate.centre, findings)


def check_centre(mark: str, row: dict[str, str], centre: Array, findings: Findings) -> None:
    """Compare a row's centre of gravity with a measured one (3,)."""
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
    _row_of_panel(mark, row, plate, findings)
    kind = row.get("class", "developable")
    _radii(mark, kind, row, plate.radii, findings)
    _camber(mark, row, plate, findings)
    for key, kinds in SHAPED.items():
        if row.get("class") and bool((row.get(key) or "").strip()) != (kind in kinds):
            words = "stated" if kind in kinds else f"none for class {kind}"
            findings.add(mark, key, words, row.get(key) or "none")
    if kind in ("flat", "cylinder", "cone"):
        _class(package, mark, kind, plate, unit(first + second), findings)
    if kind in ("cylinder", "cone"):
        check_axis(mark, kind, row, plate, findings)


def _row_of_panel(mark: str, row: dict[str, str], plate: SolidPlate, findings: Findings) -> None:
    """Figures of the panel's own shape; its distance from a flange changes no more than it does."""
    stated = number(row, "developability_mm")
    if stated is not None:
        found = diagonals_apart(*plate.four_sided)
        size = float(np.linalg.norm(np.subtract(*plate.four_sided), axis=1).max())
        within = DIAGONALS[0] + DIAGONALS[1] * stated + np.radians(TWIST) * size
        findings.near(mark, "developability_mm of its solid", float(found.max()), stated, within)
    flange, fit = number(row, "flange_mm"), number(row, "fit_deviation_mm")
    if flange is not None and fit is not None and flange > fit + FLANGE + 0.05 * fit:
        findings.add(mark, "flange_mm", f"at most fit_deviation_mm, {fit:g}", flange)


def _radii(mark: str, kind: str, row: dict[str, str], radii: Array, findings: Findings) -> None:
    """Least and largest bending radius; what is nearly flat somewhere is compared by its least."""
    low, high = number(row, "radius_min_mm"), number(row, "radius_max_mm")
    least, most = float(radii.min()), float(radii.max())
    if low is None and kind != "flat" and least < FLAT_RADIUS:
        findings.add(mark, "radius_min_mm of its solid", least, "none")
    if low is not None and 0.0 < low < FLAT_RADIUS and kind != "flat":
        within = _within(least) + _between(radii)
        findings.near(mark, "radius_min_mm of its solid", least, low, within)
    if high is None or not 0.0 < high < FLAT_RADIUS:
        return
    if kind in ("cylinder", "cone"):
        findings.near(mark, "radius_max_mm of its solid", most, high, _within(most))
    elif "class" not in row and kind != "flat":
        # Of a web whose bending turns over, the largest is that of some place near there.
        curvature = 1.0 / radii
        beside = NEAR if curvature.min() < 0.1 * curvature.max() else 1
        within = RADIUS * curvature.min() + CURVATURE + _between(curvature, beside)
        if not abs(1.0 / high - curvature.min()) <= within:
            findings.add(mark, "radius_max_mm of its solid", most, high)


def _camber(mark: str, row: dict[str, str], plate: SolidPlate, findings: Findings) -> None:
    """The largest rise over its chord of one of the flat part's two edges that rulings join."""
    stated = number(row, "camber_mm")
    if stated is not None:
        rises = [_rise(edge) for edge in developed(*plate.four_sided)]
        nearest = min(rises, key=lambda rise: abs(rise - stated))
        within = CAMBER[0] + CAMBER[1] * nearest
        findings.near(mark, "camber_mm of its solid laid flat", nearest, stated, within)


def _rise(points: Array) -> float:
    chord, away = points[-1] - points[0], points - points[0]
    rise = away[:, 1] * chord[0] - away[:, 0] * chord[1]
    return float(np.abs(rise).max() / np.linalg.norm(chord))


def _developable(package: WrittenPackage, mark: str, plate: SolidPlate, findings: Findings) -> None:
    """Gaussian curvature of the skins: none but what the twist along rulings brings with it.

    Normals that turn by t along a ruling of length w bend a skin by -(t / w)^2.
    """
    first, second = plate.four_sided
    width = float(np.linalg.norm(second - first, axis=1).min())
    size = float(plate.lengths.sum()) / 4.0
    part = (package.review.get("parts") or {}).get(mark) or {}
    stated = part.get("twist_max_deg") or 0.0
    if not isinstance(stated, int | float):
        findings.add(mark, "twist_max_deg in checks/review.json", "a number", stated)
        stated = 0.0
    twist = np.radians(float(stated))
    limit = max(GAUSSIAN, float(UNEVEN * twist * size / max(width, 1e-9)) ** 2)
    if plate.gaussian > limit:
        what, words = "Gaussian curvature times size squared", f"at most {limit:.3g}"
        findings.add(mark, what, words, plate.gaussian)


def _between(values: Array, beside: int = 1) -> float:
    """How much values (rails, n) change beside the least sample: so much less it may get."""
    rail, least = np.unravel_index(values.argmin(), values.shape)
    return float(np.ptp(values[rail, max(least - beside, 0) : least + beside + 1]))


def _within(radius: float) -> float:
    return float(RADIUS * radius + CURVATURE * radius**2)


def _class(
    package: WrittenPackage,
    mark: str,
    kind: str,
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


def _cells(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """A cell's volume and centre are its solid's."""
    for row in package.tables["cells"]:
        mark, stated = row.get("mark", ""), number(row, "volume_m3")
        if mark in measured.centres:
            check_centre(mark, row, measured.centres[mark], findings)
        if mark in measured.volumes and stated is not None:
            found = measured.volumes[mark] / 1e9
            findings.near(mark, "volume_m3 of its solid", found, stated, MASS * found + 1e-6)
