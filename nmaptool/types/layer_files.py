"""Layers by the names of their files, for maps larger than memory."""

from __future__ import annotations

from dataclasses import dataclass, field

from nmaptool.options import LayerOptions


@dataclass(frozen=True)
class LayerFile:
    """A layer that is read when it is needed.

    Parameters
    ----------
    map : str
        Its normal map: a Zarr store, a folder of tiles, a TIFF file or another picture.
    options : LayerOptions
    mask : str, optional
        Grey picture of the layer's size: white shows the layer, black hides it.
    """

    map: str
    options: LayerOptions = field(default_factory=LayerOptions)
    mask: str | None = None

    @property
    def name(self) -> str:
        """The name for messages."""
        return self.options.name or self.map
