"""Read fonts: a file, or the name of an installed font."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from nmaptool.core.errors import InputError, reason_of
from nmaptool.core.text import listed
from nmaptool.io.opening import read_head
from nmaptool.options.plates.text import is_font_file
from nmaptool.types.font import Font

_STARTS = (b"\x00\x01\x00\x00", b"OTTO", b"true", b"ttcf")
_WEB = {b"wOFF": "WOFF", b"wOF2": "WOFF2"}
_LARGEST = 256 * 1024 * 1024
_SLANTS = ("normal", "italic", "oblique")
_WEIGHTS = {
    "thin": 100,
    "extralight": 200,
    "ultralight": 200,
    "light": 300,
    "book": 400,
    "regular": 400,
    "medium": 500,
    "demibold": 600,
    "semibold": 600,
    "bold": 700,
    "extrabold": 800,
    "heavy": 800,
    "black": 900,
}
_WIDTHS = ("condensed", "semi-condensed", "extra-condensed", "semi-expanded", "expanded")


def read_font(name: str | Path) -> Font:
    """Read a font file, or an installed font by its name.

    Parameters
    ----------
    name : str or Path
        A TrueType or OpenType file (.ttf, .otf, .ttc, .otc; ``fonts.ttc#1`` is the second font of a collection), or a
        family with optional properties, such as ``DejaVu Serif``, ``DejaVu Serif:bold`` or
        ``DejaVu Sans:bold:oblique``: a weight, italic or oblique, condensed. matplotlib, which lists the installed
        fonts, brings the DejaVu fonts.

    Returns
    -------
    Font

    Raises
    ------
    InputError
        If the file cannot be read or is not such a font, or no installed font has this name and these properties.

    Examples
    --------
    >>> nm.read_font("DejaVu Serif:bold").name
    'DejaVu Serif:bold (DejaVuSerif-Bold.ttf)'
    """
    text = str(name)
    plain, number = re.fullmatch(r"(.*?)(?:#(\d+))?", text, re.DOTALL).groups()  # type: ignore[union-attr]
    if isinstance(name, Path) or is_font_file(text) or "/" in text:
        path, face = (Path(text), 0) if number is None or Path(text).exists() else (Path(plain), int(number))
        return _from_file(path, text, face)
    entry = _installed(text)
    path = Path(entry.fname)
    return _from_file(path, f"{text} ({path.name})", getattr(entry, "index", 0))


def _from_file(path: Path, name: str, face: int) -> Font:
    """Read and check a font file."""
    head, size = read_head(path, 4, "a font file (.ttf, .otf, .ttc)", "write it to a file first")
    if head in _WEB:
        raise InputError(f"{path}: is a web font ({_WEB[head]}); give the TrueType or OpenType file (.ttf, .otf)")
    if head not in _STARTS:
        raise InputError(f"{path}: is not a TrueType or OpenType font (it begins with {head!r}); give a .ttf or .otf")
    if size > _LARGEST:
        raise InputError(f"{path}: has {size} bytes, more than {_LARGEST} bytes; give a smaller font")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({reason_of(error)})") from None
    _check(path, data, face)
    return Font(data, name, face)


def _check(path: Path, data: bytes, face: int) -> None:
    """Refuse fonts without glyphs, outlines or a table of characters."""
    import uharfbuzz

    count = uharfbuzz.Face(data).count if data[:4] == b"ttcf" else 1
    if face >= count:
        raise InputError(f"{path}#{face}: has {count} {'font' if count == 1 else 'fonts'}, numbered from 0")
    opened = uharfbuzz.Face(data, face)
    has_map, *outlines = (len(opened.reference_table(tag).data) > 0 for tag in ("cmap", "glyf", "CFF ", "CFF2"))
    if not opened.glyph_count or not has_map:
        raise InputError(f"{path}: is damaged (no table of characters or no glyphs); export or download it again")
    if not any(outlines):
        raise InputError(f"{path}: holds pictures of glyphs, not outlines; give a font with outlines")


def _installed(text: str) -> Any:
    """The entry of matplotlib's list for a name with properties; no other font takes its place."""
    from matplotlib import font_manager

    family, *properties = (part.strip() for part in text.split(":"))
    weight, slant, width = _properties(text, properties)
    entries = font_manager.fontManager.ttflist
    found = [entry for entry in entries if entry.name.casefold() == family.casefold()]
    if not found:
        raise InputError(f"font {family!r}: is not installed; {_near(family, {entry.name for entry in entries})}")
    fitting = [
        entry
        for entry in found
        if (weight is None or _weight(entry) == weight)
        and (slant is None or (entry.style == slant))
        and (width is None or entry.stretch == width)
    ]
    if not fitting:
        have = sorted({_described(entry) for entry in found})
        raise InputError(f"font {text!r}: is not installed; installed are {listed(have, 'and')}")
    return min(fitting, key=_distance_from_regular)


def _properties(text: str, properties: Iterable[str]) -> tuple[int | None, str | None, str | None]:
    """Weight, slant and width that a name asks for."""
    weight, slant, width = None, None, None
    for word in (part.lower() for part in properties):
        if word in _WEIGHTS:
            weight = _WEIGHTS[word]
        elif word in _SLANTS:
            slant = word
        elif word in _WIDTHS:
            width = word
        else:
            raise InputError(
                f"font {text!r}: {word!r} is not a property; use {listed((*_WEIGHTS, *_SLANTS[1:], *_WIDTHS))}"
            )
    return weight, slant, width


def _weight(entry: Any) -> int:
    return entry.weight if isinstance(entry.weight, int) else _WEIGHTS.get(entry.weight, 400)


def _distance_from_regular(entry: Any) -> tuple[int, bool, bool]:
    return abs(_weight(entry) - 400), entry.style != "normal", entry.stretch != "normal"


def _described(entry: Any) -> str:
    """A name that `read_font` takes, such as "DejaVu Sans:bold:oblique"."""
    weight = next((word for word, value in _WEIGHTS.items() if value == _weight(entry) != 400), None)
    words = (weight, entry.style, entry.stretch)
    return ":".join([entry.name, *(word for word in words if word and word != "normal")])


def _near(family: str, names: Iterable[str]) -> str:
    """Advice that lists names which resemble one, or else says how to find them."""
    by_key = {name.casefold(): name for name in sorted(names)}
    near = difflib.get_close_matches(family.casefold(), by_key, n=3, cutoff=0.5)
    if near:
        return f"installed are {listed([by_key[key] for key in near], 'and')}, or give a font file (.ttf, .otf)"
    return "give a font file (.ttf, .otf), or a name such as 'DejaVu Serif:bold'"
