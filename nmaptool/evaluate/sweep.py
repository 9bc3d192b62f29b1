"""Curves of vertex deviation over normal deviation, and verdicts on the paper's claim."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping

from nmaptool.evaluate.verdict import FrontPoint, compare_fronts
from nmaptool.options import ReconstructOptions
from nmaptool.types.comparison import Contender, CurvePoint, Verdict

POISSON_ONCE, POISSON_AGAIN = "poisson, one solve", "poisson, 20 solves"
_GRADIENTS, _SHAPES, _PAPER = "gsfg-gradient, 20 steps", "gsfg-shape, 20 steps", "gsfg, 1 to 80 steps"
CURVES = (_GRADIENTS, _SHAPES, _PAPER, POISSON_ONCE, POISSON_AGAIN)

_CLOSENESS = (2.0, 0.5, 0.1, 0.02, 4e-3, 5e-4)
_FINER = (4.0, 1.5, 0.5, 0.15, 0.05, 0.015, 5e-3, 1e-3, 2e-4)
_COARSER = (1.0, 0.1, 0.01, 1e-3)
_STEPS = (1, 3, 8, 20, 40, 80)
_AGAIN = 20


def sweep(
    name: str,
    point: Callable[[ReconstructOptions], CurvePoint],
    options: ReconstructOptions,
    notify: Callable[[float], None],
) -> tuple[CurvePoint, ...]:
    """Return the points of a curve; the boundary is treated according to the options."""
    runs: list[dict[str, object]]
    if name == _GRADIENTS:
        runs = [{"scheme": "gsfg-gradient", "steps": _AGAIN, "closeness": c} for c in _FINER]
    elif name == _SHAPES:
        runs = [{"scheme": "gsfg-shape", "steps": _AGAIN, "closeness": c} for c in _CLOSENESS]
    elif name == _PAPER:
        runs = [{"scheme": "gsfg", "steps": steps} for steps in _STEPS]
    elif name == POISSON_ONCE:
        runs = [{"scheme": "poisson", "steps": 1, "closeness": c} for c in _CLOSENESS]
    else:
        runs = [{"scheme": "poisson", "steps": _AGAIN, "closeness": c} for c in _COARSER]
    found = []
    for number, changes in enumerate(runs):
        notify(number / len(runs))
        found.append(point(dataclasses.replace(options, **changes)))  # type: ignore[arg-type]
    return tuple(found)


def as_shown(ours: Contender, rival: Contender) -> Verdict:
    """Return the verdict on the two runs in the figure: gSfG with the given options, and the closest Poisson run."""
    ratio = ours.rms_mm / rival.rms_mm if rival.rms_mm > 0 else 1.0
    held = ratio < 1 and ours.normal_mean_deg <= rival.normal_mean_deg
    summary = (
        f"{'holds' if held else 'does not hold'} as shown: gSfG's vertex deviation is {ratio:.2f} of Poisson's; its "
        f"mean normal deviation is {ours.normal_mean_deg:.2f} degrees, Poisson's {rival.normal_mean_deg:.2f}"
    )
    deg = (rival.normal_mean_deg,) if held else ()
    return Verdict("poisson, as shown", "yes" if held else "no", 1, int(held), deg, ratio, ratio, summary)


def verdicts_of(curves: Mapping[str, tuple[CurvePoint, ...]]) -> tuple[Verdict, ...]:
    """Return the verdicts on the best gSfG variant against each of the Poisson curves."""
    pairs = {name: [(p.normal_deg, p.rms_mm) for p in points] for name, points in curves.items()}
    ours = [pairs[name] for name in (_GRADIENTS, _SHAPES, _PAPER)]
    return tuple(_verdict(rival, compare_fronts(ours, pairs[rival])) for rival in (POISSON_ONCE, POISSON_AGAIN))


def _verdict(rival: str, points: list[FrontPoint]) -> Verdict:
    ratios = [p.ratio for p in points if p.ratio is not None]
    held = tuple(p.normal for p in points if p.ratio is not None and p.ratio < 1)
    count = len(points)
    holds = "yes" if len(held) == count else "in part" if held else "no"
    low, high = (min(ratios), max(ratios)) if ratios else (None, None)
    better = "smaller vertex deviation at equal or smaller normal deviation"
    summary = {
        "yes": f"holds against {rival}: gSfG has {better} at all points of Poisson's front ({count})",
        "in part": (
            f"holds in part against {rival}: gSfG has {better} at {len(held)} of {count} points of Poisson's front"
        ),
        "no": f"does not hold against {rival}: gSfG has {better} at none of the points of Poisson's front ({count})",
    }[holds]
    if holds == "in part":
        summary += f" (normal deviation in degrees: {', '.join(f'{normal:.2f}' for normal in held)})"
    if low is not None and high is not None:
        summary += f"; its vertex deviation is {low:.2f} to {high:.2f} of Poisson's"
    if len(ratios) < count:
        summary += f"; points at which no gSfG run reaches Poisson's normal deviation: {count - len(ratios)}"
    return Verdict(rival, holds, count, len(held), held, low, high, summary)
