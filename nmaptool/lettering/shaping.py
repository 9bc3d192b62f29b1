"""Shape one line of text with HarfBuzz: glyphs with kerning and ligatures, in the order in which they stand."""

from __future__ import annotations

import dataclasses
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, LimitError, UsageError
from nmaptool.core.text import listed
from nmaptool.lettering.bidi import embedding_levels, visual_order
from nmaptool.lettering.face import Face, open_face, script_of
from nmaptool.types.font import Font
from nmaptool.types.shown import OneLine, counted

# the default tolerance is the smaller of a length and a part of the size
_TOLERANCE_MM, _TOLERANCE_PART = 0.002, 1 / 4000
_LONGEST = 2000
# scripts whose letters join: no space is put between them, and they bend with a curve instead of turning one by one
_JOINED = {
    "Adlm",
    "Arab",
    "Beng",
    "Deva",
    "Gong",
    "Guru",
    "Mand",
    "Mani",
    "Modi",
    "Mong",
    "Nkoo",
    "Phag",
    "Rohg",
    "Syrc",
}


@dataclass(frozen=True, eq=False, repr=False)
class Cluster(OneLine):
    """One or more characters whose glyphs belong together, such as a letter with its accents or a ligature.

    Parameters
    ----------
    text : str
    rings : tuple of (n, 2) float64
        Outlines in mm from the left end of the cluster on the baseline; they may cross each other.
    advance_mm : float
        Distance to the next cluster, kerning included.
    is_joined : bool
        Whether its script joins letters.
    """

    text: str
    rings: tuple[Float64, ...]
    advance_mm: float
    is_joined: bool = False

    @property
    def is_space(self) -> bool:
        """Whether it separates words."""
        return self.text.isspace()


@dataclass(frozen=True, eq=False, repr=False)
class TextLine(OneLine):
    """One shaped line: its clusters from left to right.

    Parameters
    ----------
    clusters : tuple of Cluster
    size_mm : float
        Height of the capitals.
    gap_mm : float
        Space put between clusters beside the font's own; none within words of a script that joins letters.
    word_space_mm : float
        Advance of a space.
    line_height_mm : float
        Distance of baselines that the font asks for.
    tolerance_mm : float
        The greatest distance between the outlines and the true curves.
    """

    clusters: tuple[Cluster, ...]
    size_mm: float
    gap_mm: float
    word_space_mm: float
    line_height_mm: float
    tolerance_mm: float

    @property
    def text(self) -> str:
        """The clusters as text, in the order in which they stand."""
        return "".join(cluster.text for cluster in self.clusters)

    @property
    def stretchable(self) -> tuple[bool, ...]:
        """Whether space may be put between each cluster and the next."""
        return tuple(not (a.is_joined and b.is_joined) or a.is_space or b.is_space for a, b in pairwise(self.clusters))

    @property
    def starts_mm(self) -> Float64:
        """(n + 1,) float64: left ends of the clusters, and the right end of the last."""
        gaps = [self.gap_mm * allowed for allowed in self.stretchable] + [0.0]
        steps = [cluster.advance_mm + gap for cluster, gap in zip(self.clusters, gaps, strict=True)]
        return np.concatenate([[0.0], np.cumsum(steps)])

    @property
    def advance_mm(self) -> float:
        """Length of the line."""
        return float(self.starts_mm[-1])

    @property
    def ink_mm(self) -> tuple[float, float]:
        """Left and right end of the outlines, in mm from the start of the line."""
        extents = [
            (start + ring[:, 0].min(), start + ring[:, 0].max())
            for start, cluster in zip(self.starts_mm, self.clusters, strict=False)
            for ring in cluster.rings
        ]
        return float(min(low for low, _ in extents)), float(max(high for _, high in extents))

    def stretched(self, gap_mm: float) -> TextLine:
        """The line with another space between its clusters."""
        return dataclasses.replace(self, gap_mm=gap_mm)

    def _line(self) -> str:
        return f"{self.text!r}: {counted(len(self.clusters), 'cluster')}, {self.advance_mm:.6g} x {self.size_mm:g} mm"


def lay_out(
    font: Font, text: str, size_mm: float, spacing: float = 1.0, *, tolerance_mm: float | None = None
) -> TextLine:
    """Shape one line of text.

    Parameters
    ----------
    font : Font
    text : str
        Without line breaks; white space at its ends is ignored. Parts in different writing directions are reordered.
    size_mm : float
        Height of the capitals, as the font states it or as its H has it.
    spacing : float
        Length of the line as a factor of the font's own; the difference is shared evenly by the gaps between letters.
        If it is not 1, f and i are not joined to ligatures.
    tolerance_mm : float, optional
        The greatest distance between the outlines and the font's curves. Default: 0.002 mm, at most 1/4000 of the size.

    Returns
    -------
    TextLine

    Raises
    ------
    InputError
        If the text is empty or holds a line break, the font lacks a character, or draws nothing.
    LimitError
        If the text has more than 2000 characters.
    UsageError
        If a size, the spacing or the tolerance is not a positive number.
    """
    if tolerance_mm is None:
        tolerance_mm = min(_TOLERANCE_MM, size_mm * _TOLERANCE_PART)
    for name, value in (("size_mm", size_mm), ("spacing", spacing), ("tolerance_mm", tolerance_mm)):
        if not (np.isfinite(value) and value > 0):
            raise UsageError(f"`{name}={value!r}`: must be a number greater than zero")
    text = _checked(text)
    face = open_face(font)
    scale = size_mm / face.cap_height
    clusters = _clusters(face, text, scale, tolerance_mm, ligatures=spacing == 1.0)
    if not any(cluster.rings for cluster in clusters):
        raise InputError(f"the font {font.name} draws nothing for the text {text!r}; use another `font`")
    space = face.hb_font.get_nominal_glyph(ord(" "))
    word_space = face.hb_font.get_glyph_h_advance(space) * scale if space else size_mm / 3
    line = TextLine(tuple(clusters), size_mm, 0.0, word_space, face.line_height * scale, tolerance_mm)
    gaps = sum(line.stretchable)
    return line.stretched((spacing - 1) * line.advance_mm / gaps) if gaps else line


def lay_out_lines(
    font: Font, text: str, size_mm: float, spacing: float = 1.0, *, tolerance_mm: float | None = None
) -> tuple[TextLine | None, ...]:
    """Shape the lines of a text, as `lay_out` does; None stands for an empty line between others."""
    lines = text.strip().splitlines() or [text]
    return tuple(
        lay_out(font, line, size_mm, spacing, tolerance_mm=tolerance_mm) if line.strip() or len(lines) == 1 else None
        for line in lines
    )


def _checked(text: str) -> str:
    """A text in one line, with plain spaces."""
    if len(text) > _LONGEST:
        raise LimitError(f"the text has {len(text)} characters, more than {_LONGEST}; use a shorter text")
    text = text.strip()
    if not text:
        raise InputError("the text is empty; give at least one letter")
    if len(text.splitlines()) > 1:
        raise InputError(f"the text {text!r} has a line break; only a straight text has several lines")
    return "".join(" " if unicodedata.category(letter) in ("Cc", "Zs") else letter for letter in text)


def _clusters(face: Face, text: str, scale: float, tolerance_mm: float, ligatures: bool) -> list[Cluster]:
    """Clusters from left to right."""
    levels = embedding_levels(text)
    scripts = _scripts(text)
    runs = list(_runs(levels, scripts))
    clusters: list[Cluster] = []
    missing: set[str] = set()
    for at in visual_order([levels[first] for first, _ in runs]):
        first, last = runs[at]
        run = (first, last, levels[first] % 2 == 1, scripts[first])
        clusters += _shape_run(face, text, run, scale, tolerance_mm, ligatures, missing)
    if missing:
        lacks = listed([f"{letter!r} (U+{ord(letter):04X})" for letter in sorted(missing)], "and")
        raise InputError(f"the font {face.name} lacks {lacks}; use another `font`")
    return clusters


def _scripts(text: str) -> list[str | None]:
    """The script of each character; those that several scripts share take the script before them, else after them."""
    found = [script_of(letter) for letter in text]
    first = next((script for script in found if script), None)
    current = first
    for i, script in enumerate(found):
        current = script or current
        found[i] = current
    return found


def _runs(levels: list[int], scripts: list[str | None]) -> Iterator[tuple[int, int]]:
    """Begin and end of the stretches of one level and one script."""
    first = 0
    for i in range(1, len(levels) + 1):
        if i == len(levels) or (levels[i], scripts[i]) != (levels[first], scripts[first]):
            yield first, i
            first = i


def _shape_run(
    face: Face,
    text: str,
    run: tuple[int, int, bool, str | None],
    scale: float,
    tolerance_mm: float,
    ligatures: bool,
    missing: set[str],
) -> list[Cluster]:
    """Clusters of a run from left to right; characters that the font lacks are added to ``missing``."""
    import uharfbuzz

    first, last, runs_left, script = run
    buffer = uharfbuzz.Buffer()
    buffer.add_codepoints([ord(letter) for letter in text], first, last - first)
    buffer.direction = "rtl" if runs_left else "ltr"
    if script is not None:
        buffer.script = script
    buffer.guess_segment_properties()
    uharfbuzz.shape(face.hb_font, buffer, {} if ligatures else {"liga": False, "clig": False})
    infos, positions = buffer.glyph_infos, buffer.glyph_positions
    begins = sorted({info.cluster for info in infos})
    ends = dict(zip(begins, [*begins[1:], last], strict=True))
    made: list[Cluster] = []
    at = 0
    while at < len(infos):
        begin, x, rings = infos[at].cluster, 0.0, list[Float64]()
        letters = text[begin : ends[begin]]
        while at < len(infos) and infos[at].cluster == begin:
            glyph, place = infos[at].codepoint, positions[at]
            if glyph == 0:
                missing.update(letter for letter in letters if not face.hb_font.get_nominal_glyph(ord(letter)))
            shift = np.array([x + place.x_offset, place.y_offset]) * scale
            rings += [ring + shift for ring in face.rings(glyph, scale, tolerance_mm)]
            x += place.x_advance
            at += 1
        made.append(Cluster(letters, tuple(rings), x * scale, script in _JOINED))
    return made
