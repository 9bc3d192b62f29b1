"""Convert a stored normal map to another kind of file: valid pixels keep their codes, the others are repaired."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.vectors import mean_abs_curl, unit
from nmaptool.maps import codec
from nmaptool.maps.decoding import Decoded, decode_image
from nmaptool.maps.doubts import check_facing
from nmaptool.maps.two_channel import completed
from nmaptool.maps.zero_code import ZERO_CODES
from nmaptool.options import Bits, ReadOptions, WriteOptions
from nmaptool.options.plain_values import plain_values
from nmaptool.types.composition import Composition
from nmaptool.types.conversion import ConvertReport
from nmaptool.types.normal_map import Decoding
from nmaptool.types.picture import RasterImage

# largest error of the lengths of unit vectors stored in 16 bits (floats may come from those), and as half floats
_ROUNDED, _HALF_ROUNDED = 3e-5, 6e-4
# half widths, in codes, of the box around a code in which its unit vector is chosen: rounding it again gives the same
# code; with a narrower box, this is also true after storage as half floats
_CODE_BOXES = (0.44, 0.49, 0.498)
_NEARLY_UNIT = 3e-6
# the zero code is the middle if that reduces the mean length error below this share
_BETTER_LENGTH = 0.8
_SAMPLE = 100_000


def convert_image(
    image: RasterImage, bits: Bits, reading: ReadOptions | None = None, writing: WriteOptions | None = None
) -> tuple[Composition, WriteOptions]:
    """Read a picture for lossless writing, and report what is changed.

    Parameters
    ----------
    image : RasterImage
    bits : str
        "8", "16", "half" or "float": the depth to write.
    reading : ReadOptions, optional
    writing : WriteOptions, optional

    Returns
    -------
    composition : Composition
        Its report is a `ConvertReport`. A vector whose length is off by no more than rounding keeps its stored value
        (for 8-bit codes: the unit vector that rounds to them), so writing it gives the same codes.
    writing : WriteOptions
        Options with ``bits`` and the zero code set.

    Raises
    ------
    InputError, UsageError
        As for `nmaptool.decode_normal_map`.
    """
    reading, writing = reading or ReadOptions(), writing or WriteOptions()
    start = time.perf_counter()
    decoded = _read(image, reading)
    read = decoded.normal_map
    own = read.decoding.zero_code
    zero = writing.write_zero_code
    if zero == "auto":
        zero = own if own in ZERO_CODES else "127.5"  # type: ignore[assignment]
    writing = replace(writing, bits=bits, write_zero_code=zero)
    as_stored = unit(decoded.stored)
    untouched = (read.normals == as_stored).all(axis=-1)
    normals, off, largest = kept_where_sound(image, decoded, untouched)
    result = replace(read, normals=normals)
    defined = read.coverage > 0
    flattened = ~untouched & defined & ~read.foreground & read.flat_background
    inside = read.foreground
    report = ConvertReport(
        command="convert",
        options={**plain_values(reading), **plain_values(writing)},
        curl_before=mean_abs_curl(as_stored, inside),
        curl_after=mean_abs_curl(as_written(normals, writing), inside),
        seconds={"convert": round(time.perf_counter() - start, 4)},
        source=source_facts(image, read.decoding),
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


def _read(image: RasterImage, reading: ReadOptions) -> Decoded:
    """Read a picture; if its zero code was inferred from flat pixels only, check it by the lengths of the others.

    Writers that round store flat as 128 although their zero code is the middle, 127.5.
    """
    decoded = decode_image(image, reading)
    check_facing(decoded.normal_map, decoded.findings, reading)
    if decoded.normal_map.decoding.zero_code_from != "found" or not middle_fits_better(decoded):
        return decoded
    decoded = decode_image(image, replace(reading, zero_code="127.5"))
    read = decoded.normal_map
    return replace(decoded, normal_map=replace(read, decoding=replace(read.decoding, zero_code_from="found")))


def middle_fits_better(decoded: Decoded) -> bool:
    """Whether the motif's vectors are clearly closer to unit length with the zero code in the middle."""
    channels, foreground = decoded.channels, decoded.normal_map.foreground
    motif = np.flatnonzero(foreground)
    sample = np.unravel_index(motif[:: max(1, len(motif) // _SAMPLE)], foreground.shape)
    middle = codec.decode_map(channels.xyz[sample][None], replace(channels.coding, zero_code="127.5"))[0]
    if channels.components != "xyz":
        middle = completed(middle[:, :2], channels.components)
    return _mean_length_error(middle) < _BETTER_LENGTH * _mean_length_error(decoded.stored[sample])


def _mean_length_error(vectors: Float32) -> float:
    """Return the mean error of the lengths of (N, 3) vectors, which should be 1."""
    return float(np.abs(np.linalg.norm(vectors.astype(np.float64), axis=1) - 1).mean()) if len(vectors) else 0.0


def source_facts(image: RasterImage, decoding: Decoding) -> dict[str, Any]:
    """What a report says about the input."""
    bits = {16: "half", 32: "float"}[image.bits] if image.is_float else str(image.bits)
    names = ("green", "swizzle", "zero_code", "encoding", "components", "background")
    return {
        "bits": bits,
        "channels": list(image.channels),
        "lossy": image.lossy,
        **{name: getattr(decoding, name) for name in names},
    }


def kept_where_sound(image: RasterImage, decoded: Decoded, untouched: Mask) -> tuple[Float32, Mask, float]:
    """Return normals that are written as the codes they were read from, if these encode a unit vector; and the others.

    Parameters
    ----------
    image : RasterImage
    decoded : Decoded
    untouched : (H, W) bool
        Where reading only normalised the stored vector.

    Returns
    -------
    normals : (H, W, 3) float32
    off : (H, W) bool
        Where the stored vector is not of unit length.
    largest : float
        The largest length error there.
    """
    stored, read, coding = decoded.stored, decoded.normal_map, decoded.channels.coding
    error = np.abs(np.sqrt(np.einsum("ijk,ijk->ij", stored, stored, dtype=np.float64)) - 1)
    normals = read.normals.copy()
    if coding.max_code == 255:
        sound = untouched.copy()
        normals[untouched], sound[untouched] = _unit_within(stored[untouched], coding.step)
    else:
        tolerance = _HALF_ROUNDED if coding.is_float and image.bits == 16 else _ROUNDED
        sound = untouched & (error <= tolerance)
        normals[sound] = stored[sound]
    off = untouched & ~sound & (read.coverage > 0)
    return normals, off, float(error[off].max(initial=0))


def _unit_within(vectors: Float32, step: float) -> tuple[Float32, Mask]:
    """Return unit vectors that round to the same codes as (N, 3) decoded ``vectors``, and where they exist.

    Elsewhere, the vectors are normalised.
    """
    out = unit(vectors)
    found = np.ones(len(out), bool)
    left = np.flatnonzero((np.abs(out - vectors) > _CODE_BOXES[0] * step).any(axis=1))
    for size in _CODE_BOXES:
        # from the centre of the code's box towards its corner nearest to the sphere, up to the sphere
        middle = vectors[left].astype(np.float64)
        square = np.einsum("ij,ij->i", middle, middle)
        move = -np.sign(square - 1)[:, None] * np.sign(middle) * size * step
        a, b = np.einsum("ij,ij->i", move, move), 2 * np.einsum("ij,ij->i", middle, move)
        root = np.sqrt(np.maximum(b * b - 4 * a * (square - 1), 0))
        share = 2 * (1 - square) / np.where(b < 0, b - root, b + root + 1e-30)
        corner = middle + share.clip(0, 1)[:, None] * move
        near = np.abs(np.linalg.norm(corner, axis=1) - 1) <= _NEARLY_UNIT
        out[left[near]] = corner[near]
        left = left[~near]
    found[left] = False
    return out, found


def as_written(normals: Float32, writing: WriteOptions) -> Float32:
    """Return the normals as they will be read from the written file."""
    if writing.bits == "float":
        return normals
    if writing.bits == "half":
        return unit(normals.astype(np.float16).astype(np.float32))
    bits, zero_code = int(writing.bits), writing.write_zero_code
    codes = codec.encode_map(normals, None, bits, zero_code=zero_code)
    return unit(codec.decode_map(codes, codec.Coding((1 << bits) - 1, zero_code)))
