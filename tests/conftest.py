"""Fixtures: small images of analytic surfaces, and the command line as a function."""

from __future__ import annotations

import os
import re
import struct
import sys
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

# the benchmark measures memory in a way that Windows does not offer
collect_ignore = ["test_bench_systems.py"] if sys.platform == "win32" else []

BACKDROPS = {"white": (1.0, 1.0, 1.0), "black": (-1.0, -1.0, -1.0), "grey": (0.0, 0.0, 0.0), "flat": (0.0, 0.0, 1.0)}


def _surface_normals(rows: int, cols: int, rise: float, bump: float, over: int) -> SimpleNamespace:
    """Unit normals (y up) of a wavy paraboloid dome, and its disc, on a grid ``over`` times finer."""
    y, x = np.mgrid[0 : rows * over, 0 : cols * over]
    x = ((x + 0.5) / over - cols / 2) / (min(rows, cols) / 2)
    y = -((y + 0.5) / over - rows / 2) / (min(rows, cols) / 2)
    radius = 0.8
    p = -2 * rise * x / radius + bump * np.cos(14 * x) * np.cos(11 * y)
    q = -2 * rise * y / radius - bump * (11 / 14) * np.sin(14 * x) * np.sin(11 * y)
    normals = np.stack([-p, -q, np.ones_like(p)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return SimpleNamespace(normals=normals, inside=np.hypot(x, y) < radius)


@pytest.fixture
def dome() -> Callable[..., SimpleNamespace]:
    """``dome(rows=96, cols=96, smooth=False)``: normals (H, W, 3) float64, inside (H, W) bool, cover (H, W) in 0..1.

    The slopes belong to a height field, so their curl is zero. With ``smooth``, cover is an anti-aliased disc.
    """

    def make(
        rows: int = 96, cols: int = 96, rise: float = 0.7, bump: float = 0.2, smooth: bool = False
    ) -> SimpleNamespace:
        one = _surface_normals(rows, cols, rise, bump, 1)
        cover = one.inside.astype(float)
        if smooth:
            fine = _surface_normals(rows, cols, rise, bump, 8).inside
            cover = fine.reshape(rows, 8, cols, 8).mean(axis=(1, 3))
        return SimpleNamespace(normals=one.normals, inside=one.inside, cover=cover)

    return make


@pytest.fixture
def codes() -> Callable[..., np.ndarray]:
    """``codes(vectors, bits=8)``: rounded integer codes; ``cover`` blends an anti-aliased backdrop in."""

    def encode(vectors: np.ndarray, bits: int = 8, backdrop: str | None = None, cover: Any = None) -> np.ndarray:
        top = 2**bits - 1
        stored = (vectors + 1) / 2 * top
        if backdrop is not None:
            behind = np.floor((np.array(BACKDROPS[backdrop]) + 1) / 2 * top + 0.5)
            stored = cover[..., None] * stored + (1 - cover[..., None]) * behind
        return np.floor(stored + 0.5).clip(0, top).astype(np.uint8 if bits == 8 else np.uint16)

    return encode


def _chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


@pytest.fixture
def png() -> Callable[..., Path]:
    """``png(path, pixels)`` writes a PNG by hand, so it holds nothing but the codes.

    ``chunks`` go before the image data; ``size`` replaces the true size in the header.
    """

    def write(
        path: Path, pixels: np.ndarray, chunks: Sequence[tuple[bytes, bytes]] = (), size: Any = None, cut: int = 0
    ) -> Path:
        if pixels.ndim == 2:
            pixels = pixels[..., None]
        rows, cols, count = pixels.shape
        depth = pixels.dtype.itemsize * 8
        big = pixels.astype(pixels.dtype.newbyteorder(">"))
        raw = b"".join(b"\0" + big[row].tobytes() for row in range(rows))
        cols, rows = size or (cols, rows)
        data = zlib.compress(raw[: len(raw) - cut])
        header = struct.pack(">IIBBBBB", cols, rows, depth, {1: 0, 2: 4, 3: 2, 4: 6}[count], 0, 0, 0)
        parts = [(b"IHDR", header), *chunks, (b"IDAT", data), (b"IEND", b"")]
        path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*part) for part in parts))
        return path

    return write


@pytest.fixture
def picture() -> Callable[..., Path]:
    """``picture(path, pixels, names, ...)`` writes EXR, TIFF, JPEG or BMP through OpenImageIO."""

    def write(
        path: Path, pixels: np.ndarray, names: Sequence[str] = ("R", "G", "B"), stored: str | None = None, **more: Any
    ) -> Path:
        kinds = {"uint8": "uint8", "uint16": "uint16", "float32": "float", "float64": "float"}
        rows, cols, count = pixels.shape
        spec = oiio.ImageSpec(cols, rows, count, stored or kinds[pixels.dtype.name])
        spec.channelnames = tuple(names)
        spec.alpha_channel = list(names).index("A") if "A" in names else -1
        spec.attribute("oiio:UnassociatedAlpha", 1)
        for key, value in more.items():
            if hasattr(spec, key):
                setattr(spec, key, value)
            else:
                spec.attribute(key.replace("__", ":"), value)
        sink = oiio.ImageOutput.create(str(path))
        data = pixels.astype(np.float32) if pixels.dtype == np.float64 else pixels
        assert sink.open(str(path), spec), sink.geterror()
        assert sink.write_image(np.ascontiguousarray(data)), sink.geterror()
        assert sink.close()
        return path

    return write


@pytest.fixture
def run(capfd: pytest.CaptureFixture[str]) -> Callable[..., SimpleNamespace]:
    """``run("inspect", path)`` runs the command line: code, stdout and stderr, including output of C libraries."""
    from nmaptool_cli.main import main

    def call(*words: object) -> SimpleNamespace:
        capfd.readouterr()
        code = main([str(word) for word in words])
        sys.stdout.flush()
        out, err = capfd.readouterr()
        return SimpleNamespace(code=code, out=out, err=err)

    return call


@pytest.fixture
def wide_help(monkeypatch: pytest.MonkeyPatch) -> None:
    """Show help in lines of 2000 characters, regardless of the console that an earlier test set."""
    from rich.console import Console

    from nmaptool_cli.main import app

    monkeypatch.setattr(app, "_console", Console(width=2000, height=100))


@pytest.fixture
def tree(tmp_path: Path) -> Callable[[], dict[str, bytes | None]]:
    """``tree()``: every file under tmp_path, hidden ones too, with its bytes; folders as None."""

    def look() -> dict[str, bytes | None]:
        found = sorted(tmp_path.rglob("*"))
        return {p.relative_to(tmp_path).as_posix(): p.read_bytes() if p.is_file() else None for p in found}

    return look


@pytest.fixture
def symlink() -> Callable[[Path, Path | str], None]:
    """``symlink(path, target)`` makes a symbolic link; skips where Windows does not allow it."""

    def make(path: Path, target: Path | str) -> None:
        try:
            path.symlink_to(target)
        except OSError:
            if sys.platform != "win32":
                raise
            pytest.skip("this account may not make symbolic links")

    return make


@pytest.fixture
def clean_map(tmp_path: Path, dome: Any, codes: Any, png: Any) -> Path:
    """A flawless 16-bit PNG of the dome with straight alpha."""
    d = dome()
    alpha = (d.inside * 65535).astype(np.uint16)
    return png(tmp_path / "clean.png", np.dstack([codes(d.normals, 16), alpha]))


@pytest.fixture
def fails() -> Callable[..., None]:
    """``fails(result, code, pattern)``: no output, and one error line that a designer understands."""

    def check(result: SimpleNamespace, code: int, pattern: str) -> None:
        assert re.search(pattern, result.err.replace(os.sep, "/")), result.err
        assert result.err.startswith("nmap: error: ")
        assert result.err.count("\n") == 1
        assert result.err.endswith("\n")
        assert result.out == ""
        assert result.code == code
        for word in ("Traceback", "Errno", "None", "into float", "['", "OIIO", "subimage", "this is a bug", "/tmp/tmp"):
            assert word not in result.err

    return check


@pytest.fixture
def refused(run: Any, tree: Any, fails: Any) -> Callable[..., None]:
    """``refused(code, pattern, *words)``: the command fails with this code and message, and changes no file."""

    def call(code: int, pattern: str, *words: object) -> None:
        before = tree()
        fails(run(*words), code, pattern)
        assert tree() == before

    return call


@pytest.fixture
def maps(tmp_path: Path, dome: Any, codes: Any, png: Any, picture: Any, clean_map: Path) -> dict[str, Path]:
    """A clean map, and files with one fault each."""
    d = dome()
    code = codes(d.normals)
    bad = d.normals.copy()
    bad[20, 30] = np.nan
    grey = np.full((96, 96), 255, np.uint8)
    corner = np.zeros((96, 96), np.uint8)
    corner[:4, :4] = 255
    flat = np.zeros((96, 96, 3), np.uint8) + np.uint8([128, 128, 255])
    (tmp_path / "text.png").write_text("hello\n", encoding="utf-8")
    (tmp_path / "empty.png").touch()
    (tmp_path / "folder.png").mkdir()
    cut = png(tmp_path / "cut.png", code)
    cut.write_bytes(cut.read_bytes()[:3000])
    return {
        "clean": clean_map,
        "text": tmp_path / "text.png",
        "empty": tmp_path / "empty.png",
        "folder": tmp_path / "folder.png",
        "cut": cut,
        "missing": tmp_path / "missing.png",
        "wrong": picture(tmp_path / "wrong.exr", d.normals).rename(tmp_path / "wrong.png"),
        "nan": picture(tmp_path / "nan.exr", bad),
        "one": png(tmp_path / "one.png", grey),
        "two": png(tmp_path / "two.png", np.dstack([grey, grey])),
        "small": png(tmp_path / "small.png", code[:64, :80]),
        "small-mask": png(tmp_path / "small-mask.png", grey[:64, :80]),
        "black": png(tmp_path / "black.png", np.zeros((96, 96), np.uint8)),
        "corner": png(tmp_path / "corner.png", corner),
        "flat": png(tmp_path / "flat.png", flat),
        "clear": png(tmp_path / "clear.png", np.dstack([code, corner * 0])),
        "huge": png(tmp_path / "huge.png", code, size=(100_000, 100_000)),
        "hollow": png(tmp_path / "hollow.png", code[:2, :2], size=(16_000, 16_000)),
    }
