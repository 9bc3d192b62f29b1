"""A stored picture as a normal map for another kind of file: what is sound keeps its codes, the rest is repaired."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from nmaptool import codec
from nmaptool.arrays import Float32, Mask
from nmaptool.decoding import decode_normal_map, raw_vectors
from nmaptool.model import Decoding, NormalMap, RasterImage
from nmaptool.options import Bits, ReadOptions, WriteOptions
from nmaptool.options.account import plain_values
from nmaptool.results import ComposeReport, Composition
from nmaptool.vectors import mean_abs_curl, unit

# a vector of which every component is rounded by half a step is at most this many steps off unit length
_ROUNDED = 0.87
_FLOAT_ROUNDED, _HALF_ROUNDED = 1e-5, 6e-4
# what is written stays so many codes from where it was rounded to, so that rounding it again changes nothing
_CODE_BOX = 0.48
_BOX_PASSES = 12
_NEARLY_UNIT = 5e-4


@dataclass(frozen=True, eq=False)
class ConvertReport(ComposeReport):
    """What a conversion did, beside what every edit reports; ``curl_after`` is that of the codes as written.

    Attributes
    ----------
    source, target : mapping
        What the file was and what it is now: bits, green, zero code, components, background.
    vectors : int
        Pixels where the map is defined.
    off_length : int
        Vectors that were off unit length by more than rounding; they are normalised.
    off_length_largest : float
        By how much at most.
    rim_pixels : int
        Anti-aliased pixels that took the normals just inside them; their coverage is in alpha.
    flattened : int
        Pixels of a flat background that were noise and are flat now.
    """

    source: Mapping[str, Any] = field(default_factory=dict)
    target: Mapping[str, Any] = field(default_factory=dict)
    vectors: int = 0
    off_length: int = 0
    off_length_largest: float = 0.0
    rim_pixels: int = 0
    flattened: int = 0


def convert_image(
    image: RasterImage, bits: Bits, reading: ReadOptions | None = None, writing: WriteOptions | None = None
) -> tuple[Composition, WriteOptions]:
    """Read a picture so that writing it loses nothing, and say what is done to it.

    Parameters
    ----------
    image : RasterImage
    bits : str
        "8", "16", "half" or "float": what will be written.
    reading : ReadOptions, optional
    writing : WriteOptions, optional

    Returns
    -------
    composition : Composition
        Its report is a `ConvertReport`. A vector whose length is off by no more than rounding stays as stored (of 8-bit
        codes: becomes the unit vector that rounds to them), so that its codes come back.
    writing : WriteOptions
        With ``bits`` and the zero code settled.

    Raises
    ------
    InputError, UsageError
        As `nmaptool.decode_normal_map`.
    """
    reading, writing = reading or ReadOptions(), writing or WriteOptions()
    start = time.perf_counter()
    read = decode_normal_map(image, reading)
    own = read.decoding.zero_code
    zero = writing.write_zero_code
    if zero == "auto":
        zero = own if own in codec.ZERO_CODES else "127.5"  # type: ignore[assignment]
    writing = replace(writing, bits=bits, write_zero_code=zero)
    stored = _signed(raw_vectors(image, read.decoding), read.decoding)
    as_stored = unit(stored)
    untouched = (read.normals == as_stored).all(axis=-1)
    normals, off, largest = _kept_where_sound(image, stored, read, untouched)
    result = replace(read, normals=normals)
    defined = read.coverage > 0
    flattened = ~untouched & defined & ~read.foreground & (read.decoding.background == "flat")
    inside = read.foreground
    report = ConvertReport(
        command="convert",
        options={**plain_values(reading), **plain_values(writing)},
        curl_before=mean_abs_curl(as_stored, inside),
        curl_after=mean_abs_curl(_as_written(normals, writing), inside),
        seconds={"convert": round(time.perf_counter() - start, 4)},
        source=_source(image, read.decoding),
        target={
            "bits": bits,
            "green": writing.write_green,
            "zero_code": zero if bits in ("8", "16") else "0",
            "alpha": bool((read.coverage < 1).any()),
        },
        vectors=int(defined.sum()),
        off_length=int(off.sum()),
        off_length_largest=largest,
        rim_pixels=read.decoding.rim_pixels,
        flattened=int(flattened.sum()),
    )
    return Composition(result, np.zeros(read.frame.shape, np.float32), report), writing


def _source(image: RasterImage, decoding: Decoding) -> dict[str, Any]:
    bits = {16: "half", 32: "float"}[image.bits] if image.is_float else str(image.bits)
    names = ("green", "swizzle", "zero_code", "encoding", "components", "background")
    return {
        "bits": bits,
        "channels": list(image.channels),
        "lossy": image.lossy,
        **{name: getattr(decoding, name) for name in names},
    }


def _signed(vectors: Float32, decoding: Decoding) -> Float32:
    """Stored vectors with the signs that the swizzle and green say, in eye space."""
    signs = [sign for _, sign in codec.parse_swizzle(decoding.swizzle)]
    if decoding.green == "down":
        signs[1] = -signs[1]
    return vectors * np.array(signs, np.float32) + np.float32(0)  # + 0: flat gives 0, not -0


def _kept_where_sound(
    image: RasterImage, stored: Float32, read: NormalMap, untouched: Mask
) -> tuple[Float32, Mask, float]:
    """Normals that write the codes they were read from, where these are those of a unit vector; where they are not."""
    if read.decoding.encoding != "signed":
        image = codec.narrowed(image)
    if image.is_float:
        step, tolerance = 0.0, _HALF_ROUNDED if image.bits == 16 else _FLOAT_ROUNDED
    else:
        zero_code = read.decoding.zero_code
        step = 1 / codec.zero_and_scale(zero_code, image.max_code)[1]
        tolerance = _ROUNDED * step + 1e-6
    error = np.abs(np.sqrt(np.einsum("ijk,ijk->ij", stored, stored, dtype=np.float64)) - 1)
    sound = untouched & (error <= tolerance)
    off = untouched & ~sound & (read.coverage > 0)
    normals = read.normals.copy()
    if image.max_code == 255:
        normals[sound] = _unit_within(stored[sound], step)
    else:
        normals[sound] = stored[sound]
    return normals, off, float(error[off].max(initial=0))


def _unit_within(vectors: Float32, step: float) -> Float32:
    """Unit vectors that round to the same codes as (N, 3) ``vectors``, which are codes themselves."""
    out = unit(vectors)
    box = np.float32(_CODE_BOX * step)
    left = np.flatnonzero((np.abs(out - vectors) > box).any(axis=1))
    if not left.size:
        return out
    near, here = vectors[left], out[left]
    for _ in range(_BOX_PASSES):  # to and fro between the box of the code and the sphere
        clipped = here.clip(near - box, near + box)
        here = unit(clipped)
    length = np.linalg.norm(clipped, axis=1)
    out[left] = np.where(np.abs(length - 1)[:, None] <= _NEARLY_UNIT, clipped, here)
    return out


def _as_written(normals: Float32, writing: WriteOptions) -> Float32:
    """What a reader will make of the normals once they are stored."""
    if writing.bits == "float":
        return normals
    if writing.bits == "half":
        return unit(normals.astype(np.float16).astype(np.float32))
    codes = codec.encode_codes(normals, int(writing.bits), writing.write_zero_code)
    return unit(codec.decode_codes(codes, writing.write_zero_code))
