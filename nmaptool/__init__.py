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

from nmaptool._version import __version__

if TYPE_CHECKING:
    from nmaptool.cleaning import MeshFindings, clean_mesh
    from nmaptool.conversion import ConvertReport
    from nmaptool.curl_picture import curl_picture
    from nmaptool.decoding import decode_normal_map
    from nmaptool.decompose.rolling import Decomposition
    from nmaptool.errors import (
        ConvergenceError,
        InputError,
        LimitError,
        NmaptoolError,
        OutputError,
        RendererError,
        UsageError,
    )
    from nmaptool.io.conversion import convert
    from nmaptool.io.heights import read_height, read_surface
    from nmaptool.io.layer_files import write_layers
    from nmaptool.io.map_files import write_composition
    from nmaptool.io.mesh_reader import read_mesh
    from nmaptool.io.normal_maps import read_grey, read_normal_map, read_raster, write_normal_map
    from nmaptool.io.outputs import write_relief
    from nmaptool.io.recipe_files import read_recipe
    from nmaptool.io.stacks import Stack, read_stack
    from nmaptool.layer_set import LayerReport, LayerSet, Mixture
    from nmaptool.layer_stack import Layer, LayerGroup
    from nmaptool.mesh import Mesh
    from nmaptool.model import Decoding, Frame, Height, NormalMap, RasterImage
    from nmaptool.options import (
        BakeOptions,
        BlendOptions,
        CanvasOptions,
        FilterOptions,
        GroupOptions,
        LayerOptions,
        MeshReadOptions,
        ReadOptions,
        ReliefOptions,
        SplitOptions,
        TransformOptions,
        WriteOptions,
    )
    from nmaptool.orientation import doubts
    from nmaptool.recipe import Recipe, RecipeGroup, RecipeLayer, RecipeLink
    from nmaptool.recipe_parsing import parse_recipe
    from nmaptool.recipe_toml import to_toml
    from nmaptool.results import ComposeReport, Composition, Relief, SolveReport
    from nmaptool.shading import preview
    from nmaptool.tessellate import surface_mesh
    from nmaptool.units import Length, length
    from nmaptool.verbs.bake import bake, bake_views
    from nmaptool.verbs.blend import blend
    from nmaptool.verbs.compose import compose, paste
    from nmaptool.verbs.decompose import decompose_normals
    from nmaptool.verbs.inspect import Finding, Inspection, inspect_map
    from nmaptool.verbs.integrate import integrate
    from nmaptool.verbs.relief import relief
    from nmaptool.verbs.relief_inputs import pitch_of
    from nmaptool.verbs.split import split
    from nmaptool.verbs.transform import transform

_HOME = {
    "MeshFindings": "cleaning",
    "clean_mesh": "cleaning",
    "ConvertReport": "conversion",
    "curl_picture": "curl_picture",
    "decode_normal_map": "decoding",
    "Decomposition": "decompose.rolling",
    "ConvergenceError": "errors",
    "InputError": "errors",
    "LimitError": "errors",
    "NmaptoolError": "errors",
    "OutputError": "errors",
    "RendererError": "errors",
    "UsageError": "errors",
    "convert": "io.conversion",
    "read_height": "io.heights",
    "read_surface": "io.heights",
    "write_layers": "io.layer_files",
    "write_composition": "io.map_files",
    "read_mesh": "io.mesh_reader",
    "read_grey": "io.normal_maps",
    "read_normal_map": "io.normal_maps",
    "read_raster": "io.normal_maps",
    "write_normal_map": "io.normal_maps",
    "write_relief": "io.outputs",
    "read_recipe": "io.recipe_files",
    "Stack": "io.stacks",
    "read_stack": "io.stacks",
    "LayerReport": "layer_set",
    "LayerSet": "layer_set",
    "Mixture": "layer_set",
    "Layer": "layer_stack",
    "LayerGroup": "layer_stack",
    "Mesh": "mesh",
    "Decoding": "model",
    "Frame": "model",
    "Height": "model",
    "NormalMap": "model",
    "RasterImage": "model",
    "BakeOptions": "options",
    "BlendOptions": "options",
    "CanvasOptions": "options",
    "FilterOptions": "options",
    "GroupOptions": "options",
    "LayerOptions": "options",
    "MeshReadOptions": "options",
    "ReadOptions": "options",
    "ReliefOptions": "options",
    "SplitOptions": "options",
    "TransformOptions": "options",
    "WriteOptions": "options",
    "doubts": "orientation",
    "Recipe": "recipe",
    "RecipeGroup": "recipe",
    "RecipeLayer": "recipe",
    "RecipeLink": "recipe",
    "parse_recipe": "recipe_parsing",
    "to_toml": "recipe_toml",
    "ComposeReport": "results",
    "Composition": "results",
    "Relief": "results",
    "SolveReport": "results",
    "preview": "shading",
    "surface_mesh": "tessellate",
    "Length": "units",
    "length": "units",
    "bake": "verbs.bake",
    "bake_views": "verbs.bake",
    "blend": "verbs.blend",
    "compose": "verbs.compose",
    "paste": "verbs.compose",
    "decompose_normals": "verbs.decompose",
    "Finding": "verbs.inspect",
    "Inspection": "verbs.inspect",
    "inspect_map": "verbs.inspect",
    "integrate": "verbs.integrate",
    "relief": "verbs.relief",
    "pitch_of": "verbs.relief_inputs",
    "split": "verbs.split",
    "transform": "verbs.transform",
}

__all__ = [
    "BakeOptions",
    "BlendOptions",
    "CanvasOptions",
    "ComposeReport",
    "Composition",
    "ConvergenceError",
    "ConvertReport",
    "Decoding",
    "Decomposition",
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
    "RasterImage",
    "ReadOptions",
    "Recipe",
    "RecipeGroup",
    "RecipeLayer",
    "RecipeLink",
    "Relief",
    "ReliefOptions",
    "RendererError",
    "SolveReport",
    "SplitOptions",
    "Stack",
    "TransformOptions",
    "UsageError",
    "WriteOptions",
    "__version__",
    "bake",
    "bake_views",
    "blend",
    "clean_mesh",
    "compose",
    "convert",
    "curl_picture",
    "decode_normal_map",
    "decompose_normals",
    "doubts",
    "inspect_map",
    "integrate",
    "length",
    "parse_recipe",
    "paste",
    "pitch_of",
    "preview",
    "read_grey",
    "read_height",
    "read_mesh",
    "read_normal_map",
    "read_raster",
    "read_recipe",
    "read_stack",
    "read_surface",
    "relief",
    "split",
    "surface_mesh",
    "to_toml",
    "transform",
    "write_composition",
    "write_layers",
    "write_normal_map",
    "write_relief",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'nmaptool' has no attribute {name!r}")
    value = getattr(import_module(f"nmaptool.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
