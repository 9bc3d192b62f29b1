"""The light that a surface sends to the viewer: diffuse and glossy reflection of lamps, the sky and the studio."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.options.materials import Material
from nmaptool.options.preview import Light
from nmaptool.shading.environment import mirrored
from nmaptool.shading.lights import direction, power

# colours of the lamps and of the sky
_LAMP = np.array([1.0, 0.972, 0.93], np.float32)
_SKY = np.array([0.93, 0.965, 1.0], np.float32)
_KEY, _AMBIENT = 0.62, 0.14
# light of the lamps that a metal mirrors, besides that of the studio
_GLINT = 0.5


@dataclass(frozen=True, eq=False)
class Facets:
    """Points of a surface and the light that they see, as arrays of one shape.

    Attributes
    ----------
    normal : three arrays
        x, y and z of unit normals.
    soft_normal : three arrays
        The same for light that is scattered, which has travelled below the surface of a translucent material.
    view : three arrays or floats
        Unit vectors to the viewer.
    lit : sequence of array
        Share of each light that is not hidden.
    sky : array
        Share of the sky that is seen.
    recess : array
        0 to 1: how much the point lies in a recess.
    color : (..., 3) array or (3,) float32
        Colour of the material.
    """

    normal: tuple[Any, Any, Any]
    soft_normal: tuple[Any, Any, Any]
    view: tuple[Any, Any, Any]
    lit: Sequence[Float32]
    sky: Float32
    recess: Float32
    color: Float32


def radiance(facets: Facets, material: Material, lights: Sequence[Light]) -> Float32:
    """(..., 3) linear light towards the viewer; 1 is white paper in full light."""
    stain = np.float32(material.patina) * facets.recess
    color = facets.color + stain[..., None] * (np.array(material.recess, np.float32) - facets.color)
    glossy = _glossy(facets, material, lights)
    if not material.metal:
        out = irradiance(facets, lights, color) * color
        return np.asarray(out + glossy[..., None], np.float32)
    # patina in recesses scatters light instead of mirroring it
    clean = (1 - stain)[..., None]
    facing = _dot(facets.normal, facets.view).clip(0, 1)
    edge = (1 - facing) ** 5
    tint = color + edge[..., None] * (1 - color)
    mirrored_light = glossy[..., None] * tint * (np.float32(0.25) + np.float32(0.75) * clean)
    scattered = irradiance(facets, lights, color) * color * np.float32(0.8)
    return np.asarray(mirrored_light + (1 - clean) * scattered, np.float32)


def _dot(a: tuple[Any, Any, Any], b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def irradiance(facets: Facets, lights: Sequence[Light], color: Float32) -> Float32:
    """(..., 3) light that arrives, relative to that on a level plate."""
    lamps = np.zeros(facets.sky.shape, np.float32)
    for light, lit in zip(lights, facets.lit, strict=True):
        toward = direction(light).astype(np.float32)
        lamps += np.float32(_KEY * power(light)) * lit * np.clip(_dot(facets.soft_normal, toward), 0, None)
    # light that bounces between the walls of a recess brightens it, and takes on its colour
    sky = facets.sky[..., None]
    bounced = sky / (1 - np.float32(0.6) * color * (1 - sky))
    return np.asarray(lamps[..., None] * _LAMP + bounced * (np.float32(_AMBIENT) * _SKY), np.float32)


def _glossy(facets: Facets, material: Material, lights: Sequence[Light]) -> Float32:
    """Light that is mirrored, without colour."""
    normal, view = facets.normal, facets.view
    facing = np.maximum(_dot(normal, view), np.float32(1e-3))
    alpha = material.roughness**2
    key = facets.lit[0] if len(facets.lit) else np.float32(1)
    # the studio
    x, y, z = (2 * facing * n - v for n, v in zip(normal, view, strict=True))
    azimuth = lights[0].azimuth_deg if lights else 135.0
    studio = mirrored((x, y, z), material.roughness, azimuth, key)
    hidden = facets.sky * facets.sky
    if material.metal:
        out = studio * hidden
    else:
        fresnel = material.gloss + (1 - material.gloss) * (1 - facing) ** 5 * (1 - material.roughness)
        out = studio * hidden * fresnel * np.float32(0.7)
    share = np.float32(_GLINT if material.metal else material.gloss)
    for light, lit in zip(lights, facets.lit, strict=True):
        out += share * np.float32(power(light)) * lit * _glint(normal, view, facing, direction(light), alpha)
    return np.asarray(out, np.float32)


def _glint(normal: Any, view: Any, facing: Any, lamp: Any, alpha: float) -> Any:
    """The GGX lobe of a lamp, times the cosine."""
    lamp = lamp.astype(np.float32)
    halfway = [v + np.float32(part) for v, part in zip(view, lamp, strict=True)]
    length = np.sqrt(halfway[0] * halfway[0] + halfway[1] * halfway[1] + halfway[2] * halfway[2])
    toward = np.maximum(_dot(normal, lamp), 0)
    across = _dot(normal, halfway) / length
    square = np.float32(alpha * alpha)
    spread = across * across * (square - 1) + 1
    shape = square / (np.float32(math.pi) * spread * spread)
    k = np.float32(alpha / 2)
    masked = 4 * (toward * (1 - k) + k) * (facing * (1 - k) + k)
    return shape * toward / masked
