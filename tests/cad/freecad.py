"""FreeCAD's own view of a STEP file: a helper for tests, run headless in its own process."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

# With link groups FreeCAD 0.20 crashes on any assembly; equal instances collapse into arrays
# unless both preferences are off.
_SCRIPT = """
import json, os
import FreeCAD, Import
for group in ("Mod/Import", "Mod/Import/hSTEP"):
    preferences = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/" + group)
    preferences.SetBool("UseBaseName", False)
    preferences.SetBool("ReduceObjects", False)
# Labels as the file has them; comparing each with all others is what takes long otherwise.
documents = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Document")
documents.SetBool("DuplicateLabels", True)
seen = {}


def judged(shape):  # once for all placed instances
    alike = seen.setdefault(len(shape.Faces), [])
    for other, found in alike:
        if shape.isPartner(other):
            return found
    found = {
        "volume": shape.Volume,
        "valid": bool(shape.isValid()),
        "solids": len(shape.Solids),
        "closed": all(s.isClosed() for s in shape.Solids),
        "faces": len(shape.Faces),
    }
    alike.append((shape, found))
    return found


out = {"parts": [], "groups": []}
try:
    document = FreeCAD.newDocument("check")
    Import.insert(os.environ["FABGEO_STEP"], document.Name, useLinkGroup=False)
    for item in document.Objects:
        if item.TypeId == "Part::Feature":
            out["parts"].append({"label": item.Label, **judged(item.Shape)})
        elif item.TypeId == "App::Part":
            out["groups"].append(item.Label)
except Exception as error:
    out["error"] = repr(error)
with open(os.environ["FABGEO_OUT"], "w", encoding="utf-8") as stream:
    json.dump(out, stream)
"""


@dataclass(frozen=True)
class FreeCadPart:
    label: str
    volume: float
    valid: bool
    solids: int
    closed: bool
    faces: int


@dataclass(frozen=True)
class FreeCadView:
    parts: list[FreeCadPart]
    groups: list[str]


def open_step(path: Path, folder: Path, seconds: float = 300.0) -> FreeCadView:
    """Open a STEP file in FreeCAD and tell what it sees; skips where FreeCAD is not installed."""
    command = shutil.which("freecadcmd") or shutil.which("FreeCADCmd")
    if command is None:
        pytest.skip("FreeCAD (freecadcmd) is not installed")
    script, out = folder / "open_step.py", folder / "freecad.json"
    script.write_text(_SCRIPT, encoding="utf-8")
    environment = {
        **os.environ,
        "FABGEO_STEP": str(path),
        "FABGEO_OUT": str(out),
        "QT_QPA_PLATFORM": "offscreen",
        "HOME": str(folder),  # its preferences stay out of the user's
    }
    environment.pop("PYTHONPATH", None)
    done = subprocess.run(
        [command, str(script)],
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=seconds,
        check=False,
    )
    assert out.is_file(), done.stderr.decode(errors="replace")[-2000:]
    found = json.loads(out.read_text(encoding="utf-8"))
    assert "error" not in found, found["error"]
    return FreeCadView([FreeCadPart(**part) for part in found["parts"]], found["groups"])
