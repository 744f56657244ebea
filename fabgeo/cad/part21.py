r"""The text of a STEP file (ISO 10303-21) as entities; no geometry, no kernel.

Glossary
--------
entity instance
    ``#12 = CARTESIAN_POINT('',(0.,0.,0.));`` or, complex, ``#12 = ( A(...) B(...) );``.
reference
    ``#12`` within another instance: a `Ref`.
encoded letters
    ``\X2\00FC\X0\`` (four hexadecimal digits a letter), ``\X4\`` (eight), ``\X\FC`` and ``\S\|``
    (ISO 8859-1); plain UTF-8 in newer files.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fabgeo.errors import InputError

_INSTANCE = re.compile(r"#(\d+)\s*=\s*((?:'(?:[^']|'')*'|[^';])*);")
_COMMENT = re.compile(r"('(?:[^']|'')*')|/\*.*?\*/", re.DOTALL)
_TOKEN = re.compile(
    r"\s*(?:('(?:[^']|'')*')|#(\d+)|([-+]?\d+\.?\d*(?:[eE][-+]?\d+)?)|\.([A-Za-z0-9_]+)\."
    r"|([A-Za-z_!][A-Za-z0-9_]*)|(\"[0-9A-Fa-f]*\")|([(),$*]))"
)


class Ref(int):
    """A reference to another instance: its number."""


class Enum(str):
    """An enumeration value such as ``.T.``, without its dots."""

    __slots__ = ()


class Entities:
    """All instances of a file; arguments are parsed when asked for.

    Parameters
    ----------
    text : str
        The whole file.

    Raises
    ------
    InputError
        If the text has no DATA section.
    """

    def __init__(self, text: str, where: str = "STEP text") -> None:
        self.where = where
        start = text.find("DATA;")
        if not text.lstrip().startswith("ISO-10303-21") or start < 0:
            raise InputError(where, "is no STEP file: expected ISO-10303-21 and a DATA section")
        self.header = text[:start]
        body = text[start + 5 :]
        if "/*" in body:
            body = _COMMENT.sub(lambda m: m.group(1) or "", body)
        self._raw: dict[int, str] = {int(m[1]): m[2] for m in _INSTANCE.finditer(body)}
        self._parsed: dict[int, dict[str, list[Any]]] = {}
        self._of_kind: dict[str, list[int]] = {}
        for number, raw in self._raw.items():
            kind = raw[: raw.find("(")].strip()
            for name in (kind,) if kind else _kinds_of_complex(raw):
                self._of_kind.setdefault(name, []).append(number)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Entities:
        """The entities of a file."""
        source = Path(path)
        if not source.is_file():
            raise InputError(str(source), "does not exist")
        return cls(source.read_text(encoding="utf-8", errors="replace"), str(source))

    def __len__(self) -> int:
        return len(self._raw)

    def of_kind(self, kind: str) -> list[int]:
        """Numbers of all instances of a kind, complex ones that have it as a part too."""
        return self._of_kind.get(kind, [])

    def parts(self, number: int) -> dict[str, list[Any]]:
        """The kinds of an instance with their arguments (one kind, if it is not complex)."""
        if number not in self._parsed:
            if number not in self._raw:
                raise InputError(f"{self.where}, #{number}", "is referred to but not defined")
            try:
                self._parsed[number] = _parse(self._raw[number])
            except (IndexError, ValueError) as error:
                raise InputError(f"{self.where}, #{number}", f"can't be parsed: {error}") from error
        return self._parsed[number]

    def kind(self, number: int) -> str:
        """The kind of a plain instance, the kinds joined by ``+`` of a complex one."""
        return "+".join(self.parts(number))

    def arguments(self, number: int, kind: str = "") -> list[Any]:
        """Arguments of an instance (of one part of a complex one)."""
        parts = self.parts(number)
        if kind:
            return parts[kind]
        return next(iter(parts.values()))


def _kinds_of_complex(raw: str) -> Iterator[str]:
    depth, name = 0, ""
    for match in _TOKEN.finditer(raw):
        if match[5]:
            name = match[5]
        elif match[7] == "(":
            depth += 1
            if depth == 2 and name:
                yield name
            name = ""
        elif match[7] == ")":
            depth -= 1


def _parse(raw: str) -> dict[str, list[Any]]:
    tokens = [(m.lastindex or 0, m[m.lastindex or 0]) for m in _TOKEN.finditer(raw)]
    if tokens[0][0] == 5:
        arguments, _ = _list(tokens, 2)
        return {tokens[0][1]: arguments}
    parts: dict[str, list[Any]] = {}
    at = 1
    while tokens[at] != (7, ")"):
        name = tokens[at][1]
        parts[name], at = _list(tokens, at + 2)
    return parts


def _list(tokens: list[tuple[int, str]], at: int) -> tuple[list[Any], int]:
    """Values up to the closing bracket, and where to go on."""
    out: list[Any] = []
    while True:
        group, value = tokens[at]
        at += 1
        if group == 7:
            if value == ")":
                return out, at
            if value == "(":
                inner, at = _list(tokens, at)
                out.append(inner)
            elif value in "$*":
                out.append(None)
        elif group == 2:
            out.append(Ref(value))
        elif group == 3:
            out.append(float(value) if any(c in value for c in ".eE") else int(value))
        elif group == 1:
            out.append(decode(value[1:-1]))
        elif group == 4:
            out.append(Enum(value))
        elif group == 5:  # a typed value, NAME(value)
            inner, at = _list(tokens, at + 1)
            out.append(inner[0] if len(inner) == 1 else inner)
        else:
            out.append(value)


_ENCODED = re.compile(
    r"\\X2\\([0-9A-Fa-f]+)\\X0\\|\\X4\\([0-9A-Fa-f]+)\\X0\\|\\X\\([0-9A-Fa-f]{2})|\\S\\(.)|(\\\\)|('')"
)


def decode(value: str) -> str:
    """The text that a STEP string stands for."""

    def letters(match: re.Match[str]) -> str:
        two, four, one, shifted, slash, _ = match.groups()
        if two:
            return bytes.fromhex(two).decode("utf-16-be")
        if four:
            return bytes.fromhex(four).decode("utf-32-be")
        if one:
            return chr(int(one, 16))
        if shifted:
            return chr(ord(shifted) + 128)
        return "\\" if slash else "'"

    return _ENCODED.sub(letters, value) if "\\" in value or "''" in value else value
