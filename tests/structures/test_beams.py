"""Curved beams: webs, flanges, segments, ends."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from structure_models import ANGLES, twist_deg

from fabgeo.arrays import dot, unit
from fabgeo.cad.measure import check_solid
from fabgeo.cad.plates import plate_solid
from fabgeo.errors import GeometryError, InputError
from fabgeo.strips import exact
from fabgeo.strips.model import StripModel
from fabgeo.structures.beams import BeamRule, Section, beams
from fabgeo.structures.masses import plate_mass
from fabgeo.structures.prisms import plate_prism, prism_properties, prism_volume, ruled_normals


@pytest.mark.parametrize("construction", ["trajectory", "envelope"])
def test_beams_are_developable_and_orthogonal(conical: StripModel, construction) -> None:
    section = Section(outer=-40.0, depth=300.0)
    rule = BeamRule(construction=construction)
    for beam in beams(conical, section, rule, edges=[0, 3, conical.edges - 1]):
        plates = {plate.role: plate for plate in beam.plates}
        web, flange = plates["web"].mid, plates["flange_outer"].mid
        for plate in beam.plates:
            assert twist_deg(plate.mid) < 0.01
        u = np.linspace(beam.u0, beam.u1, 33)
        angle = dot(ruled_normals(web, u), ruled_normals(flange, u))
        assert np.degrees(np.arcsin(np.abs(angle).max())) < 0.01
        if construction == "trajectory":
            depth = np.linalg.norm(web.edges(u)[1] - web.edges(u)[0], axis=-1)
            assert np.ptp(depth) < 0.05
            assert abs(depth.mean() - section.clear) < 0.05


def test_beam_segments_fit_the_truck_and_end_plates_close_them(conical: StripModel) -> None:
    box = (4000.0, 2480.0, 2500.0)
    made = beams(conical, Section(), BeamRule(box=box, gap=4.0, end_plate=15.0), edges=[2])
    assert len(made) >= 2
    assert all(b.info["box_length"] <= 4000.0 for b in made)
    assert [p.mark for p in made[0].plates][-1] == "B-02-1-EPB"
    facing = [p for b in made[:2] for p in b.plates if p.role == "end_plate"][:2]
    centres = [p.mid.points(np.array([0.5]), np.array([0.5]))[0] for p in facing]
    assert np.linalg.norm(centres[0] - centres[1]) == pytest.approx(4.0 + 15.0, abs=0.6)
    for beam in made:
        for plate in beam.plates:
            assert prism_properties(plate_prism(plate)).orientation > 0.5


def test_box_and_t_sections(conical: StripModel) -> None:
    box = beams(conical, Section(box=120.0, web=8.0), edges=[3])[0]
    webs = [p.mid for p in box.plates if p.role == "web"]
    u = np.linspace(box.u0, box.u1, 9)
    apart = webs[1].edges(u)[0] - webs[0].edges(u)[0]
    assert np.allclose(np.linalg.norm(apart, axis=-1), 128.0, atol=2e-3)
    assert max(twist_deg(w) for w in webs) < 0.01
    t = beams(conical, Section(flange_inner=0.0), edges=[3])[0]
    assert {p.role for p in t.plates} == {"web", "flange_outer"}


def test_envelope_flange_refuses_where_the_edge_is_straight() -> None:
    model = exact.cylinder(9000.0, 8000.0, ANGLES).interpolant()
    with pytest.raises(GeometryError, match=r"degenerates.*trajectories"):
        beams(model, Section(), BeamRule(construction="envelope"), edges=[2])


def test_bevelled_segments_leave_the_root_gap_and_open_to_the_groove(torus: StripModel) -> None:
    section = Section(outer=-60.0, depth=300.0, web=10.0)
    rule = BeamRule(at=(8.0, 16.0), gap=3.0, bevel=60.0)
    made = beams(torus, section, rule, edges=[4])
    gaps = []
    for first, second in pairwise(made):
        for left, right in zip(first.plates, second.plates, strict=True):
            run = left.thickness * np.tan(np.radians(30.0))
            assert left.bevel[1] == right.bevel[0] == pytest.approx(run)
            a, b = (plate_prism(plate).poles for plate in (left, right))
            across = unit(a[0, -1] - a[0, -2])
            root = (b[:2, 0] - a[:2, -1]) @ across
            groove = (b[2:, 0] - a[2:, -1]) @ across
            gaps.append(root.min())
            np.testing.assert_allclose(groove - root[::-1], 2.0 * run, rtol=0.02)
    assert min(gaps) == pytest.approx(3.0, abs=0.05)  # at the inner corner, more elsewhere
    for plate in made[1].plates:  # bevels at both ends take no volume off: what they cut they add
        expected = plate_mass(plate, 1.0).volume
        volume = prism_volume(plate_prism(plate))
        assert volume == pytest.approx(expected, rel=1e-5)
        report = check_solid(plate_solid(plate))
        assert report.sound
        assert report.tolerance <= 1e-3
        assert report.volume == pytest.approx(volume, rel=1e-6)
    assert made[1].info["bevel_deg"] == 60.0
    assert made[0].plates[0].bevel[0] == 0.0  # the beam's own end stays square


def test_end_plates_and_bevels_exclude_each_other() -> None:
    with pytest.raises(InputError, match="end plates"):
        BeamRule(end_plate=12.0, bevel=60.0)
