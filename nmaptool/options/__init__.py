"""The options of every command as frozen dataclasses. The Python API, the command line and the docs use their defaults.

Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from nmaptool.options.bake import BakeOptions, DetailEncoding, Geometry, MeshReadOptions, Renderer, Shading
from nmaptool.options.batch import BatchOptions
from nmaptool.options.blend_modes import BLEND_MODES, BlendMode
from nmaptool.options.compare import CompareOptions
from nmaptool.options.compose import (
    Anchor,
    BlendOptions,
    CanvasOptions,
    Clip,
    Ground,
    GroupOptions,
    LayerOptions,
)
from nmaptool.options.depth import DepthBackground, DepthOptions
from nmaptool.options.filter import FilterOptions, SplitOptions
from nmaptool.options.learned import DescriptorOptions, TrainOptions
from nmaptool.options.materials import MATERIALS, Material
from nmaptool.options.parts import PartOptions, PartOrigin
from nmaptool.options.preview import PreviewOptions
from nmaptool.options.reading import Components, Encoding, Green, ReadOptions, ZeroCode
from nmaptool.options.reconstruct import Boundary, ReconstructOptions, Scheme, SmoothOptions
from nmaptool.options.relief import BackgroundMode, Energy, Fit, ReliefOptions, SolverName
from nmaptool.options.relief_files import ReliefFiles
from nmaptool.options.solid import Outline, SolidOptions
from nmaptool.options.tiling import TilingOptions
from nmaptool.options.transform import NewGround, TransformOptions
from nmaptool.options.workspace import PackOptions
from nmaptool.options.write import Bits, HeightsAt, WriteOptions, WrittenGreen, WrittenZeroCode

__all__ = [
    "BLEND_MODES",
    "MATERIALS",
    "Anchor",
    "BackgroundMode",
    "BakeOptions",
    "BatchOptions",
    "Bits",
    "BlendMode",
    "BlendOptions",
    "Boundary",
    "CanvasOptions",
    "Clip",
    "CompareOptions",
    "Components",
    "DepthBackground",
    "DepthOptions",
    "DescriptorOptions",
    "DetailEncoding",
    "Encoding",
    "Energy",
    "FilterOptions",
    "Fit",
    "Geometry",
    "Green",
    "Ground",
    "GroupOptions",
    "HeightsAt",
    "LayerOptions",
    "Material",
    "MeshReadOptions",
    "NewGround",
    "Outline",
    "PackOptions",
    "PartOptions",
    "PartOrigin",
    "PreviewOptions",
    "ReadOptions",
    "ReconstructOptions",
    "ReliefFiles",
    "ReliefOptions",
    "Renderer",
    "Scheme",
    "Shading",
    "SmoothOptions",
    "SolidOptions",
    "SolverName",
    "SplitOptions",
    "TilingOptions",
    "TrainOptions",
    "TransformOptions",
    "WriteOptions",
    "WrittenGreen",
    "WrittenZeroCode",
    "ZeroCode",
]
