"""The output folder: one build at a time, whole packages only, nothing outside."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fabgeo.build.cache import Cache
from fabgeo.build.folder import Folder, open_folder
from fabgeo.errors import FabgeoError, InputError
from fabgeo.review.manifest import sha256_of

HOLD = """
import sys
from fabgeo.build.folder import open_folder
with open_folder(sys.argv[1]):
    print("held", flush=True)
    sys.stdin.read()
"""


def write(out: Path, **texts: str) -> None:
    with open_folder(out) as folder:
        for name, content in texts.items():
            folder.text(f"{name}.txt", content)
        folder.json("manifest.json", {"files": [f"{name}.txt" for name in texts]})
        folder.finish()


def stopped_by(error: BaseException, out: Path) -> None:
    """A build that writes a file and ends by an error."""
    with open_folder(out) as folder:
        folder.text("a.txt", "new")
        folder.cache.mkdir(exist_ok=True)
        raise error


def names(out: Path) -> set[str]:
    return {p.name for p in out.iterdir()} - {".fabgeo"}


def test_two_builds_at_once_are_refused(tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [sys.executable, "-c", HOLD, str(out)]
    with subprocess.Popen(command, stdin=-1, stdout=-1, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        with pytest.raises(InputError, match="another build is at work"), open_folder(out):
            pass
        other.communicate()
    write(out, a="1")  # the lock is gone with its process
    assert names(out) == {"a.txt", "manifest.json"}


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EDQUOT, errno.EFBIG])
def test_a_full_disk_leaves_the_package_before(tmp_path: Path, code: int) -> None:
    write(tmp_path / "out", a="old")
    with pytest.raises(FabgeoError, match="make room"):
        stopped_by(OSError(code, "full"), tmp_path / "out")
    assert (tmp_path / "out/a.txt").read_text() == "old"
    assert not (tmp_path / "out/.fabgeo/staged").exists()


def test_what_a_disk_cannot_hold_is_not_half_written(tmp_path: Path) -> None:
    """The process may write files of 20 kB only: the kernel refuses as a full disk does."""
    script = f"""
import resource, signal
from fabgeo.build.cache import Cache
from fabgeo.build.folder import open_folder
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
with open_folder({str(tmp_path / "out")!r}) as folder:
    cache = Cache(folder.cache)
    cache.once("fit", (1,), lambda: b"small")
    cache.once("fit", (2,), lambda: bytes(50_000))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert "FabgeoError" in done.stderr
    assert "beyond the limit" in done.stderr
    (entry,) = (tmp_path / "out/.fabgeo/cache/fit").iterdir()
    assert entry.suffix == ""


def test_bad_input_leaves_no_folder_and_an_interrupt_keeps_the_cache(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with pytest.raises(InputError, match="wrong"):
        stopped_by(InputError("x", "is wrong"), out)
    assert not out.exists()
    with pytest.raises(KeyboardInterrupt):
        stopped_by(KeyboardInterrupt(), out)
    assert (out / ".fabgeo/cache").is_dir()
    assert names(out) == set()


def test_files_of_the_package_before_go(tmp_path: Path) -> None:
    write(tmp_path / "out", a="1", b="2")
    (tmp_path / "out/mine.txt").write_text("keep")
    write(tmp_path / "out", b="3")
    assert names(tmp_path / "out") == {"b.txt", "manifest.json", "mine.txt"}


@pytest.mark.parametrize("name", ["/etc/x", "../x", "a/../../x", ".fabgeo/lock", "a\\x"])
def test_names_outside_the_folder_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="inside the output folder"):
        Folder(tmp_path).place(name)


def test_a_manifest_cannot_remove_files_outside(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("keep")
    write(tmp_path / "out", a="1")
    manifest = {"files": ["../mine.txt", str(tmp_path / "mine.txt")]}
    (tmp_path / "out/manifest.json").write_text(json.dumps(manifest))
    write(tmp_path / "out", a="2")
    assert (tmp_path / "mine.txt").exists()


def test_links_in_the_folder_are_not_followed(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "out/cut").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="is a link"):
        write(tmp_path / "out", **{"cut/a": "x"})
    assert not list((tmp_path / "elsewhere").iterdir())


@pytest.mark.parametrize(
    "link",
    [".fabgeo", ".fabgeo/lock", ".fabgeo/staged", ".fabgeo/.files.json.part", "manifest.json"],
)
def test_nothing_is_written_or_removed_through_a_link(tmp_path: Path, link: str) -> None:
    other = tmp_path / "elsewhere"
    (other / "staged").mkdir(parents=True)
    theirs = [other / "staged" / "mine.txt", other / "lock", other / "mine.txt"]
    for file in theirs:
        file.write_text("keep")
    at = tmp_path / "out" / link
    at.parent.mkdir(parents=True)
    at.symlink_to(other if link in (".fabgeo", ".fabgeo/staged") else other / "mine.txt")
    with pytest.raises(InputError, match="is a link"):
        write(tmp_path / "out", a="x")
    assert all(file.read_text() == "keep" for file in theirs)
    assert sorted(p.name for p in other.iterdir()) == ["lock", "mine.txt", "staged"]


@pytest.mark.parametrize(
    "name", ["cut/mine.txt", "folder", "", "a\0b", "x" * 500, "a.txt/b", "\ud800"]
)
def test_a_manifest_removes_files_of_the_folder_alone(tmp_path: Path, name: str) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere/mine.txt").write_text("keep")
    write(tmp_path / "out", a="1")
    (tmp_path / "out/folder").mkdir()
    (tmp_path / "out/cut").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "out/manifest.json").write_text(json.dumps({"files": [name]}))
    write(tmp_path / "out", a="2")
    assert (tmp_path / "elsewhere/mine.txt").read_text() == "keep"
    assert (tmp_path / "out/folder").is_dir()
    assert (tmp_path / "out/a.txt").read_text() == "2"


@pytest.mark.parametrize("place", ["a.txt/mine", "manifest.json/mine", ".fabgeo/files.json/mine"])
def test_a_folder_where_a_file_belongs_is_told_before_anything_moves(
    tmp_path: Path, place: str
) -> None:
    write(tmp_path / "out", b="old")
    theirs = tmp_path / "out" / place
    theirs.parent.unlink(missing_ok=True)
    theirs.parent.mkdir()
    theirs.write_text("keep")
    with pytest.raises(InputError, match="is no file"):
        write(tmp_path / "out", a="new")
    assert theirs.read_text() == "keep"
    assert (tmp_path / "out/b.txt").read_text() == "old"


def test_a_pipe_in_the_folder_holds_nothing_up(tmp_path: Path) -> None:
    (tmp_path / "out/.fabgeo").mkdir(parents=True)
    os.mkfifo(tmp_path / "out/.fabgeo/files.json")
    with pytest.raises(InputError, match="is no file"):
        write(tmp_path / "out", a="1")


@pytest.mark.parametrize("place", ["fit", "fit/entry"])
@pytest.mark.parametrize("strange", ["link", "pipe", "other"])
def test_the_cache_holds_folders_of_files_alone(tmp_path: Path, place: str, strange: str) -> None:
    """Where its entries go that a build has not used, nothing else does."""
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere/mine.txt").write_text("keep")
    at = tmp_path / "out/.fabgeo/cache" / place
    at.parent.mkdir(parents=True)
    if strange == "link":
        at.symlink_to(tmp_path / "elsewhere")
    elif strange == "pipe":
        os.mkfifo(at)
    elif place == "fit":
        at.write_text("a file where a folder belongs")
    else:
        at.mkdir()
    expected = "is no folder" if place == "fit" else "is no file"
    with pytest.raises(InputError, match=expected), open_folder(tmp_path / "out") as folder:
        Cache(folder.cache).prune()
    assert (tmp_path / "elsewhere/mine.txt").read_text() == "keep"


def test_a_file_taken_over_is_not_written_into(tmp_path: Path) -> None:
    """It is a link to the package's own, which an interrupt must leave as it was."""
    out = tmp_path / "out"
    with open_folder(out) as folder:
        folder.again("a.txt", "key")
        folder.text("a.txt", "old")
        folder.json("manifest.json", {"files": {"a.txt": sha256_of(folder.staged / "a.txt")}})
        folder.finish()
    with open_folder(out) as folder:
        assert folder.again("a.txt", "key")
        folder.text("a.txt", "new")  # and no more
    assert (out / "a.txt").read_text() == "old"


@pytest.mark.parametrize("stated", ["abc", "-1", "1.5", "99999999999999"])
def test_a_moment_that_is_none_is_told_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stated: str
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", stated)
    with pytest.raises(InputError, match="SOURCE_DATE_EPOCH"):
        write(tmp_path / "out", a="1")
    assert not (tmp_path / "out").exists()


def test_long_work_is_kept_where_a_build_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def build(out: Path) -> None:
        with open_folder(out) as folder:
            folder.cache.mkdir()
            (folder.cache / "fit").write_text("much work")
            raise InputError("P-00-00", "is larger than every sheet")

    for long, kept in ((1e9, False), (0.0, True)):
        monkeypatch.setattr("fabgeo.build.folder.LONG", long)
        out = tmp_path / f"after {long:g}"
        with pytest.raises(InputError):
            build(out)
        assert out.exists() == kept
        assert not kept or (out / ".fabgeo" / "cache" / "fit").read_text() == "much work"


def test_what_is_known_of_a_file_taken_over_ends_when_it_is_placed_anew(tmp_path: Path) -> None:
    out, known = tmp_path / "out", {}
    for turn in range(2):
        with open_folder(out) as folder:
            for name in ("a.txt", "b.txt"):
                if not folder.again(name, "made of this"):
                    folder.text(name, name)
            known = folder.taken
            if turn:
                folder.text("b.txt", "made of that after all")
                assert folder.taken == {"a.txt": known["a.txt"]}
            sums = {p.name: sha256_of(p) for p in folder.staged.iterdir()}
            assert all(sums[name] == value for name, value in folder.taken.items())
            folder.json("manifest.json", {"files": sums})
            folder.finish()
    assert known == {name: hashlib.sha256(name.encode()).hexdigest() for name in ("a.txt", "b.txt")}
