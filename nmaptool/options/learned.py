"""Options for training a learned filter, and the features it is given."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.core.errors import UsageError
from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import Count, Number

_MOST_PASSES = 20
_MOST_SCALES = 16


@dataclass(frozen=True)
class DescriptorOptions:
    """The filtered normals that describe a face to a learned filter (paper, Sec. 3.2), one for each pair of sigmas.

    Parameters
    ----------
    sigma_s:
        Spatial widths of the filters, in mean edge lengths of the mesh.
    sigma_r:
        Ranges of the filters, as lengths of differences between unit normals.
    passes:
        Passes of each filter in the first stage; later stages make one pass, guided by the previous stage.
    """

    sigma_s: tuple[float, ...] = (3.0, 5.0, 8.0, 10.0, 14.0)
    sigma_r: tuple[float, ...] = (0.2, 0.5, 0.8)
    passes: int = 3

    def __post_init__(self) -> None:
        for name, values, low, high in (("sigma_s", self.sigma_s, 0.1, 1000), ("sigma_r", self.sigma_r, 0.01, 10)):
            if not 1 <= len(values) <= _MOST_SCALES:
                raise UsageError(f"`{name}`: found {len(values)} values, expected 1 to {_MOST_SCALES}")
            for value in values:
                if not low <= value <= high:  # also for NaN
                    raise UsageError(f"`{name}={value:g}`: must lie between {low:g} and {high:g}, such as 3")
        if not 1 <= self.passes <= _MOST_PASSES:
            raise UsageError(f"`passes={self.passes}`: must lie between 1 and {_MOST_PASSES}, such as 3")

    @property
    def size(self) -> int:
        """Number of filtered normals per face."""
        return len(self.sigma_s) * len(self.sigma_r)


@dataclass(frozen=True)
class TrainOptions(Options, group="Filter"):
    """How a filter is trained.

    Parameters
    ----------
    stages:
        Number of stages. Each stage filters the normals of the previous one.
    clusters:
        Number of clusters into which each stage sorts the neighbourhoods of faces. Each cluster has its own network.
    hidden:
        Units in the single hidden layer of each network.
    steps:
        Largest number of optimiser steps for each network.
    samples:
        Largest number of faces that each stage learns from, drawn in equal parts from all meshes.
    weight_decay:
        Weight decay: how strongly large weights are penalised.
    seed:
        Seed of the random draws. The same seed gives the same filter on the same machine.
    """

    stages: int = option(3, Count(high=10))
    clusters: int = option(4, Count(high=64))
    hidden: int = option(32, Count(high=256))
    steps: int = option(100, Count(high=100_000))
    samples: int = option(160_000, Count(high=10_000_000))
    weight_decay: float = option(3e-5, Number("1e-4", 0, 1))
    seed: int = option(1, Count(low=0, high=2**32 - 1))
