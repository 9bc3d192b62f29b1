"""Options of every verb as frozen dataclasses: their defaults feed the Python API, the command line and the docs.

Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from nmaptool.options.bake import BakeOptions, DetailEncoding, MeshReadOptions, Renderer, Shading
from nmaptool.options.filter import FilterOptions, SplitOptions
from nmaptool.options.reading import Encoding, Green, ReadOptions, ZeroCode
from nmaptool.options.relief import BackgroundMode, Energy, Fit, ReliefOptions, SolverName
from nmaptool.options.workspace import PackOptions

__all__ = [
    "BackgroundMode",
    "BakeOptions",
    "DetailEncoding",
    "Encoding",
    "Energy",
    "FilterOptions",
    "Fit",
    "Green",
    "MeshReadOptions",
    "PackOptions",
    "ReadOptions",
    "ReliefOptions",
    "Renderer",
    "Shading",
    "SolverName",
    "SplitOptions",
    "ZeroCode",
]
