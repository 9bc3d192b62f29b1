"""Normal maps by windows: decoding a window equals decoding the whole."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from large_maps import COLS, ROWS, as_zarr, codes_of, encodings, on_color, picture, rounded, shrink_sample, surface

import nmaptool as nm
from nmaptool.core.errors import InputError, UsageError
from nmaptool.io.stores import sampling
from nmaptool.io.stores.normal_maps import open_normal_map, reopen_normal_map
from nmaptool.io.stores.opening import open_picture
from nmaptool.maps.settled import SettledReading
from nmaptool.maps.windows import WINDOW_MARGIN_PX, decode_window

pytest.importorskip("zarr")
ENCODINGS = encodings()


def windows_of(rows, cols, count=12, seed=3):
    """Windows of all sizes, and the whole."""
    random = np.random.default_rng(seed)
    yield slice(0, rows), slice(0, cols)
    for _ in range(count):
        bounds = [np.sort(random.choice(size + 1, 2, replace=False)) for size in (rows, cols)]
        yield tuple(slice(int(first), int(end)) for first, end in bounds)


def assert_same(part, whole, window):
    assert np.array_equal(part.normals, whole.normals[window])
    assert np.array_equal(part.coverage, whole.coverage[window])
    assert np.array_equal(part.foreground, whole.foreground[window])


@pytest.fixture
def small_sample(monkeypatch):
    shrink_sample(monkeypatch)


def unseen_place(name):
    """A pixel that the sample of a map does not show."""
    picture, seen = open_picture(name), np.zeros((ROWS, COLS), bool)

    def note(image, first):
        rows, cols = image.frame.shape
        seen[first[0] : first[0] + rows, first[1] : first[1] + cols] = True

    sampling.sample_of(picture, note)
    inner = ~seen
    inner[:10] = inner[-10:] = inner[:, :10] = inner[:, -10:] = False
    return np.argwhere(inner)[len(np.argwhere(inner)) // 2]


@pytest.mark.parametrize("file", ["medal_original", "medal_base", "leaf_on_roll", "roll", "medal_detail"])
def test_windows_of_the_samples_are_decoded_as_the_whole(tmp_path, file):
    path = f"samples/{file}.png"
    whole = nm.read_normal_map(path)
    for name in (path, as_zarr(nm.read_raster(path), tmp_path / "map.zarr")):
        opened = open_normal_map(name)
        assert opened.decoding.green == whole.decoding.green
        store = reopen_normal_map(name, pickle.loads(pickle.dumps(opened.settled)))
        for window in windows_of(*whole.frame.shape, 4):
            assert_same(store.window(*window), whole, window)


@pytest.mark.usefixtures("small_sample")
@pytest.mark.parametrize("name", ENCODINGS)
def test_windows_are_decoded_as_the_whole_in_every_encoding(tmp_path, name):
    image, options = ENCODINGS[name]
    whole = nm.decode_normal_map(image, nm.ReadOptions(**options))
    store = open_normal_map(as_zarr(image, tmp_path / "map.zarr"), nm.ReadOptions(**options))
    for key in ("green", "swizzle", "zero_code", "encoding", "components", "background"):
        assert getattr(store.decoding, key) == getattr(whole.decoding, key)
    store = reopen_normal_map(store.name, pickle.loads(pickle.dumps(store.settled)))
    for window in windows_of(ROWS, COLS):
        assert_same(store.window(*window), whole, window)


def settled(**options):
    return SettledReading(
        green="up", swizzle="r,g,b", zero_code="127.5", encoding="unsigned", components="xyz", **options
    )


@pytest.mark.parametrize("background", ["white", "black", "grey", "alpha", "#00ff00"])
@pytest.mark.parametrize("seed", range(4))
def test_no_pixel_depends_on_one_beyond_the_margin(background, seed):
    """Backgrounds of all sizes at random places, with specks, ragged rims and vectors of odd length."""
    random = np.random.default_rng(seed)
    shape = (230, 240)
    vectors = random.normal(size=(*shape, 3)) * (0.3, 0.3, 0.1) + (0, 0, 1)
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    vectors *= np.where(random.random(shape) < (0.02, 0.5, 0.9, 0.3)[seed], random.uniform(0.5, 1.5, shape), 1)[
        ..., None
    ]
    noise = np.kron(random.random((23, 24)), np.ones((10, 10))) + random.random(shape) * (0, 0.1, 0.6, 0.3)[seed]
    outside = noise > np.quantile(noise, (0.7, 0.6, 0.9, 0.98)[seed])
    color = {"white": (255,) * 3, "black": (0,) * 3, "grey": (128,) * 3, "#00ff00": (0, 255, 0)}.get(
        background, (9, 9, 9)
    )
    pixels = rounded(codes_of(vectors))
    pixels[outside] = color
    channels = ("R", "G", "B")
    if background == "alpha":
        alpha = np.where(outside, random.choice([0, 2, 120], shape), 255).astype(np.uint8)
        pixels, channels = np.dstack([pixels, alpha]), ("R", "G", "B", "A")
    options, decoding = settled(background_color=background), nm.Decoding()
    whole = decode_window(picture(pixels, channels), options, decoding)
    assert 0.01 < (whole.coverage < 1).mean() < 0.99
    for window in windows_of(*shape, 25, seed):
        around = tuple(slice(max(0, part.start - WINDOW_MARGIN_PX), part.stop + WINDOW_MARGIN_PX) for part in window)
        part = decode_window(picture(pixels[around], channels), options, decoding)
        inner = tuple(
            slice(one.start - out.start, one.stop - out.start) for one, out in zip(window, around, strict=True)
        )
        assert np.array_equal(part.normals[inner], whole.normals[window])
        assert np.array_equal(part.coverage[inner], whole.coverage[window])


def test_the_margin_is_stated():
    assert WINDOW_MARGIN_PX == 42


def test_a_patch_of_the_background_counts_from_16_pixels_on():
    n, _ = surface()
    pixels = rounded(codes_of(n))
    pixels[50:53, 50:55] = 255
    pixels[100:104, 100:104] = 255
    part = decode_window(picture(pixels), settled(background_color="white"), nm.Decoding())
    assert (part.coverage[50:53, 50:55] == 1).all()
    assert (part.coverage[100:104, 100:104] == 0).all()


@pytest.mark.usefixtures("small_sample")
def test_a_small_motif_on_a_large_background_is_found(tmp_path):
    """No window of a regular grid shows the motif; green is down."""
    n, coverage = surface(96, 96)
    motif = rounded(on_color(codes_of(n * (1, -1, 1)), coverage, (255, 255, 255)))
    pixels = np.full((420, 400, 3), 255, np.uint8)
    pixels[60:156, 220:316] = motif
    whole = nm.decode_normal_map(picture(pixels))
    store = open_normal_map(as_zarr(picture(pixels), tmp_path / "map.zarr"))
    assert (store.decoding.green, store.decoding.green_from) == ("down", "found") == (whole.decoding.green, "found")
    assert store.settled.background_color == "white"


@pytest.mark.usefixtures("small_sample")
def test_a_flat_background_is_one_warning_with_a_remedy(tmp_path):
    n, coverage = surface()
    n[coverage < 1] = 0, 0, 1
    name = as_zarr(picture(rounded(codes_of(n, 8, "128"))), tmp_path / "map.zarr")
    store = open_normal_map(name)
    (warning,) = store.decoding.warnings
    assert warning == (
        "its edges look like a flat background, which is read as surface, because a large map is read by windows; give "
        "a mask of the motif, or use `background_color='none'` if the flat area belongs to the surface"
    )
    assert store.settled.background_color == "none"
    assert store.window(slice(None), slice(None)).coverage.all()
    with pytest.raises(UsageError, match=r"`background_color='flat'`: needs the whole picture"):
        open_normal_map(name, nm.ReadOptions(background_color="flat"))


@pytest.mark.usefixtures("small_sample")
def test_a_background_that_the_sample_lacks_is_a_warning_and_is_still_read(tmp_path):
    n, _ = surface()
    pixels = rounded(codes_of(n))
    pixels[52:58, 46:52] = 255
    store = open_normal_map(as_zarr(picture(pixels), tmp_path / "map.zarr"), nm.ReadOptions(background_color="white"))
    assert (store.window(slice(52, 58), slice(46, 52)).coverage == 0).all()
    store = open_normal_map(store.name, nm.ReadOptions(background_color="black"))
    (warning,) = store.decoding.warnings
    assert warning == (
        "no background that is black shows in the windows that were looked at; check its colour; if there is none, use "
        "`background_color='none'`"
    )


@pytest.mark.usefixtures("small_sample")
def test_green_follows_the_original_unless_it_is_stated(tmp_path):
    image, _ = ENCODINGS["8 bits"]
    down = open_normal_map(as_zarr(ENCODINGS["green down"][0], tmp_path / "down.zarr"))
    plain = as_zarr(image, tmp_path / "plain.zarr")
    assert open_normal_map(plain, like=down).settled.green == "down"
    stated = as_zarr(replace(image, attributes={"green": "up"}), tmp_path / "stated.zarr")
    assert open_normal_map(stated, like=down).settled.green == "up"


@pytest.mark.usefixtures("small_sample")
def test_nan_is_refused_with_its_place_in_the_map_unless_it_is_transparent(tmp_path):
    image, _ = ENCODINGS["signed alpha"]
    pixels = image.pixels.copy()
    pixels[0, 0, 0] = np.nan
    assert pixels[0, 0, 3] == 0
    store = open_normal_map(as_zarr(picture(pixels, image.channels), tmp_path / "clear.zarr"))
    assert store.window(slice(0, 20), slice(0, 20)).coverage[0, 0] == 0
    row, col = unseen_place(store.name)
    pixels[row, col, 1] = np.inf
    store = open_normal_map(as_zarr(picture(pixels, image.channels), tmp_path / "bad.zarr"))
    told = f"1 pixel with NaN or infinite values, the first at x={col}, y={row}"
    with pytest.raises(InputError, match=told):
        store.window(slice(row - 5, row + 5), slice(col - 5, col + 5))
    pixels[ROWS - 3, 100, 1] = np.nan
    pixels[ROWS - 3, 100, 3] = 1
    with pytest.raises(InputError, match=f"1 pixel with NaN or infinite values, the first at x=100, y={ROWS - 3}"):
        open_normal_map(as_zarr(picture(pixels, image.channels), tmp_path / "sampled.zarr"))


@pytest.mark.usefixtures("small_sample")
@pytest.mark.parametrize("name", ["8 in 16 bits", "8 times 256", "8 bits in floats"])
def test_finer_values_than_the_sample_has_are_refused(tmp_path, name):
    image, _ = ENCODINGS[name]
    pixels = image.pixels.copy()
    row, col = unseen_place(as_zarr(image, tmp_path / "sound.zarr"))
    pixels[row, col, 0] += np.asarray(0.3 / 255 if image.is_float else 1, pixels.dtype)
    store = open_normal_map(as_zarr(picture(pixels), tmp_path / "map.zarr"))
    assert store.settled.narrowed_by
    with pytest.raises(InputError, match=r"holds 8-bit codes in .* in some places and finer values in others"):
        store.window(slice(row - 5, row + 5), slice(col - 5, col + 5))


def test_options_with_open_decisions_are_refused(tmp_path):
    name = as_zarr(ENCODINGS["8 bits"][0], tmp_path / "map.zarr")
    with pytest.raises(UsageError, match="these options leave decisions open"):
        reopen_normal_map(name, nm.ReadOptions())


@pytest.mark.usefixtures("small_sample")
def test_a_map_that_faces_away_is_refused(tmp_path):
    n, _ = surface()
    name = as_zarr(picture(rounded(codes_of(-n))), tmp_path / "map.zarr")
    with pytest.raises(InputError, match="of the motif faces away from the viewer"):
        open_normal_map(name)
    assert open_normal_map(name, nm.ReadOptions(force=True)).rows == ROWS
