"""Order of text in two directions: the implicit levels of Unicode's bidirectional algorithm (UAX #9).

Rules P2 and P3, W1 to W7, N0 to N2, I1, I2, L1 and L2. Characters that embed, override or isolate are ignored: a line
of lettering is one paragraph without them.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable

_BRACKETS = {"(": ")", "[": "]", "{": "}", "⟨": "⟩", "〈": "〉", "「": "」", "『": "』", "【": "】", "〔": "〕"}
_IGNORED = {"BN", "LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"}
_NEUTRAL = {"B", "S", "WS", "ON"}
_STRONG = {"L": "L", "R": "R", "EN": "R", "AN": "R"}  # numbers count as right-to-left for their neighbours (N0, N1)


def embedding_levels(text: str) -> list[int]:
    """The level of each character; odd levels run from right to left.

    >>> embedding_levels("ab 12"), embedding_levels("אב 12")
    ([0, 0, 0, 0, 0], [1, 1, 1, 2, 2])
    """
    classes = [unicodedata.bidirectional(letter) or "L" for letter in text]
    first = next((kind for kind in classes if kind in ("L", "R", "AL")), "L")
    base = 0 if first == "L" else 1
    kept = [i for i, kind in enumerate(classes) if kind not in _IGNORED]
    resolved = [classes[i] for i in kept]
    outside = "R" if base else "L"
    _resolve_marks_and_numbers(resolved, outside)
    _resolve_brackets([text[i] for i in kept], [classes[i] for i in kept], resolved, outside)
    _resolve_neutrals(resolved, outside)
    levels = [base] * len(text)
    for i, kind in zip(kept, resolved, strict=True):
        if base % 2 == 0:  # I1
            levels[i] = base + {"L": 0, "R": 1}.get(kind, 2)
        else:  # I2
            levels[i] = base + (kind != "R")
    _level_of_ignored(levels, classes, base)
    return levels


def _level_of_ignored(levels: list[int], classes: list[str], base: int) -> None:
    """Ignored characters take the level before them; white space at the end takes the base level (L1)."""
    for i, kind in enumerate(classes):
        if kind in _IGNORED:
            levels[i] = levels[i - 1] if i else base
    for i in reversed(range(len(levels))):
        if classes[i] not in ("WS", "B", "S") and classes[i] not in _IGNORED:
            break
        levels[i] = base
    for i, kind in enumerate(classes):
        if kind in ("B", "S"):
            levels[i] = base


def _resolve_marks_and_numbers(kinds: list[str], outside: str) -> None:
    """W1 to W7."""
    for i, kind in enumerate(kinds):  # W1
        if kind == "NSM":
            kinds[i] = kinds[i - 1] if i else outside
    strong = outside
    for i, kind in enumerate(kinds):  # W2
        if kind in ("L", "R", "AL"):
            strong = kind
        elif kind == "EN" and strong == "AL":
            kinds[i] = "AN"
    kinds[:] = ["R" if kind == "AL" else kind for kind in kinds]  # W3
    for i in range(1, len(kinds) - 1):  # W4
        before, after = kinds[i - 1], kinds[i + 1]
        if before == after and (kinds[i], before) in (("ES", "EN"), ("CS", "EN"), ("CS", "AN")):
            kinds[i] = before
    for first, last in list(_runs(kinds, {"ET"})):  # W5
        if (first > 0 and kinds[first - 1] == "EN") or (last < len(kinds) and kinds[last] == "EN"):
            kinds[first:last] = ["EN"] * (last - first)
    kinds[:] = ["ON" if kind in ("ES", "ET", "CS") else kind for kind in kinds]  # W6
    strong = outside
    for i, kind in enumerate(kinds):  # W7
        if kind in ("L", "R"):
            strong = kind
        elif kind == "EN" and strong == "L":
            kinds[i] = "L"


def _resolve_brackets(letters: list[str], classes: list[str], kinds: list[str], outside: str) -> None:
    """N0: a pair of brackets takes the direction of what it encloses, or of what stands before it."""
    for first, last in _bracket_pairs(letters, kinds):
        inside = {_STRONG[kind] for kind in kinds[first + 1 : last] if kind in _STRONG}
        if not inside:
            continue
        before = next((_STRONG[kind] for kind in reversed(kinds[:first]) if kind in _STRONG), outside)
        direction = outside if outside in inside or before == outside else before
        for at in (first, last):
            kinds[at] = direction
            after = at + 1
            while after < len(kinds) and classes[after] == "NSM":
                kinds[after] = direction
                after += 1


def _bracket_pairs(letters: list[str], kinds: list[str]) -> list[tuple[int, int]]:
    """Positions of matching brackets, in the order of the opening ones (BD16)."""
    pairs: list[tuple[int, int]] = []
    opened: list[tuple[str, int]] = []
    for i, letter in enumerate(letters):
        if kinds[i] != "ON":
            continue
        if letter in _BRACKETS:
            opened.append((_BRACKETS[letter], i))
        elif any(closing == letter for closing, _ in opened):
            while opened[-1][0] != letter:
                opened.pop()
            pairs.append((opened.pop()[1], i))
    return sorted(pairs)


def _resolve_neutrals(kinds: list[str], outside: str) -> None:
    """N1 and N2."""
    for first, last in list(_runs(kinds, _NEUTRAL)):
        before = _STRONG[kinds[first - 1]] if first > 0 else outside
        after = _STRONG[kinds[last]] if last < len(kinds) else outside
        kinds[first:last] = [before if before == after else outside] * (last - first)


def _runs(kinds: list[str], wanted: set[str]) -> Iterable[tuple[int, int]]:
    """Begin and end of the stretches of some classes."""
    first = None
    for i, kind in enumerate([*kinds, ""]):
        if kind in wanted and first is None:
            first = i
        elif kind not in wanted and first is not None:
            yield first, i
            first = None


def visual_order(levels: list[int]) -> list[int]:
    """Indices of runs with these levels from left to right (L2).

    >>> visual_order([0, 1, 2, 1, 0])
    [0, 3, 2, 1, 4]
    """
    order = list(range(len(levels)))
    for level in range(max(levels, default=0), 0, -1):
        first = None
        for at in range(len(order) + 1):
            inside = at < len(order) and levels[order[at]] >= level
            if inside and first is None:
                first = at
            elif not inside and first is not None:
                order[first:at] = order[first:at][::-1]
                first = None
    return order
