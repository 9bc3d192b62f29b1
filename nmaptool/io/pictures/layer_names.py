"""Names of the layers of a file: which one a request means, and which is the obvious normal map or depth picture."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Literal

# what a reader is about to do with a picture, which decides between the layers of a file
Holds = Literal["normals", "depth"]

_NORMAL_WORDS = ("original", "n", "normal", "normals", "nrm", "norm", "normalmap", "normal_map", "pred_normal")
_DEPTH_WORDS = (
    ("depth", "zdepth", "depthz", "depth_map", "depthmap", "pred_depth", "depth_pred"),
    ("z",),
    ("disparity", "disp", "inverse_depth"),
    ("height", "heights", "heightmap", "displacement", "elevation", "dem"),
)
# rank of a name that says nothing of what is sought
UNFIT = 99
_WORDS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+|\d+")


def rank(name: str, holds: Holds) -> int:
    """How well a name suits what is sought: 0 is best, a large number means not at all.

    >>> [rank(name, "normals") for name in ("Normal", "ViewLayer.Denoising Normal", "Combined")]
    [2, 10, 99]
    """
    last = name.rpartition(".")[2].lower()
    words = [word.lower() for word in _WORDS.findall(name.rpartition(".")[2])]
    if holds == "normals":
        if last in _NORMAL_WORDS:  # "original" before all others, which are equals
            return 0 if last == "original" else 1 if last == "n" else 2
        return 10 if {"normal", "normals"} & set(words) else UNFIT
    for place, group in enumerate(_DEPTH_WORDS):
        if last in group:
            return place
    return 10 if {"depth", "disparity"} & set(words) else UNFIT


def obvious(names: Sequence[str], holds: Holds) -> int | None:
    """The place of the only name that suits best, or None."""
    ranks = [rank(name, holds) for name in names]
    best = min(ranks, default=UNFIT)
    return ranks.index(best) if best < UNFIT and ranks.count(best) == 1 else None


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
