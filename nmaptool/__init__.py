"""Meshes and normal maps in, carved bas-reliefs in exact millimetres out.

    import nmaptool as nm

    layers = nm.bake(nm.read_mesh("head.ply"))
    relief = nm.relief(layers.original, layers.detail, options=nm.ReliefOptions(height=nm.length("3mm")))
    nm.write_relief(relief, "head.stl", preview="head.png")

Names load when they are first used: importing the package alone loads no heavy library.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from nmaptool._public import MODULES
from nmaptool._version import __version__

if TYPE_CHECKING:
    from nmaptool.cleaning import MeshFindings, clean_mesh
    from nmaptool.compared import Comparison, Contender, CurvePoint, Verdict
    from nmaptool.conversion import ConvertReport
    from nmaptool.curl_shading import curl_picture
    from nmaptool.decoding import decode_normal_map
    from nmaptool.decompose.rolling import Decomposition
    from nmaptool.depth.report import DepthNormals, DepthReport
    from nmaptool.errors import (
        ConvergenceError,
        InputError,
        LimitError,
        NmaptoolError,
        OutputError,
        RendererError,
        UsageError,
    )
    from nmaptool.io.comparison_files import write_comparison
    from nmaptool.io.conversion import convert
    from nmaptool.io.filter_models import read_filter_model, read_training, write_filter_model, write_training
    from nmaptool.io.heights import read_height, read_surface
    from nmaptool.io.layer_files import write_layers
    from nmaptool.io.map_files import write_composition
    from nmaptool.io.mesh_files import write_mesh
    from nmaptool.io.mesh_reader import read_mesh
    from nmaptool.io.normal_maps import read_grey, read_normal_map, read_raster, write_normal_map
    from nmaptool.io.outputs import write_relief
    from nmaptool.io.recipe_files import read_recipe
    from nmaptool.io.stacks import Stack, read_stack
    from nmaptool.io.unpacked import write_unpacked
    from nmaptool.io.workspaces import read_workspace, write_workspace
    from nmaptool.layer_set import LayerReport, LayerSet, Mixture
    from nmaptool.layer_stack import Layer, LayerGroup
    from nmaptool.learned.model import FilterModel, TrainingState
    from nmaptool.learned.shipped import shipped_filter
    from nmaptool.mesh import Mesh
    from nmaptool.model import Decoding, Frame, Height, NormalMap, RasterImage
    from nmaptool.options import (
        BakeOptions,
        BlendOptions,
        CanvasOptions,
        CompareOptions,
        DepthOptions,
        DescriptorOptions,
        FilterOptions,
        GroupOptions,
        LayerOptions,
        MeshReadOptions,
        PackOptions,
        ReadOptions,
        ReconstructOptions,
        ReliefOptions,
        SmoothOptions,
        SplitOptions,
        TrainOptions,
        TransformOptions,
        WriteOptions,
    )
    from nmaptool.orientation import doubts
    from nmaptool.recipe import Recipe, RecipeGroup, RecipeLayer, RecipeLink
    from nmaptool.recipe_parsing import parse_recipe
    from nmaptool.recipe_toml import to_toml
    from nmaptool.reconstructed import Reconstruction, ReconstructReport, Smoothed, SmoothReport
    from nmaptool.results import ComposeReport, Composition, Relief, SolveReport
    from nmaptool.shading import preview
    from nmaptool.tessellate import surface_mesh
    from nmaptool.units import Length, length
    from nmaptool.unpacked import Unpacked, UnpackedLayer
    from nmaptool.verbs.bake import bake, bake_views
    from nmaptool.verbs.blend import blend
    from nmaptool.verbs.compare import compare
    from nmaptool.verbs.compose import compose, paste
    from nmaptool.verbs.decompose import decompose_normals
    from nmaptool.verbs.depth import depth_to_normals
    from nmaptool.verbs.inspect import Finding, Inspection, inspect_map
    from nmaptool.verbs.integrate import integrate
    from nmaptool.verbs.pack import PackedMap, pack
    from nmaptool.verbs.place_layers import place_layers
    from nmaptool.verbs.reconstruct import reconstruct
    from nmaptool.verbs.relief import relief
    from nmaptool.verbs.relief_inputs import pitch_of
    from nmaptool.verbs.relief_session import ReliefSession
    from nmaptool.verbs.smooth import smooth
    from nmaptool.verbs.split import split
    from nmaptool.verbs.train import TrainingExample, train, training_example
    from nmaptool.verbs.transform import transform
    from nmaptool.verbs.unpack import unpack
    from nmaptool.workspace import Workspace, WorkspaceFinding, WorkspaceGroup, WorkspaceLayer, WorkspaceMask

_HOME = {name: module for module, names in MODULES.items() for name in names.split()}

__all__ = [
    "BakeOptions",
    "BlendOptions",
    "CanvasOptions",
    "CompareOptions",
    "Comparison",
    "ComposeReport",
    "Composition",
    "Contender",
    "ConvergenceError",
    "ConvertReport",
    "CurvePoint",
    "Decoding",
    "Decomposition",
    "DepthNormals",
    "DepthOptions",
    "DepthReport",
    "DescriptorOptions",
    "FilterModel",
    "FilterOptions",
    "Finding",
    "Frame",
    "GroupOptions",
    "Height",
    "InputError",
    "Inspection",
    "Layer",
    "LayerGroup",
    "LayerOptions",
    "LayerReport",
    "LayerSet",
    "Length",
    "LimitError",
    "Mesh",
    "MeshFindings",
    "MeshReadOptions",
    "Mixture",
    "NmaptoolError",
    "NormalMap",
    "OutputError",
    "PackOptions",
    "PackedMap",
    "RasterImage",
    "ReadOptions",
    "Recipe",
    "RecipeGroup",
    "RecipeLayer",
    "RecipeLink",
    "ReconstructOptions",
    "ReconstructReport",
    "Reconstruction",
    "Relief",
    "ReliefOptions",
    "ReliefSession",
    "RendererError",
    "SmoothOptions",
    "SmoothReport",
    "Smoothed",
    "SolveReport",
    "SplitOptions",
    "Stack",
    "TrainOptions",
    "TrainingExample",
    "TrainingState",
    "TransformOptions",
    "Unpacked",
    "UnpackedLayer",
    "UsageError",
    "Verdict",
    "Workspace",
    "WorkspaceFinding",
    "WorkspaceGroup",
    "WorkspaceLayer",
    "WorkspaceMask",
    "WriteOptions",
    "__version__",
    "bake",
    "bake_views",
    "blend",
    "clean_mesh",
    "compare",
    "compose",
    "convert",
    "curl_picture",
    "decode_normal_map",
    "decompose_normals",
    "depth_to_normals",
    "doubts",
    "inspect_map",
    "integrate",
    "length",
    "pack",
    "parse_recipe",
    "paste",
    "pitch_of",
    "place_layers",
    "preview",
    "read_filter_model",
    "read_grey",
    "read_height",
    "read_mesh",
    "read_normal_map",
    "read_raster",
    "read_recipe",
    "read_stack",
    "read_surface",
    "read_training",
    "read_workspace",
    "reconstruct",
    "relief",
    "shipped_filter",
    "smooth",
    "split",
    "surface_mesh",
    "to_toml",
    "train",
    "training_example",
    "transform",
    "unpack",
    "write_comparison",
    "write_composition",
    "write_filter_model",
    "write_layers",
    "write_mesh",
    "write_normal_map",
    "write_relief",
    "write_training",
    "write_unpacked",
    "write_workspace",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'nmaptool' has no attribute {name!r}")
    value = getattr(import_module(f"nmaptool.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
