"""Small normal maps with known normals for the tests of large maps, in many encodings."""

from __future__ import annotations

import numpy as np

from nmaptool.io.stores import sampling
from nmaptool.io.stores.opening import create_picture
from nmaptool.types.picture import RasterImage

ROWS, COLS = 210, 190


def surface(rows=ROWS, cols=COLS):
    """(H, W, 3) float64 unit normals of smooth bumps, and the (H, W) coverage of a motif with a soft outline."""
    y, x = np.mgrid[0:rows, 0:cols]
    p, q = np.zeros((2, rows, cols))
    for cy, cx, size, height in ((0.3, 0.3, 0.11, 9), (0.6, 0.7, 0.2, 22), (0.75, 0.25, 0.08, -6), (0.2, 0.8, 0.1, 8)):
        dy, dx, s = y - cy * rows, x - cx * cols, size * min(rows, cols)
        bump = height * np.exp(-(dx * dx + dy * dy) / (2 * s * s))
        p, q = p - bump * dx / s**2, q + bump * dy / s**2  # y up
    vectors = np.dstack([-p, -q, np.ones_like(p)])
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    radius = np.hypot((y - rows / 2) / (0.46 * rows), (x - cols / 2) / (0.46 * cols))
    coverage = ((1 - radius) * 0.46 * min(rows, cols) + 0.5).clip(0, 1)
    return vectors, coverage


def codes_of(vectors, bits=8, zero_code="127.5"):
    """Codes of (..., 3) vectors as floats, not yet rounded."""
    top = (1 << bits) - 1
    zero, scale = {"127.5": (top / 2, top / 2), "128": (top / 2 + 0.5, top / 2 - 0.5)}[zero_code]
    return vectors * scale + zero


def rounded(codes, bits=8):
    return np.floor(codes + 0.5).clip(0, (1 << bits) - 1).astype(np.uint8 if bits == 8 else np.uint16)


def on_color(codes, coverage, color):
    """Codes mixed with those of a background, as anti-aliasing does."""
    return codes * coverage[..., None] + np.asarray(color, float) * (1 - coverage[..., None])


def picture(pixels, channels=("R", "G", "B"), bits=None, **more):
    kind = bits or min(32, 8 * pixels.dtype.itemsize)
    return RasterImage(pixels, channels[: pixels.shape[2]], "map", kind, **more)


def encodings():
    """Pictures in many encodings, with the options that they need, by name."""
    n, coverage = surface()
    eight, sixteen = codes_of(n), codes_of(n, 16)
    alpha = rounded(coverage[..., None] * 255)
    floats = n.astype(np.float32)
    shares = ((n + 1) / 2).astype(np.float32)
    down = n * (1, -1, 1)
    flat = n.copy()
    flat[60:120] = 0, 0, 1
    return {
        "8 bits": (picture(rounded(eight)), {}),
        "green down": (picture(rounded(codes_of(down))), {}),
        "code 128": (picture(rounded(codes_of(flat, 8, "128"))), {}),
        "16 bits": (picture(rounded(sixteen, 16)), {}),
        "8 in 16 bits": (picture(rounded(eight).astype(np.uint16) * np.uint16(257)), {}),
        "8 times 256": (picture(rounded(eight).astype(np.uint16) * np.uint16(256)), {}),
        "8 bits in floats": (picture(rounded(eight).astype(np.float32) / np.float32(255)), {}),
        "signed": (picture(floats), {}),
        "half": (picture(floats.astype(np.float16).astype(np.float32), bits=16), {}),
        "unsigned": (picture(shares), {}),
        "two channels": (picture(rounded(eight)[..., :2].copy(), ("R", "G")), {}),
        "no blue": (picture(np.dstack([rounded(eight)[..., :2], np.zeros((ROWS, COLS), np.uint8)])), {}),
        "x in alpha": (dxt5nm(rounded(eight)), {}),
        "swizzled": (picture(rounded(codes_of(np.dstack([n[..., 1], -n[..., 0], n[..., 2]])))), {"swizzle": "-g,r,b"}),
        "srgb": (picture(rounded(srgb((n + 1) / 2) * 255)), {"curve": "srgb"}),
        "alpha": (picture(np.dstack([rounded(eight), alpha]), ("R", "G", "B", "A")), {}),
        "signed alpha": (picture(np.dstack([floats, coverage.astype(np.float32)]), ("R", "G", "B", "A")), {}),
        "white": (picture(rounded(on_color(eight, coverage, (255, 255, 255)))), {}),
        "black": (picture(rounded(on_color(eight, coverage, (0, 0, 0)))), {}),
        "grey": (picture(rounded(on_color(eight, coverage, (128, 128, 128)))), {}),
        "white in 16 bits": (picture(rounded(on_color(sixteen, coverage, (65535,) * 3), 16)), {}),
        "black in signed floats": (picture(on_color(floats, coverage, (0, 0, 0)).astype(np.float32)), {}),
        "white in unsigned floats": (picture(on_color(shares, coverage, (1, 1, 1)).astype(np.float32)), {}),
        "grey with two components": (
            picture(rounded(on_color(eight, coverage, (128, 128, 128)))),
            {"components": "xy", "background_color": "grey"},
        ),
        "colour": (picture(rounded(on_color(eight, coverage, (20, 200, 90)))), {"background_color": "#14c85a"}),
        "none": (picture(rounded(on_color(eight, coverage, (255, 255, 255)))), {"background_color": "none"}),
    }


def dxt5nm(codes):
    ones = np.full(codes.shape[:2], 255, np.uint8)
    return picture(np.dstack([ones, codes[..., 1], ones, codes[..., 0]]), ("R", "G", "B", "A"))


def srgb(shares):
    return np.where(shares <= 0.0031308, shares * 12.92, 1.055 * shares ** (1 / 2.4) - 0.055)


def as_zarr(image, path, chunk=64):
    """Store a picture and return the name of the store."""
    pixels = image.pixels.astype(np.float16) if image.is_float and image.bits == 16 else image.pixels
    rows, cols = pixels.shape[:2]
    writer = create_picture(
        str(path), rows, cols, image.channels, pixels.dtype, chunk=chunk, inner=16, attributes=image.attributes
    )
    writer.write(0, 0, pixels)
    return str(path)


def shrink_sample(monkeypatch):
    """Make the sample as small, compared with the maps of these tests, as it is with large maps."""
    monkeypatch.setattr(sampling, "_SAMPLE_PX", 40)
    monkeypatch.setattr(sampling, "_PROBES", 5)
    monkeypatch.setattr(sampling, "_PROBE_PX", 16)
