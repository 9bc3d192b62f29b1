"""Names of the layers of a file: which one a request means, and which is the obvious map, depth picture or mask."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Literal

# what a reader is about to do with a picture, which decides between the layers of a file
Holds = Literal["normals", "depth", "grey"]

_NORMAL_WORDS = ("original", "n", "normal", "normals", "nrm", "norm", "normalmap", "normal_map", "pred_normal", "nn")
_DEPTH_WORDS = (
    ("depth", "zdepth", "depthz", "depth_map", "depthmap", "pred_depth", "depth_pred"),
    ("z", "pz"),
    ("disparity", "disp", "inverse_depth"),
    ("height", "heights", "heightmap", "displacement", "elevation", "dem"),
)
_MASK_WORDS = ("mask", "matte", "coverage", "alpha", "opacity")
_MOST_NAMED = 5  # layers in a note
# rank of a name that says nothing of what is sought
UNFIT = 99
# capitals before a word are a word of their own: V, Ray, Z, Depth
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")


def rank(name: str, holds: Holds) -> int:
    """How well a name suits what is sought: 0 is best, a large number means not at all.

    >>> [rank(name, "normals") for name in ("Normal", "ViewLayer.Denoising Normal", "VRayNormals", "Combined")]
    [2, 10, 10, 99]
    """
    last = name.rpartition(".")[2].lower()
    words = [word.lower() for word in _WORDS.findall(name.rpartition(".")[2])]
    if holds == "normals":
        if last in _NORMAL_WORDS:  # "original" before all others, which are equals
            return 0 if last == "original" else 1 if last == "n" else 2
        return 10 if {"normal", "normals"} & set(words) else UNFIT
    if holds == "grey":
        return 0 if last in _MASK_WORDS else 10 if "mask" in words else UNFIT
    for place, group in enumerate(_DEPTH_WORDS):
        if last in group:
            return place
    return 10 if {"depth", "disparity"} & set(words) else UNFIT


def best_places(names: Sequence[str], holds: Holds) -> list[int]:
    """The places of the names that suit best; none if no name suits.

    >>> best_places(["Combined", "left.N", "right.N"], "normals")
    [1, 2]
    """
    ranks = [rank(name, holds) for name in names]
    best = min(ranks, default=UNFIT)
    return [place for place, one in enumerate(ranks) if one == best] if best < UNFIT else []


def matching(wanted: str, aliases: Sequence[Sequence[str]]) -> list[int]:
    """The places of the layers that a request names: by their whole name, else by the last parts of it.

    Parameters
    ----------
    wanted : str
        Upper and lower case are equal.
    aliases : sequence of sequences of str
        All names of each layer.

    >>> matching("depth", [["ViewLayer.Combined"], ["ViewLayer.Depth", "ViewLayer.Depth.Z"]])
    [1]
    """
    lower = wanted.lower()

    def whole(name: str) -> bool:
        return name.lower() == lower

    def suffix(name: str) -> bool:
        return name.lower().endswith(f".{lower}")

    tests: tuple[Callable[[str], bool], ...] = (whole, suffix)
    for fits in tests:
        found = [place for place, names in enumerate(aliases) if any(fits(name) for name in names)]
        if found:
            return found
    return []


def page_name(number: int) -> str:
    """The name under which a page is found besides its own."""
    return f"page {number + 1}"


def pages_note(file: str, pages: int, names: Sequence[str]) -> tuple[str, ...]:
    """The note that a document has more pages than the one that is read."""
    if pages < 2:
        return ()
    return (f"holds {pages} pages, of which the first is read; another is {file}:{names[-1]}",)


def others_note(read: str, names: Sequence[str]) -> str:
    """The note on the layers beside the one that was read."""
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return f"is read from {read}; it also holds the layers {', '.join(names[:_MOST_NAMED])}{more}"
