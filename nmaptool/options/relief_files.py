"""Files that a relief is made from, besides its map."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import Text


@dataclass(frozen=True)
class ReliefFiles(Options, group="Inputs"):
    """Files besides the map.

    Parameters
    ----------
    detail:
        Detail map of the same size. --mu sets how strongly its detail is kept or exaggerated.
    mask:
        Grey picture, white where the motif is. Default: found from the map's own background.
    surface:
        Curved background for --background surface: a normal map, or heights in mm (.exr .tif .npy).
    mu_map:
        Grey picture that multiplies mu per pixel.
    beta_map:
        Grey picture that multiplies beta per pixel.
    delta_map:
        Grey picture that multiplies delta per pixel.
    wall_mask:
        Grey picture, white where the motif stands with the walls of --edge wall; the rest runs down into the plate.
        Default: all of it. nmap compose stack --walls writes one for layers with edge = "wall".
    """

    detail: str | None = option(None, Text("detail.exr"))
    mask: str | None = option(None, Text("mask.png"))
    surface: str | None = option(None, Text("roll.exr"))
    mu_map: str | None = option(None, Text("mu.png"))
    beta_map: str | None = option(None, Text("beta.png"))
    delta_map: str | None = option(None, Text("delta.png"))
    wall_mask: str | None = option(None, Text("walls.png"))
