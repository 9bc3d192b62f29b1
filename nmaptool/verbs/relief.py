"""One or two normal maps to a height field in millimetres."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable

import numpy as np

from nmaptool.arrays import Float32, Float64, Mask
from nmaptool.errors import InputError, UsageError
from nmaptool.formulation.domain import Domain, lay_out
from nmaptool.formulation.fit import factor_for_range, spread_of
from nmaptool.formulation.targets import Targets, Weights, aim, to_pixels
from nmaptool.grid import touching
from nmaptool.model import DEFAULT_LONGER_SIDE_MM, Height, NormalMap
from nmaptool.options import ReliefOptions
from nmaptool.results import Relief, SolveReport
from nmaptool.solver import QuadSystem, Solution, Solver, prepare, slope_load
from nmaptool.verbs.integrate import integrate

Progress = Callable[[str, float], None]


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
    maps = {"mu": mu_map, "beta": beta_map, "delta": delta_map}
    _check_sizes(original, detail, mask, surface, maps)
    pitch_mm, pitch_from = pitch_of(original, options)
    foreground = _foreground(original, mask)
    share = original.coverage if mask is None else original.coverage * np.asarray(mask, np.float32).clip(0, 1)
    base = _base_px(surface, pitch_mm, options)
    domain = lay_out(options.background, foreground, original.coverage >= 0.5, share, base)
    beta, delta = to_pixels(options.beta, options.delta, original.frame.longer_side, options.per_pixel)
    mu = options.mu if detail is not None else 0.0
    weights = Weights(mu, beta, delta, mu_map, beta_map, delta_map)
    targets = aim(original, detail, domain, weights, options.slope_cap, options.energy)
    if progress is not None:
        progress("setting up", 0.0)
    solver = prepare(QuadSystem(targets.weight, targets.beta, domain.held), options.solver)
    prepared = time.perf_counter()
    heights = _solve(solver, domain, targets, weights, options, pitch_mm, progress)
    done = time.perf_counter()
    frame = dataclasses.replace(original.frame, pitch_mm=pitch_mm)
    height = Height(heights.z * pitch_mm, domain.surface, frame)
    report = _report(options, height, domain, weights, targets, solver, heights, pitch_from)
    seconds = {"setup": prepared - started, "solve": done - prepared}
    return Relief(height, foreground, dataclasses.replace(report, seconds=seconds))


def _check_sizes(
    original: NormalMap,
    detail: NormalMap | None,
    mask: Float32 | Mask | None,
    surface: NormalMap | Height | None,
    maps: dict[str, Float32 | None],
) -> None:
    rows, cols = original.frame.shape
    others: dict[str, tuple[int, ...]] = {}
    if detail is not None:
        others[f"the detail map {detail.name}"] = detail.frame.shape
    if mask is not None:
        others["the mask"] = np.shape(mask)
    if surface is not None:
        others["the curved background"] = surface.frame.shape
    for name, values in maps.items():
        if values is None:
            continue
        others[f"the {name} map"] = np.shape(values)
        if not np.isfinite(values).all() or (name != "delta" and values.min() < 0):
            raise InputError(f"the {name} map must be finite{'' if name == 'delta' else ' and not negative'}")
    for what, shape in others.items():
        if shape != (rows, cols):
            size = " x ".join(str(n) for n in reversed(shape))
            raise InputError(f"{original.name} is {cols} x {rows} pixels but {what} is {size}; make them the same size")


def pitch_of(original: NormalMap, options: ReliefOptions) -> tuple[float, str]:
    """Millimetres per pixel of a relief, and whether that was ``given``, in the ``file`` or ``assumed``."""
    frame = original.frame
    if options.width is not None:
        return options.width.to_mm(1.0, frame.longer_side) / frame.cols, "given"
    if frame.pitch_mm is not None:
        return frame.pitch_mm, "file"
    return DEFAULT_LONGER_SIDE_MM / frame.longer_side, "assumed"


def _foreground(original: NormalMap, mask: Float32 | Mask | None) -> Mask:
    kind = original.decoding.background
    if mask is None:
        if not original.foreground.any():
            raise InputError(
                f"{original.name}: every pixel is background ({kind}); nothing is left to make a relief of; "
                "if it is a surface, say --background-color none"
            )
        return original.foreground
    chosen = np.asarray(mask, np.float32) >= 0.5
    if not chosen.any():
        raise InputError("the mask selects nothing: paint the motif white (0.5 or more) on black")
    both = np.asarray(chosen & (original.coverage >= 0.5))
    if not both.any():
        raise InputError(
            f"the mask selects only background ({kind}) of {original.name}; is it upside down or negative?"
        )
    return both


def _base_px(surface: NormalMap | Height | None, pitch_mm: float, options: ReliefOptions) -> Float64 | None:
    if options.background != "surface":
        if surface is not None:
            raise UsageError(f"--surface: only goes with --background surface, not {options.background}")
        return None
    if surface is None:
        raise UsageError("--background surface: needs the curved background, such as --surface background.png")
    if isinstance(surface, Height):
        return surface.z_mm / pitch_mm
    return integrate(surface, options.slope_cap, options.tolerance)


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
        delta = factor_for_range(above[inside], second.z[inside], wanted_px, "delta", pitch_mm)
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
    domain: Domain,
    weights: Weights,
    targets: Targets,
    solver: Solver,
    heights: _Heights,
    pitch_from: str,
) -> SolveReport:
    above = heights.z - domain.base_px
    inside, motif = touching(domain.surface), touching(domain.foreground)
    low, high = height.range_mm
    warnings = []
    if not targets.beta.any() and not domain.held.any():
        warnings.append("beta is 0 and nothing is held: delta has no effect, heights are given with mean 0")
    return SolveReport(
        options=options,
        pitch_mm=height.pitch_mm,
        pitch_from=pitch_from,
        mu=weights.mu,
        beta_px=weights.beta,
        delta_px=heights.delta_px,
        reach_px=weights.reach_px,
        reach_mm=weights.reach_px * height.pitch_mm,
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
        below_background_share=float((above[motif] < 0).mean()),
        foreground_share=float(domain.foreground.mean()),
        steep_share=targets.steep_share,
        scale=heights.scale,
        warnings=tuple(warnings),
    )
