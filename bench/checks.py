"""The lines on which benchmarks state a figure with its goal: written by `line`, read back by `checks_in`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass

_NUMBER = r"[-+\d.e]+"
_LINE = re.compile(
    rf"^check: (?P<what>.+?): (?:not measured|(?P<found>{_NUMBER}(?: [^,;:]*)?)(?:, at most (?P<most>{_NUMBER}): "
    rf"(?P<verdict>ok|MISSED))?(?:; (?P<rival>[^;]+) (?P<its>{_NUMBER}), x (?P<ratio>{_NUMBER}))?"
    rf"(?:; peak (?P<peak>{_NUMBER}) GB)?)$",
    re.MULTILINE,
)
HEADER = ("row", "found", "at most", "", "rival", "its figure", "x", "peak GB")
MEANING = (
    "`x` is the figure over that of the rival, measured in the same run: below 1 is less time than the rival takes."
)


@dataclass(frozen=True)
class Check:
    """One line as text; what it does not state is empty."""

    what: str
    found: str
    most: str
    verdict: str
    rival: str
    its: str
    ratio: str
    peak: str

    @property
    def cells(self) -> list[str]:
        """A row of a table under `HEADER`."""
        return [*astuple(self)]


def line(
    what: str,
    found: float | None,
    most: float | None,
    unit: str,
    *,
    rival: tuple[str, float | None] | None = None,
    peak: float | None = None,
) -> str:
    """One figure and its upper limit.

    Parameters
    ----------
    what : str
    found, most : float or None
        The figure, None if it was not measured; its upper limit, None if it has no goal.
    unit : str
    rival : tuple of str and float, optional
        Name of what does the same, and its figure in the same unit, None if it is not there.
    peak : float, optional
        Peak memory in bytes.
    """
    if found is None:
        return f"check: {what}: not measured"
    parts = [f"check: {what}: {found:.3g} {unit}".rstrip()]
    if most is not None:
        parts[0] += f", at most {most:g}: {'ok' if found <= most else 'MISSED'}"
    if rival is not None and rival[1]:
        ratio = found / rival[1]
        times = f"{ratio:.0f}" if ratio > 99 else f"{ratio:.2g}"
        parts.append(f"{rival[0]} {rival[1]:.3g}, x {times}")
    if peak is not None:
        parts.append(f"peak {peak / 1e9:.2f} GB")
    return "; ".join(parts)


def checks_in(text: str) -> list[Check]:
    """Every check line of a text, in its order."""
    found = []
    for each in _LINE.finditer(text):
        stated = {name: value or "" for name, value in each.groupdict().items()}
        found.append(Check(**{**stated, "found": stated["found"] or "not measured"}))
    return found


def rows_of(checks: Iterable[Check]) -> list[Sequence[str]]:
    """Rows under `HEADER`."""
    return [check.cells for check in checks]
