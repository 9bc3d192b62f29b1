"""Maps made to give one finding each: ``FAULTY[code](d, codes)`` for a dome, 96 x 96.

Each returns the pixels, the options for reading them, and the chunks of the PNG.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import cv2
import numpy as np
from PIL import Image

SRGB = [(b"sRGB", b"\0"), (b"gAMA", b"\0\0\xb1\x8f")]


class Faulty(NamedTuple):
    pixels: np.ndarray
    options: Mapping[str, str] = MappingProxyType({})
    chunks: tuple[tuple[bytes, bytes], ...] = ()


def rng() -> np.random.Generator:
    return np.random.default_rng(31)


def on_flat(d: Any) -> np.ndarray:
    return np.where(d.inside[..., None], d.normals, (0, 0, 1))


def opaque(d: Any, value: int = 65535) -> np.ndarray:
    return np.where(d.inside, value, 0).astype(np.uint16 if value == 65535 else np.uint8)


def with_alpha(vectors: np.ndarray, d: Any, codes: Any) -> np.ndarray:
    return np.dstack([codes(vectors, 16), opaque(d)])


def signed(*signs: int) -> Callable[..., Faulty]:
    return lambda d, codes: Faulty(with_alpha(d.normals * signs, d, codes))


def off_length(d: Any, codes: Any) -> Faulty:
    vectors = d.normals.copy()
    vectors[rng().uniform(size=(96, 96)) < 0.1] *= 0.7
    return Faulty(with_alpha(vectors, d, codes))


def facing_away(d: Any, codes: Any) -> Faulty:
    vectors = d.normals.copy()
    vectors[rng().uniform(size=(96, 96)) < 0.02] *= (1, 1, -1)
    return Faulty(with_alpha(vectors, d, codes))


def without_blue(d: Any, codes: Any) -> Faulty:
    pixels = with_alpha(d.normals, d, codes)
    pixels[..., 2] = 0
    return Faulty(pixels)


def premultiplied(d: Any, codes: Any) -> Faulty:
    y, x = np.mgrid[0:96, 0:96] - 47.5
    soft = ((0.8 * 48 + 3 - np.hypot(x, y)) / 6).clip(0, 1)
    straight = codes(d.normals, 16) / 65535 * soft[..., None]
    return Faulty(np.round(np.dstack([straight, soft]) * 65535).astype(np.uint16))


def gamma_encoded(d: Any, codes: Any) -> Faulty:
    """Encoded as IEC 61966-2-1 encodes a photograph."""
    shares = (on_flat(d) + 1) / 2
    gamma = np.where(shares <= 0.0031308, 12.92 * shares, 1.055 * shares.clip(0.0031308) ** (1 / 2.4) - 0.055)
    return Faulty(np.floor(gamma * 65535 + 0.5).astype(np.uint16))


def was_jpeg(d: Any, codes: Any) -> Faulty:
    jpeg = cv2.imencode(".jpg", codes(d.normals)[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 60])[1]
    return Faulty(np.dstack([cv2.imdecode(jpeg, cv2.IMREAD_COLOR)[..., ::-1], opaque(d, 255)]))


def with_height(d: Any, codes: Any) -> Faulty:
    height = np.broadcast_to(np.linspace(8000, 60000, 96), (96, 96)).astype(np.uint16)
    return Faulty(np.dstack([codes(d.normals, 16), height]))


def write_palette(path: Path, d: Any, codes: Any) -> None:
    """A palette of 200 colours, as GIF converters leave it, with the motif in its transparency."""
    picture = Image.fromarray(np.dstack([codes(d.normals), opaque(d, 255)]), "RGBA")
    picture.convert("RGB").quantize(200).convert("P").save(path)


def write_turned(path: Path, d: Any, codes: Any) -> None:
    """A picture that viewers turn by a quarter."""
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.fromarray(np.dstack([codes(d.normals), opaque(d, 255)]), "RGBA").save(path, exif=exif)


# maps whose fault is in the file, not in the pixels
FAULTY_FILES: dict[str, Callable[[Path, Any, Any], None]] = {
    "coarse-values": write_palette,
    "orientation": write_turned,
}
FAULTY: dict[str, Callable[[Any, Any], Faulty]] = {
    "no-foreground": lambda d, codes: Faulty(codes(np.broadcast_to((0.0, 0.0, 1.0), (96, 96, 3)))),
    "not-normals": lambda d, codes: Faulty(rng().integers(0, 256, (96, 96, 3), np.uint8)),
    "off-length": off_length,
    "facing-away": facing_away,
    "turned": lambda d, codes: Faulty(with_alpha(d.normals[..., [1, 0, 2]] * (1, -1, 1), d, codes)),
    "inverted": signed(-1, -1, 1),
    "green-down": signed(1, -1, 1),
    "red-left": signed(-1, 1, 1),
    "green-wrong": lambda d, codes: Faulty(with_alpha(d.normals, d, codes), {"green": "down"}),
    "two-components": without_blue,
    "truncated-codes": lambda d, codes: Faulty(np.floor((on_flat(d) + 1) / 2 * 255).astype(np.uint8)),
    "premultiplied": premultiplied,
    "eight-bit-data": lambda d, codes: Faulty(np.dstack([codes(d.normals).astype(np.uint16) * 257, opaque(d)])),
    "color-managed": lambda d, codes: Faulty(with_alpha(d.normals, d, codes), chunks=tuple(SRGB)),
    "alpha-ignored": with_height,
    "background-missing": lambda d, codes: Faulty(codes(d.normals, 16), {"background_color": "white"}),
    "wrong-curve": gamma_encoded,
    "scaled": lambda d, codes: Faulty(with_alpha(d.normals * 0.5, d, codes)),
    "lossy-blocks": was_jpeg,
}
