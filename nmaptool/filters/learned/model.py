"""Learned filters and the state of their training."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, read_only
from nmaptool.core.errors import InputError
from nmaptool.filters.learned.network import Network
from nmaptool.options import DescriptorOptions
from nmaptool.types.shown import OneLine, counted


def input_width(descriptor: DescriptorOptions) -> int:
    """Return the number of inputs of a network: a face's own normal, its filtered normals, and their agreements."""
    return 3 + 4 * descriptor.size


@dataclass(frozen=True, eq=False, repr=False)
class Stage(OneLine):
    """The networks of one stage, one per cluster of neighbourhoods.

    Parameters
    ----------
    centers : (K, C) float32
        Centres of the clusters, in the first C inputs of the networks.
    networks : tuple of Network
        One per cluster.

    Raises
    ------
    InputError
        If centres and networks do not match.
    """

    centers: Float32
    networks: tuple[Network, ...]

    def __post_init__(self) -> None:
        if self.centers.ndim != 2 or self.centers.dtype != np.float32 or not np.isfinite(self.centers).all():
            raise InputError(
                f"the cluster centres must be finite float32 (K, C); found {self.centers.dtype} {self.centers.shape}"
            )
        if len(self.networks) != len(self.centers) or not self.networks:
            raise InputError(
                f"a stage needs one network per cluster: networks {len(self.networks)}, clusters {len(self.centers)}"
            )
        for network in self.networks:
            if network.w1.shape[1] < self.centers.shape[1]:
                raise InputError(
                    f"a network has {network.w1.shape[1]} inputs, but the cluster centres have {self.centers.shape[1]}"
                )
        object.__setattr__(self, "centers", read_only(self.centers))


@dataclass(frozen=True, eq=False, repr=False)
class FilterModel(OneLine):
    """A learned filter of face normals (paper, Sec. 3.2: DRNF).

    Parameters
    ----------
    descriptor : DescriptorOptions
        Input of the networks.
    stages : tuple of Stage
        Stages, applied one after the other.
    metadata : mapping
        How the model was trained, as plain values: meshes, seed, options, losses.

    Raises
    ------
    InputError
        If the stages do not match the descriptor.
    """

    descriptor: DescriptorOptions
    stages: tuple[Stage, ...]
    metadata: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.stages:
            raise InputError("a learned filter needs at least one stage")
        width = input_width(self.descriptor)
        for network in (network for stage in self.stages for network in stage.networks):
            if network.w1.shape[1] != width:
                raise InputError(f"a network has {network.w1.shape[1]} inputs, but the descriptor has {width}")
            if len(network.b2) != 1 + self.descriptor.size:
                raise InputError(f"a network mixes {len(network.b2)} normals, expected {1 + self.descriptor.size}")

    @property
    def digest(self) -> str:
        """Identifies the filter: 12 hexadecimal digits, the same for the same weights and descriptor."""
        seen = hashlib.sha256(json.dumps(dataclasses.asdict(self.descriptor)).encode())
        for stage in self.stages:
            for array in (stage.centers, *(w for n in stage.networks for w in (n.w1, n.b1, n.w2, n.b2))):
                seen.update(str(array.shape).encode() + np.ascontiguousarray(array).tobytes())
        return seen.hexdigest()[:12]

    def _line(self) -> str:
        networks = sum(len(stage.networks) for stage in self.stages)
        return f"{self.digest}: {counted(len(self.stages), 'stage')}, {counted(networks, 'network')}"


@dataclass(frozen=True, eq=False, repr=False)
class TrainingState(OneLine):
    """The state of an unfinished training, from which it continues to the same result.

    Parameters
    ----------
    fingerprint : str
        Identifies the examples and options; a training continues only from a state with the same fingerprint.
    stages : tuple of Stage
        Finished stages.
    centers : (K, D) float32 or None
        Cluster centres of the current stage; None if none of its networks is finished.
    networks : tuple of Network
        Finished networks of the current stage.
    losses : tuple of float
        Losses of all finished networks.
    name : str
        Name for messages, such as the file name.
    """

    fingerprint: str
    stages: tuple[Stage, ...] = ()
    centers: Float32 | None = None
    networks: tuple[Network, ...] = ()
    losses: tuple[float, ...] = ()
    name: str = "the state"

    def _line(self) -> str:
        return f"{self.name}: {counted(len(self.stages), 'stage')} and {counted(len(self.networks), 'network')} done"
