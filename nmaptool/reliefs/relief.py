"""Solve one or two normal maps for a height field in millimetres."""

from __future__ import annotations

from nmaptool.core.progress import Progress
from nmaptool.options import ReliefOptions
from nmaptool.reliefs.session import ReliefSession
from nmaptool.types.height import Height
from nmaptool.types.inputs import FloatsLike, MaskLike, NormalsLike
from nmaptool.types.relief import Relief


def relief(
    original: NormalsLike,
    detail: NormalsLike | None = None,
    options: ReliefOptions | None = None,
    *,
    mask: MaskLike | None = None,
    surface: NormalsLike | Height | None = None,
    mu_map: FloatsLike | None = None,
    beta_map: FloatsLike | None = None,
    delta_map: FloatsLike | None = None,
    wall_mask: MaskLike | None = None,
    progress: Progress | None = None,
) -> Relief:
    """Solve for a bas-relief: detail-preserving from O and D (Eq. 6), or structure-preserving from B alone (Eq. 8).

    To solve the same maps with other options, use `ReliefSession`, which recomputes only what a changed option affects.

    Parameters
    ----------
    original : NormalMap or (H, W, 3) float of any type
        The original map O, or the base map B.
    detail : NormalMap or (H, W, 3) float of any type, optional
        The detail map D, of the same size; flat where there is no detail.
    options : ReliefOptions, optional
        Height, width, weights, background, solver.
    mask : (H, W) bool or float in [0, 1], optional
        Foreground where 0.5 or more. Where the mask is 0, the vectors of an array may be anything. Default: the
        foreground of the map.
    surface : NormalMap, (H, W, 3) float or Height, optional
        The curved background for ``background="surface"``.
    mu_map, beta_map, delta_map : (H, W) float of any type, optional
        Factors on mu, beta and delta per pixel; finite, and not negative for mu and beta.
    wall_mask : (H, W) bool or float in [0, 1], optional
        Part of the motif that stands with walls, for ``edge="wall"``; the rest runs down into the plate. Default: all.
    progress : callable, optional
        Called with the stage, such as "setting up" or "solving", and the share done, 0 to 1.

    Returns
    -------
    Relief
        Heights in mm, the surface's mask, pitch and report.

    Raises
    ------
    InputError
        If sizes differ, nothing is foreground, a map has bad values, or the exact height cannot be reached.
    UsageError
        If options contradict each other, or a value is neither a map nor an array.
    LimitError
        If the solve needs more memory than ``options.memory_limit``.
    ConvergenceError
        If the solver does not reach its tolerance.

    Examples
    --------
    The normals of a dome, whose relief is 3 mm high and 40 mm wide:

    >>> y, x = np.mgrid[1:-1:32j, -1:1:32j]
    >>> normals = np.dstack([x, y, np.ones_like(x)])
    >>> options = nm.ReliefOptions(height=nm.length("3mm"), width=nm.length("40mm"))
    >>> nm.relief(normals, options=options, mask=np.hypot(x, y) < 0.9)
    <Relief 40 x 40 mm (32 x 32 px), 0 to 3 mm high, by multigrid in 7 iterations>
    """
    session = ReliefSession(
        original,
        detail,
        mask=mask,
        surface=surface,
        mu_map=mu_map,
        beta_map=beta_map,
        delta_map=delta_map,
        wall_mask=wall_mask,
        keep=0,
    )
    return session.solve(options, progress=progress)
