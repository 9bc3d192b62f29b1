"""Options of plates: their shape, frame and lettering, and the machines that make them."""

from nmaptool.options.plates.frame import FrameOptions
from nmaptool.options.plates.machine import MACHINES, Machine, MachineOptions
from nmaptool.options.plates.plate import Hole, PlateOptions
from nmaptool.options.plates.text import TextOptions

__all__ = ["MACHINES", "FrameOptions", "Hole", "Machine", "MachineOptions", "PlateOptions", "TextOptions"]
