"""One or two normal maps to a height field in millimetres."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import numpy as np

from nmaptool.arrays import Float32, Float64, Mask
from nmaptool.errors import InputError, UsageError
from nmaptool.formulation.domain import Domain, lay_out
from nmaptool.formulation.fit import factor_for_range, spread_of
from nmaptool.formulation.targets import Targets, Weights, aim, to_pixels
from nmaptool.grid import touching
from nmaptool.model import Height, NormalMap
from nmaptool.options import ReliefOptions
from nmaptool.progress import Progress
from nmaptool.results import Relief, SolveReport
from nmaptool.solver import QuadSystem, Solution, Solver, prepare, slope_load
from nmaptool.verbs import relief_inputs as given

# where so much of a motif on a flat background is flat, it is likely lettering or an emblem
_MUCH_FLAT = 0.1


def relief(
    original: NormalMap,
    detail: NormalMap | None = None,
    *,
    mask: Float32 | Mask | None = None,
    surface: NormalMap | Height | None = None,
    mu_map: Float32 | None = None,
    beta_map: Float32 | None = None,
    delta_map: Float32 | None = None,
    options: ReliefOptions | None = None,
    progress: Progress | None = None,
) -> Relief:
    """Solve a bas-relief: detail-preserving from O and D (Eq. 6), structure-preserving from B alone (Eq. 8).

    Parameters
    ----------
    original : NormalMap
        The original map O, or the base map B.
    detail : NormalMap, optional
        The detail map D, same size; flat where there is no detail.
    mask : (H, W) float or bool, optional
        Foreground where 0.5 or more. Default: what the map's file shows as motif.
    surface : NormalMap or Height, optional
        The curved background for ``background="surface"``.
    mu_map, beta_map, delta_map : (H, W) float32, optional
        Multiply mu, beta and delta per pixel; finite, mu and beta not negative.
    options : ReliefOptions, optional
    progress : callable, optional
        Called with a word and a share in 0..1.

    Returns
    -------
    Relief
        Heights in mm, the surface's mask, pitch and report.

    Raises
    ------
    InputError
        If sizes differ, nothing is foreground, a map holds bad values, or the exact height cannot be reached.
    UsageError
        If options do not go together.
    ConvergenceError
        If the solver does not reach its tolerance.
    """
    options = options or ReliefOptions()
    started = time.perf_counter()
    weights, coverage = _inputs(original, detail, mask, surface, (mu_map, beta_map, delta_map), options)
    pitch_mm, pitch_from = given.pitch_of(original, options)
    held = options.background in ("plane", "surface")
    foreground = given.motif_of(original, coverage, fading=held)
    base_px, ground = given.base_of(surface, pitch_mm, options)
    domain = lay_out(
        options.background,
        foreground,
        original.coverage >= 0.5,
        original.coverage if coverage is None else original.coverage * coverage,
        base_px,
        given.pulled_part(original, foreground, coverage),
        ground,
    )
    targets = aim(original, detail, domain, weights, options.slope_cap, options.energy)
    if progress is not None:
        progress("setting up", 0.0)
    system = QuadSystem(targets.weight, targets.beta, domain.held)
    solver = prepare(system, options.solver, options.memory_limit_bytes)
    prepared = time.perf_counter()
    heights = _solve(solver, domain, targets, weights, options, pitch_mm, progress)
    done = time.perf_counter()
    frame = dataclasses.replace(original.frame, pitch_mm=pitch_mm)
    height = Height(heights.z * pitch_mm, domain.surface, frame)
    report = _report(options, height, foreground, domain, weights, targets, solver, heights, pitch_from)
    seconds = {"setup": prepared - started, "solve": done - prepared}
    return Relief(height, foreground, dataclasses.replace(report, seconds=seconds))


def _inputs(
    original: NormalMap,
    detail: NormalMap | None,
    mask: Any,
    surface: Any,
    maps: tuple[Any, Any, Any],
    options: ReliefOptions,
) -> tuple[Weights, Float32 | None]:
    """Checked weights in pixels, and the mask."""
    given.require_map(original, "the original")
    others: dict[str, tuple[int, ...]] = {}
    if detail is not None:
        given.require_map(detail, "the detail map")
        others[f"the detail map {detail.name}"] = detail.frame.shape
    elif maps[0] is not None:
        raise UsageError("--mu-map: weighs the detail map; give one with --detail")
    coverage = given.check_mask(mask)
    if coverage is not None:
        others["the mask"] = coverage.shape
    if isinstance(surface, NormalMap | Height):
        others["the curved background"] = surface.frame.shape
    checked = given.check_weights(dict(zip(("mu", "beta", "delta"), maps, strict=True)))
    others |= {f"the {name} map": values.shape for name, values in checked.items() if values is not None}
    given.check_sizes(original, others)
    beta, delta = to_pixels(options.beta, options.delta, original.frame.longer_side, options.per_pixel)
    mu = options.mu if detail is not None else 0.0
    return Weights(mu, beta, delta, checked["mu"], checked["beta"], checked["delta"]), coverage


@dataclasses.dataclass(frozen=True, eq=False)
class _Heights:
    """Heights in px, delta and factor that they were made with, and the solve."""

    z: Float64
    delta_px: float
    scale: float
    solution: Solution


def _solve(
    solver: Solver,
    domain: Domain,
    targets: Targets,
    weights: Weights,
    options: ReliefOptions,
    pitch_mm: float,
    progress: Progress | None,
) -> _Heights:
    """Heights z = base + h0 + delta h1 with the exact range that was asked for."""
    base, inside = domain.base_px, touching(domain.surface)
    shape_load = slope_load(targets.p, targets.q) + targets.beta * base

    def solve(load: Float64, held: Float64 | None) -> Solution:
        return solver.solve(
            load, held, tolerance=options.tolerance, max_iterations=options.max_iterations, progress=progress
        )

    wanted_px = None
    if options.height is not None:
        wanted_px = options.height.to_mm(pitch_mm, max(domain.surface.shape)) / pitch_mm
    if wanted_px is None or options.fit == "scale":
        solution = solve(shape_load + weights.delta * targets.pull, base)
        if wanted_px is None:
            return _Heights(solution.z, weights.delta, 1.0, solution)
        above = solution.z - base
        size = spread_of(above[inside])
        if size <= 1e-12 * max(1.0, float(np.abs(solution.z).max())):
            raise InputError(f"--height {options.height}: the relief is flat and cannot be scaled to a height")
        return _Heights(base + wanted_px / size * above, weights.delta, wanted_px / size, solution)
    first, second = solve(shape_load, base), solve(targets.pull, None)
    above = first.z - base
    delta, slope = weights.delta, 1.0
    if options.fit == "slope":
        slope = factor_for_range(delta * second.z[inside], above[inside], wanted_px, "the slopes", pitch_mm)
    else:
        side = -1.0 if weights.delta < 0 else 1.0  # an engraving stays an engraving
        delta = side * factor_for_range(above[inside], side * second.z[inside], wanted_px, "delta", pitch_mm)
    both = Solution(
        base + slope * above + delta * second.z,
        max(first.residual, second.residual),
        first.iterations + second.iterations,
        first.history + second.history,
    )
    return _Heights(both.z, delta, slope, both)


def _report(
    options: ReliefOptions,
    height: Height,
    foreground: Mask,
    domain: Domain,
    weights: Weights,
    targets: Targets,
    solver: Solver,
    heights: _Heights,
    pitch_from: str,
) -> SolveReport:
    above = heights.z - domain.base_px
    inside, motif = touching(domain.surface), touching(foreground)
    low, high = height.range_mm
    reach_px = weights.reach_px(options.energy)
    warnings = []
    if not domain.held.any():
        if not targets.beta.any():
            warnings.append("beta is 0 and nothing is held: delta has no effect, heights are given with mean 0")
        elif options.background in ("plane", "surface"):
            warnings.append(
                "no background was found to hold: the whole picture is surface, its height counts from delta"
            )
    left_alone = float((foreground & ~domain.foreground).mean())
    if left_alone > _MUCH_FLAT * foreground.mean() and targets.beta.any():
        warnings.append("much of the motif is flat; for lettering and emblems --beta 0 keeps every height of the map")
    if reach_px < 1:
        warnings.append(f"beta is so large that shape is kept over {reach_px:.2g} px only: little but delta is left")
    if options.fit == "slope" and heights.scale < 0.05:
        warnings.append(
            f"the slopes were scaled by {heights.scale:.2g} to reach the height: little of the shape is left"
        )
    return SolveReport(
        options=options,
        pitch_mm=height.pitch_mm,
        pitch_from=pitch_from,
        mu=weights.mu,
        beta_px=weights.beta,
        delta_px=heights.delta_px,
        px_per_delta=to_pixels(1.0, 1.0, height.frame.longer_side, options.per_pixel)[1],
        reach_px=reach_px,
        reach_mm=reach_px * height.pitch_mm,
        solver=solver.method.name,
        unknowns=solver.unknowns,
        islands=solver.islands.count,
        floating_islands=int(solver.islands.floating.sum()),
        iterations=heights.solution.iterations,
        residual=heights.solution.residual,
        history=heights.solution.history,
        height_min_mm=low,
        height_max_mm=high,
        height_range_mm=high - low,
        relief_range_mm=spread_of(above[inside]) * height.pitch_mm,
        below_background_share=float((above[motif] < 0).mean()) if domain.held.any() else 0.0,
        foreground_share=float(foreground.mean()),
        steep_share=targets.steep_share,
        scale=heights.scale,
        warnings=tuple(warnings),
    )
