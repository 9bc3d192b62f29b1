"""The table of materials that previews show: how each reflects light.

To add a material, add an entry here; help texts, error messages and the README's list are made from the table.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Color = tuple[float, float, float]
Pattern = Literal["none", "clay", "marble", "walnut"]


@dataclass(frozen=True)
class Material:
    """How a material reflects light; colours are linear RGB from 0 to 1.

    Parameters
    ----------
    description : str
        What it looks like, for the help.
    color : (3,) float
        Share of the light that it scatters; for a metal, that it mirrors when seen from the front.
    roughness : float
        0 is a mirror, 1 is dull.
    metal : bool
        Whether it mirrors all the light and scatters none.
    gloss : float
        Share of the light that a polish on a material that is no metal mirrors when seen from the front.
    recess : (3,) float
        Colour in recesses.
    patina : float
        0 to 1: how fully recesses take that colour.
    tarnish : float
        0 to 1: how far level places count as recesses; edges are worn clean.
    spread_mm : float
        How far light travels below the surface.
    pattern : str
        The procedural texture.
    backdrop : (3,) float
        Colour of what it lies on.
    """

    description: str
    color: Color
    roughness: float
    metal: bool = False
    gloss: float = 0.04
    recess: Color = (0.0, 0.0, 0.0)
    patina: float = 0.0
    tarnish: float = 0.0
    spread_mm: float = 0.0
    pattern: Pattern = "none"
    backdrop: Color = (0.045, 0.047, 0.05)


MATERIALS: dict[str, Material] = {
    "clay": Material(
        "is grey modelling clay, dull and even, which shows every form",
        color=(0.47, 0.395, 0.325),
        roughness=0.62,
        gloss=0.035,
        recess=(0.36, 0.31, 0.265),
        patina=0.45,
    ),
    "plaster": Material(
        "is white plaster",
        color=(0.78, 0.76, 0.725),
        roughness=0.85,
        gloss=0.02,
        spread_mm=0.08,
    ),
    "bronze": Material(
        "is cast bronze with a dark patina in the recesses and bright edges",
        color=(0.74, 0.44, 0.2),
        roughness=0.3,
        metal=True,
        recess=(0.085, 0.05, 0.03),
        patina=0.92,
        tarnish=0.5,
    ),
    "silver": Material(
        "is struck silver, darker in the recesses",
        color=(0.93, 0.915, 0.88),
        roughness=0.23,
        metal=True,
        recess=(0.2, 0.19, 0.18),
        patina=0.75,
        tarnish=0.1,
    ),
    "gold": Material(
        "is struck gold",
        color=(1.0, 0.71, 0.29),
        roughness=0.22,
        metal=True,
        recess=(0.55, 0.3, 0.085),
        patina=0.6,
    ),
    "marble": Material(
        "is white marble with grey veins, a little translucent",
        color=(0.76, 0.75, 0.73),
        roughness=0.3,
        gloss=0.04,
        spread_mm=0.45,
        pattern="marble",
    ),
    "walnut": Material(
        "is carved walnut with its grain along the longer side, oiled",
        color=(0.235, 0.118, 0.055),
        roughness=0.4,
        gloss=0.022,
        recess=(0.06, 0.027, 0.012),
        patina=0.55,
        pattern="walnut",
        backdrop=(0.20, 0.195, 0.185),
    ),
}


def material_choices() -> dict[str, str]:
    """The description of each material, for help and messages."""
    return {name: material.description for name, material in MATERIALS.items()}
