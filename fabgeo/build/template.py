"""The project file that `fabgeo init` writes: commented, and it builds as it is."""

from __future__ import annotations

import os
from pathlib import Path

from fabgeo.arrays import checked_path
from fabgeo.errors import InputError

TEMPLATE = """\
# A fabgeo project. Lengths are millimetres and angles degrees, but for the surface's own unit.
# Build it with:  fabgeo build project.toml --out outputs/first
# A table that is left out is not asked for; remove the # before a line to set it.
name = "First roof"
# ifc = true              # also model/facade.ifc, IFC4x3 (extra ifc)
# drawings = false        # no drawings/panels.pdf

[surface]
# Either a file, its path relative to this one:
#   STEP, IGES, 3dm, OBJ, OFF, STL, PLY, 3MF, or floor sections as CSV, JSON, DXF
# file = "roof.step"
# unit = "m"              # for files that do not say: mm, cm, m, in, ft
# faces = [0, 1]          # some faces of a CAD file, by number or name
# scale = 50.0            # for a model at 1:50
# or a formula of u and v (with [surface.define] for names used in it):
unit = "m"
u = [-4.0, 4.0]
v = [-6.0, 6.0]
x = "u"
y = "v"
z = "3.5 - 0.05*u**2 - 0.03*v**2"

[strips]
kind = "general"          # general, conical (offsets, cells, beams), circular, geodesic
# start = "auto"          # auto, iso, principal, sections, mesh, geodesic, model
#                         # (with "geodesic" parts = 5: five models side by side, as one package)
count = 8                 # strips
# segments = 8            # knot spans along a strip
# overhang = [0.0, 0.1]   # start = "iso": edges reach beyond the boundary by parts of their length
# corners = [[0, 0, 0], [9000, 0, 0], [9000, 6000, 0], [0, 6000, 0]]   # start = "iso", in mm: where
#                         # the boundary is divided into four sides, if those found do not suit
# give = 30.0             # strips give way towards cheaper panels, at most so far off the surface
# boundary = "auto"       # what is held on the boundary: edges, ends, all, none

[panels]
length = 2000.0           # along the strip; or count = 4, or cuts = [2.0, 4.0] (parameters)
# width = 2400.0          # at most, across: strips are divided evenly along their rulings
joint = 10.0
thickness = 3.0
material = "aluminium"
# materials = { P-02-01 = "glass" }   # of single panels, by mark
tolerance = 1.0           # how far a flat, cylindrical or conical panel may leave the fitted one
angle = 1.0               # and how much kink it may add between neighbours
# trim = true             # cut along the boundary where the model overhangs it (false: whole)
# ends = 30.0             # how far their ends may move along the strip, neighbours with them
# radii = 4               # most different radii of cylinders, or a list of them in mm
# radii_step = 100.0      # radii are multiples of this
# choice = "joint"        # panels chosen together; or "single", "thorough" (cheaper, slow)

# [cells]                 # need kind = "conical" or "circular"
# depth = -300.0          # inwards

# [beams]
# section = "I"           # I, T, box
# depth = 200.0
# standoff = 60.0         # from the model to the outer flange
# flange_width = 100.0
# flange = 10.0
# web = 8.0
# end_plate = 12.0        # between segments; or welded: weld_gap = 3.0 and bevel = 60.0 (degrees)
# layout = "curved"       # "mesh": straight from panel joint to panel joint

# [crossed]               # beams of a second model that runs across; keys as in [beams]
# model = "strips.json"   # of an earlier build

# [connectors]
# spacing = 800.0

[nesting]
spacing = 6.0
margin = 10.0
rotations = "steps"       # steps of 90 degrees; "grain": 0 and 180; "free"
seconds = 10.0            # steps = 3 instead: the same layout every time
# split = true            # parts too long for every sheet are divided at rulings

# [[stock]]               # common sizes otherwise
# material = "aluminium"
# length = 3000.0
# width = 1500.0
# quantity = 20

# [materials.aluminium]   # density kg/m3, E and yield stress N/mm2, least radius of the rolls
# yield_stress = 130.0
# rolls_radius = 100.0

# [cutting]
# version = "R2010"       # R2010, R2000, R12
# curves = "arcs"         # arcs, splines, polylines
# tolerance = 0.05

# [limits]
# deviation_max_mm = 20.0
# twist_max_deg = 0.02
# covered_share = 0.98    # of the surface, by strips
# gap_max_mm = 2.0
"""


def write_template(path: Path) -> Path:
    """Write the template.

    Raises
    ------
    InputError
        If something of that name is there already, be it a link that leads nowhere; if its folder
        is not, or nothing can be written there.
    """
    path = checked_path("project file", path)
    if os.path.lexists(path):
        raise InputError(str(path), "is there already", "choose another name")
    if not os.path.isdir(path.parent):
        raise InputError(str(path.parent)[:200], "no such folder", "make it first")
    try:
        with path.open("x", encoding="utf-8") as file:  # follows no link
            file.write(TEMPLATE)
    except (OSError, UnicodeEncodeError) as error:
        problem = error.strerror if isinstance(error, OSError) else error.reason
        raise InputError(ascii(str(path))[1:201], f"cannot be written: {problem}") from error
    return path
