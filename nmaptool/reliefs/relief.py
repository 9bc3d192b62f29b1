"""One or two normal maps to a height field in millimetres."""

from __future__ import annotations

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.progress import Progress
from nmaptool.options import ReliefOptions
from nmaptool.reliefs.session import ReliefSession
from nmaptool.types.height import Height
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.relief import Relief


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
    session = ReliefSession(
        original,
        detail,
        mask=mask,
        surface=surface,
        mu_map=mu_map,
        beta_map=beta_map,
        delta_map=delta_map,
        keep=0,
    )
    return session.solve(options, progress)
