"""An unpacked workspace: for each layer a normal map, its position, and what an editor changed."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from nmaptool.core.arrays import Float32
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import Frame
from nmaptool.types.shown import OneLine, counted
from nmaptool.types.workspace import WorkspaceFinding, WorkspaceGroup


@dataclass(frozen=True, eq=False, repr=False)
class UnpackedLayer(OneLine):
    """A layer of a workspace as a normal map of the layer's size.

    Parameters
    ----------
    name : str
    normal_map : NormalMap
        The map of the layer's rectangle.
    left, top : int
        Position of its top left pixel on the canvas, px; may be negative.
    mask : (h, w) float32 in [0, 1] or None
        Mask of the same rectangle.
    mode : str
    strength : float
        Strength, multiplied by the layer's opacity.
    visible : bool
    groups : tuple of WorkspaceGroup
        Outermost first; layers that share a group refer to the same object.
    findings : tuple of WorkspaceFinding
    repairs : tuple of str
    """

    name: str
    normal_map: NormalMap
    left: int
    top: int
    mask: Float32 | None
    mode: str
    strength: float
    visible: bool
    groups: tuple[WorkspaceGroup, ...]
    findings: tuple[WorkspaceFinding, ...]
    repairs: tuple[str, ...]

    def _line(self) -> str:
        found = counted(len(self.findings), "finding")
        return f"{self.name}: {self.normal_map.frame} px at {self.left}, {self.top}, mode {self.mode}, {found}"


@dataclass(frozen=True, eq=False, repr=False)
class UnpackResult(OneLine):
    """All layers of a workspace, and what an editor changed.

    Parameters
    ----------
    name : str
        Name of the file.
    frame : Frame
        The canvas.
    bits : int
        Bits per channel in the file.
    layers : tuple of UnpackedLayer
        Bottom to top.
    findings : tuple of WorkspaceFinding
        Findings of the whole file first, then those of the layers.
    ground : str
        What is below the lowest layer: ``clear`` or ``flat``.
    has_metadata : bool
        Whether nmaptool's own metadata is still in the file; without it, moves and mirroring cannot be recognised.
    """

    name: str
    frame: Frame
    bits: int
    layers: tuple[UnpackedLayer, ...]
    findings: tuple[WorkspaceFinding, ...]
    has_metadata: bool
    ground: str = "clear"

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        layers = [
            {
                "name": one.name,
                "left": one.left,
                "top": one.top,
                "cols": one.normal_map.frame.cols,
                "rows": one.normal_map.frame.rows,
                "mode": one.mode,
                "strength": one.strength,
                "visible": one.visible,
                "mask": one.mask is not None,
                "groups": [group.name for group in one.groups],
                "repairs": list(one.repairs),
            }
            for one in self.layers
        ]
        return {
            "name": self.name,
            "cols": self.frame.cols,
            "rows": self.frame.rows,
            "pitch_mm": self.frame.pitch_mm,
            "bits": self.bits,
            "ground": self.ground,
            "has_words": self.has_metadata,
            "layers": layers,
            "findings": [asdict(finding) for finding in self.findings],
        }

    def _line(self) -> str:
        layers, found = counted(len(self.layers), "layer"), counted(len(self.findings), "finding")
        return f"{self.name}: {self.frame.with_pitch}, {self.bits} bits, {layers}, {found}"
