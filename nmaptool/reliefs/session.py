"""Solve many reliefs of the same maps, reusing the results of earlier solves."""

from __future__ import annotations

import contextlib
import dataclasses
import threading
from collections.abc import Iterator

from nmaptool.core.errors import UsageError
from nmaptool.core.progress import Progress, Stages
from nmaptool.options import ReliefOptions
from nmaptool.reliefs import inputs as given
from nmaptool.reliefs.cases import CappedPair, Case, ground_key, holds, layout_of
from nmaptool.reliefs.finish import finish
from nmaptool.reliefs.heights import SolveSettings, SystemHeights
from nmaptool.reliefs.report import facts_of, report_of
from nmaptool.reliefs.targets import Weights, build_targets, capped_slopes, to_pixels
from nmaptool.solver import QuadSystem, Solver, prepare
from nmaptool.types.height import Height
from nmaptool.types.inputs import FloatsLike, MaskLike, NormalsLike
from nmaptool.types.relief import Relief
from nmaptool.types.relief_parts import ReliefParts


class ReliefSession:
    """Solve reliefs of the same maps with changing options, such as for a live preview.

    Only what a changed option affects is recomputed. A new delta, height, fit, width or looser tolerance needs no
    solver iterations: heights are linear in delta, and their two parts are kept from the second delta on. With a new
    mu, beta, slope cap or energy, the solver starts from the previous heights. Results equal those of `nmaptool.relief`
    within the tolerance; each has its own arrays, which later solves do not change.

    Parameters
    ----------
    original, detail, mask, surface, mu_map, beta_map, delta_map, wall_mask
        As for `nmaptool.relief`.
    keep : int
        How many combinations of mu, beta, background and so on to keep with their solver and heights, the most recently
        used ones first; with 2, you can go back and forth between two. Each takes the memory of a solve plus 32 bytes
        per pixel. 0 keeps nothing.

    Notes
    -----
    Maps are neither copied nor changed, and must not be changed while the session is in use. Several threads may call
    `solve`; the solves run one after the other. A solve that fails or is interrupted leaves the session intact.

    Raises
    ------
    InputError
        If sizes differ or a map has bad values.
    UsageError
        If an input has the wrong type, there is a mu map without a detail map, or ``keep`` is negative.
    """

    def __init__(
        self,
        original: NormalsLike,
        detail: NormalsLike | None = None,
        *,
        mask: MaskLike | None = None,
        surface: NormalsLike | Height | None = None,
        mu_map: FloatsLike | None = None,
        beta_map: FloatsLike | None = None,
        delta_map: FloatsLike | None = None,
        wall_mask: MaskLike | None = None,
        keep: int = 2,
    ) -> None:
        self._maps = given.check_maps(original, detail, mask, surface, mu_map, beta_map, delta_map, wall_mask)
        if keep < 0:
            raise UsageError(f"`keep={keep}`: must be zero or more")
        self._keep = keep
        self._cases: list[Case] = []  # most recently used first
        self._lock = threading.Lock()
        self._solving: int | None = None  # the thread that is solving

    def solve(
        self,
        options: ReliefOptions | None = None,
        *,
        preview_tolerance: float | None = None,
        progress: Progress | None = None,
    ) -> Relief:
        """Solve for the relief with these options.

        Parameters
        ----------
        options : ReliefOptions, optional
            Height, width, weights, background, solver.
        preview_tolerance : float, optional
            Relative residual, between 0 and 1, that is enough while a slider moves, if it is larger than
            ``options.tolerance``. With 2e-5, heights are within 1e-4 of their range on all masks of bench.session. The
            report states the residual reached; a later solve without it continues from these heights.
        progress : callable, optional
            Called with the name of the stage and the share done, 0 to 1; an exception that it raises ends the solve.

        Returns
        -------
        Relief
            Its report counts the iterations of this solve only: 0 if none was needed.

        Raises
        ------
        InputError
            If nothing is foreground or the exact height cannot be reached.
        UsageError
            If options contradict each other, or ``preview_tolerance`` is not between 0 and 1.
        LimitError
            If the solve needs more memory than ``options.memory_limit``.
        ConvergenceError
            If the solver does not reach its tolerance.

        Examples
        --------
        >>> session = nm.ReliefSession(np.dstack([np.full((8, 8), 0.5), np.zeros((8, 8)), np.ones((8, 8))]))
        >>> for height in ("2mm", "3mm"):
        ...     session.solve(nm.ReliefOptions(background="free", height=nm.length(height)))
        <Relief 100 x 100 mm (8 x 8 px), 3.203 to 5.203 mm high, by dct in 1 iteration>
        <Relief 100 x 100 mm (8 x 8 px), 4.804 to 7.804 mm high, by dct in 0 iterations>
        """
        options = options or ReliefOptions()
        with self._alone(preview_tolerance):
            return self._solve(options, max(options.tolerance, preview_tolerance or 0.0), progress)

    def parts(
        self,
        options: ReliefOptions | None = None,
        *,
        preview_tolerance: float | None = None,
        progress: Progress | None = None,
    ) -> ReliefParts:
        """Solve for the two parts of the heights: those for delta 0, and what each unit of delta adds.

        A front end that has them computes every other delta, height and width itself. What was solved is kept for
        later calls, as with `solve`, and the other way round.

        Parameters
        ----------
        options : ReliefOptions, optional
            ``delta``, ``height`` and ``fit`` have no effect; ``width`` only sets the pitch.
        preview_tolerance, progress
            As for `solve`.

        Returns
        -------
        ReliefParts

        Raises
        ------
        UsageError
            If the motif stands with walls (``edge="wall"``): their heights are not linear in delta.
        InputError, LimitError, ConvergenceError
            As for `solve`.

        Examples
        --------
        >>> session = nm.ReliefSession(np.dstack([np.full((8, 8), 0.5), np.zeros((8, 8)), np.ones((8, 8))]))
        >>> parts = session.parts(nm.ReliefOptions(background="free"))
        >>> np.allclose(parts.z_mm(delta=40), session.solve(nm.ReliefOptions(background="free", delta=40)).z_mm)
        True
        """
        options = options or ReliefOptions()
        with self._alone(preview_tolerance):
            stages, tolerance = Stages(progress), max(options.tolerance, preview_tolerance or 0.0)
            case, _, (pitch_mm, _), warm_start = self._begin(options, stages)
            if case.layout.standing is not None:
                raise UsageError("`edge='wall'`: the heights of walls are not linear in `delta`; solve for each")
            with stages.stage("solve"):
                settings = SolveSettings(tolerance, options.max_iterations, progress)
                first, second, _ = case.heights.parts(settings, warm_start)
        domain, original = case.layout.domain, self._maps.original
        per_delta = to_pixels(0.0, 1.0, original.frame.longer_side, options.per_pixel)[1]
        return ReliefParts(first, second, domain.base_px, domain.surface, original.frame, pitch_mm, per_delta)

    @contextlib.contextmanager
    def _alone(self, preview_tolerance: float | None) -> Iterator[None]:
        """One solve after the other, and none inside its own progress callback."""
        if preview_tolerance is not None and not 0 < preview_tolerance < 1:
            raise UsageError(f"`preview_tolerance={preview_tolerance}`: must be between 0 and 1, both excluded")
        if self._solving == threading.get_ident():
            raise UsageError("a session cannot solve inside its own progress callback: call it after that has returned")
        with self._lock:
            self._solving = threading.get_ident()
            try:
                yield
            finally:
                self._solving = None

    def _begin(
        self, options: ReliefOptions, stages: Stages
    ) -> tuple[Case, Weights, tuple[float, str], SystemHeights | None]:
        """Return the case of these options, its weights, the pitch, and heights to start from."""
        with stages.stage("inputs"):
            pitch_mm, pitch_from = given.pitch_of(self._maps.original, options)
            weights = self._weights(options)
        case = self._case_for(options, weights, pitch_mm, stages)
        warm_start = next((c.heights for c in self._cases if c is not case and c.layout is case.layout), None)
        # kept even if the requested height turns out to be unreachable
        self._cases = [case, *(c for c in self._cases if c is not case)][: self._keep]
        return case, weights, (pitch_mm, pitch_from), warm_start

    def _solve(self, options: ReliefOptions, tolerance: float, progress: Progress | None) -> Relief:
        stages = Stages(progress)
        original = self._maps.original
        case, weights, (pitch_mm, pitch_from), warm_start = self._begin(options, stages)
        with stages.stage("solve"):
            settings = SolveSettings(tolerance, options.max_iterations, progress)
            heights = finish(case.heights, case.layout, weights.delta, options, pitch_mm, settings, warm_start)
        with stages.stage("finish"):
            frame = dataclasses.replace(original.frame, pitch_mm=pitch_mm)
            standing = case.layout.standing
            raised = None if standing is None else standing.motif
            height = Height(heights.z_mm, case.layout.domain.surface, frame, raised)
            report = report_of(
                options,
                case.layout.facts(heights.z_mm),
                weights,
                heights.facts,
                case.facts,
                (pitch_mm, pitch_from),
                case.steep_share,
                frame.longer_side,
                case.pulled,
            )
        report = dataclasses.replace(report, seconds=stages.elapsed)
        return Relief(height, case.layout.motif, report, case.layout.coverage)

    def _weights(self, options: ReliefOptions) -> Weights:
        maps = self._maps
        beta, delta = to_pixels(options.beta, options.delta, maps.original.frame.longer_side, options.per_pixel)
        return Weights(options.mu if maps.detail is not None else 0.0, beta, delta, maps.mu, maps.beta, maps.delta)

    def _case_for(self, options: ReliefOptions, weights: Weights, pitch_mm: float, stages: Stages) -> Case:
        """Return the case of these options: a kept one, or a new one that reuses what other cases share with it."""
        maps = self._maps
        # mu and the energy have no effect without a detail map
        energy = options.energy if maps.detail is not None else "eq6"
        stiffened = weights.mu if energy == "eq6" else 0.0
        ground = ground_key(maps, options, pitch_mm)
        held = ground[:1] if options.background == "surface" else ground  # the solver does not depend on its height
        system = (*held, weights.beta, stiffened, options.solver)
        shape = (weights.mu, energy, options.slope_cap)
        with stages.stage("inputs"):
            for case in self._cases:
                if (case.ground, case.system, case.shape) == (ground, system, shape) and holds(case, maps, options):
                    case.heights.solver.check_memory(options.memory_limit_bytes)
                    return case
            same_ground = (c for c in self._cases if c.ground == ground and holds(c, maps, options))
            layout = next((c.layout for c in same_ground), None) or layout_of(maps, options, pitch_mm)
            capped: CappedPair | None = self._capped(options.slope_cap)
            stages.tell("setting up", 0.0)
            targets = build_targets(
                maps.original, maps.detail, layout.domain, weights, options.slope_cap, energy, capped
            )
            if not self._keep:
                capped = None
            base_px = layout.domain.base_px
            load = targets.shape_load(base_px)
            weight, beta, pull, steep_share = targets.weight, targets.beta, targets.pull, targets.steep_share
            del targets  # its slopes are in the load
        with stages.stage("setup"):
            solver = self._solver_of(system, options)
            if solver is None:
                like = next((c.heights.solver for c in self._cases if c.layout is layout), None)
                system_here = QuadSystem(weight, beta, layout.domain.held)
                solver = prepare(system_here, options.solver, options.memory_limit_bytes, like)
        return Case(
            ground,
            system,
            shape,
            layout,
            options.slope_cap,
            capped,
            SystemHeights(solver, base_px, load, pull, kept=self._keep > 0),
            facts_of(solver),
            bool(beta.any()),
            steep_share,
        )

    def _capped(self, slope_cap: float) -> CappedPair:
        """Return the capped slopes of the maps."""
        known = next((c.capped for c in self._cases if c.slope_cap == slope_cap), None)
        if known is not None:
            return known
        detail = self._maps.detail
        return (
            capped_slopes(self._maps.original.normals, slope_cap),
            None if detail is None else capped_slopes(detail.normals, slope_cap),
        )

    def _solver_of(self, system: tuple[object, ...], options: ReliefOptions) -> Solver | None:
        """Return a kept solver for these values, if there is one."""
        solver = next((c.heights.solver for c in self._cases if c.system == system), None)
        if solver is not None:
            solver.check_memory(options.memory_limit_bytes)
        return solver
