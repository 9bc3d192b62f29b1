"""Codes to normals and back: files lose at most half a code."""

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.maps.codec import encode_codes, parse_swizzle
from nmaptool.maps.zero_code import detect_zero_code

BACKDROPS = {"white": (1, 1, 1), "black": (-1, -1, -1), "grey": (0, 0, 0), "flat": (0, 0, 1)}
FORMATS = [
    (".png", {"bits": "8"}, 1 / 255),
    (".png", {"bits": "16"}, 1 / 65535),
    (".tif", {"bits": "8"}, 1 / 255),
    (".tif", {"bits": "16"}, 1 / 65535),
    (".tif", {"bits": "float"}, 0.0),
    (".exr", {}, 0.0),
    (".exr", {"bits": "half"}, 2**-12),
]


def name_of(case):
    return f"{case[0][1:]}-{'-'.join(str(v) for v in case[1].values())}"


@pytest.fixture(params=FORMATS, ids=name_of)
def form(request):
    return request.param


def random_normals(seed, rows=40, cols=50, lowest=-0.2):
    """Random unit normals; no two pixels are alike, so nothing looks like a background."""
    rng = np.random.default_rng(seed)
    vectors = rng.normal(size=(rows, cols, 3))
    vectors[..., 2] = np.abs(vectors[..., 2]) + lowest
    return nm_unit(vectors)


def nm_unit(vectors):
    return (vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)).astype(np.float32)


def as_map(normals, coverage=None, pitch_mm=None):
    shape = normals.shape[:2]
    coverage = np.ones(shape, np.float32) if coverage is None else coverage.astype(np.float32)
    return nm.NormalMap(normals, coverage, nm.Frame(*shape, pitch_mm))


def round_trip(path, normal_map, **how):
    nm.write_normal_map(normal_map, path, nm.WriteOptions(**how))
    return nm.read_normal_map(path)


def test_stored_components_are_exact_within_half_a_code(tmp_path, form):
    ending, how, step = form
    normals = random_normals(1)
    path = tmp_path / f"map{ending}"
    nm.write_normal_map(as_map(normals), path, nm.WriteOptions(**how))
    image = nm.read_raster(path)
    stored = image.pixels[..., :3].astype(np.float64)
    if not image.is_float:
        stored = stored * 2 / image.max_code - 1
    assert np.abs(stored - normals).max() <= step * (1 + 1e-6)


def test_normals_read_back_are_exact_within_half_a_code(tmp_path, form):
    ending, how, step = form
    normals = random_normals(2)
    back = round_trip(tmp_path / f"map{ending}", as_map(normals), **how).normals
    # normalising turns half a code in each of three components into at most sqrt(3) of it
    assert np.abs(back - normals).max() <= np.sqrt(3) * step * (1 + 1e-3)
    if step == 0:
        assert np.array_equal(back, normals)


def test_flat_stays_exactly_flat(tmp_path, form):
    ending, how, _ = form
    normals = random_normals(3)
    normals[5:30, 10:40] = (0, 0, 1)
    back = round_trip(tmp_path / f"map{ending}", as_map(normals), **how).normals
    assert np.array_equal(back[5:30, 10:40], np.broadcast_to(np.float32([0, 0, 1]), (25, 30, 3)))
    assert not np.signbit(back[5:30, 10:40]).any()


def test_an_all_flat_map_is_exactly_flat(tmp_path, form):
    ending, how, _ = form
    flat = np.zeros((12, 9, 3), np.float32)
    flat[..., 2] = 1
    back = round_trip(tmp_path / f"map{ending}", as_map(flat), **how)
    assert np.array_equal(back.normals, flat)
    assert (back.coverage == 1).all()


def test_partial_coverage_survives(tmp_path, form):
    ending, how, step = form
    rng = np.random.default_rng(4)
    coverage = np.ones((40, 50), np.float32)
    coverage[:, :10] = 0
    coverage[:, 10:14] = rng.uniform(0.05, 0.95, (40, 4))
    normals = random_normals(4)
    normals[coverage == 0] = (0, 0, 1)
    back = round_trip(tmp_path / f"map{ending}", as_map(normals, coverage), **how)
    assert back.decoding.background == "alpha"
    assert np.abs(back.coverage - coverage).max() <= max(step / 2, 2**-12 if how.get("bits") == "half" else 0) * (
        1 + 1e-3
    )
    covered = coverage > 0.02
    assert np.abs(back.normals - normals)[covered].max() <= np.sqrt(3) * step * (1 + 1e-3)
    assert np.array_equal(back.normals[~covered], normals[~covered])


@pytest.mark.parametrize("ending", [".png", ".exr"])
def test_coverage_that_is_soft_everywhere_survives_in_our_own_files(tmp_path, ending):
    coverage = np.linspace(0.1, 0.9, 2000).reshape(40, 50)
    back = round_trip(tmp_path / f"map{ending}", as_map(random_normals(5), coverage))
    assert np.abs(back.coverage - coverage).max() <= 1e-5


def test_a_layer_is_not_multiplied_by_its_partial_alpha(tmp_path, form):
    ending, how, step = form
    coverage = np.ones((40, 50))
    coverage[::7] = 0.25
    path = tmp_path / f"map{ending}"
    nm.write_normal_map(as_map(random_normals(6), coverage), path, nm.WriteOptions(**how))
    image = nm.read_raster(path)
    stored = image.pixels[..., :3].astype(np.float64)
    stored = stored if image.is_float else stored * 2 / image.max_code - 1
    assert np.abs(stored - random_normals(6)).max() <= step * (1 + 1e-6)


def test_the_file_holds_pitch_and_convention(tmp_path, form):
    ending, how, _ = form
    back = round_trip(tmp_path / f"map{ending}", as_map(random_normals(7), pitch_mm=0.1234567), **how)
    assert back.frame.pitch_mm == 0.1234567
    assert (back.decoding.green, back.decoding.green_from) == ("up", "file")


def test_written_png_files_have_no_colour_management(tmp_path):
    nm.write_normal_map(as_map(random_normals(8)), tmp_path / "map.png")
    data = (tmp_path / "map.png").read_bytes()
    assert not [kind for kind in (b"sRGB", b"gAMA", b"cHRM", b"iCCP", b"cICP") if kind in data]


def test_encoding_rounds_and_clips():
    vectors = np.float32([[[0, -1, 1], [1.5, -1.5, 1 / 255]]])
    assert encode_codes(vectors, 8).tolist() == [[[128, 0, 255], [255, 0, 128]]]
    assert encode_codes(vectors, 16).tolist() == [[[32768, 0, 65535], [65535, 0, 32896]]]


def test_bit_depths_that_a_format_lacks_are_refused(tmp_path):
    for ending, bits, offered in (
        (".png", "float", "16 or 8"),
        (".exr", "8", "float or half"),
        (".tif", "half", "16 or 8"),
    ):
        with pytest.raises(nm.UsageError, match=rf"`bits={bits!r}` is not supported for {ending}; use {offered}"):
            nm.write_normal_map(as_map(random_normals(9)), tmp_path / f"map{ending}", nm.WriteOptions(bits=bits))
    with pytest.raises(nm.UsageError, match="`bits='12'`: use one of auto, 8, 16, half, float"):
        nm.WriteOptions(bits="12")
    with pytest.raises(nm.UsageError, match=r"ends in \.jpg; normal maps are written as \.png, \.exr, \.tif"):
        nm.write_normal_map(as_map(random_normals(9)), tmp_path / "map.jpg")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("code", [127, 128])
@pytest.mark.parametrize("bits", [8, 16])
def test_the_zero_code_is_found_from_flat_pixels(tmp_path, dome, codes, png, code, bits):
    d = dome()
    pixels = codes(d.normals, bits)
    flat = (code, code, 255) if bits == 8 else (code + 32640, code + 32640, 65535)
    pixels[30:60, 30:60] = flat
    back = nm.read_normal_map(png(tmp_path / "map.png", pixels))
    assert (back.decoding.zero_code, back.decoding.zero_code_from) == (str(code), "found")
    assert np.array_equal(np.unique(back.normals[30:60, 30:60].reshape(-1, 3), axis=0), [[0, 0, 1]])


@pytest.mark.parametrize("bits", [8, 16])
def test_without_flat_pixels_the_zero_code_is_the_middle(tmp_path, codes, png, bits):
    normals = random_normals(10)
    back = nm.read_normal_map(png(tmp_path / "map.png", codes(normals, bits)))
    assert (back.decoding.zero_code, back.decoding.zero_code_from) == ("127.5", "assumed")
    assert np.abs(back.normals - normals).max() <= np.sqrt(3) / (2**bits - 1)


def test_a_surface_that_only_passes_through_flat_has_no_zero_code():
    x = np.linspace(-0.03, 0.03, 200)
    p, q = np.meshgrid(x, x)
    assert detect_zero_code(encode_codes(nm_unit(np.dstack([p, q, np.ones_like(p)])), 8)) is None


@pytest.mark.parametrize("given", ["127", "127.5", "128"])
def test_a_given_zero_code_is_used(tmp_path, codes, png, given):
    pixels = codes(random_normals(11))
    pixels[20, 20] = (128, 200, 200)
    found = nm.read_normal_map(png(tmp_path / "map.png", pixels), nm.ReadOptions(zero_code=given))
    assert found.decoding.zero_code_from == "given"
    x, y, z = found.normals[20, 20]
    zero = float(given)
    assert x / z == pytest.approx((128 - zero) / (200 - zero), abs=1e-6)
    assert y == z


def test_codes_rounded_down_do_not_tilt_once_the_zero_code_is_known(tmp_path, dome, png):
    d = dome(120, 120)
    vectors = np.where(d.inside[..., None], d.normals, (0, 0, 1))
    pixels = np.floor((vectors + 1) / 2 * 255).astype(np.uint8)  # as careless programs write
    assert tuple(pixels[0, 0]) == (127, 127, 255)
    found = nm.read_normal_map(png(tmp_path / "map.png", pixels))
    assert found.decoding.zero_code == "127"
    tilted = nm.read_normal_map(tmp_path / "map.png", nm.ReadOptions(zero_code="127.5"))
    true = d.normals[d.inside]
    assert np.abs((found.normals[d.inside] - true).mean(axis=0)).max() < 5e-4
    assert (tilted.normals[d.inside] - true).mean(axis=0)[:2] == pytest.approx([-0.5 / 127.5] * 2, abs=1e-3)


@pytest.mark.parametrize("swizzle", ["-g,r,b", "r,-g,b", "b,r,g", " G , -R , B ", "+r,+g,+b"])
def test_a_swizzle_restores_the_channels(tmp_path, codes, png, swizzle):
    normals = random_normals(12)
    stored = np.empty_like(normals)
    for axis, (channel, sign) in enumerate(parse_swizzle(swizzle)):
        stored[..., channel] = sign * normals[..., axis]
    path = png(tmp_path / "map.png", codes(stored, 16))
    back = nm.read_normal_map(path, nm.ReadOptions(swizzle=swizzle))
    assert np.abs(back.normals - normals).max() <= np.sqrt(3) / 65535


@pytest.mark.parametrize("text", ["r,g", "r,g,g", "x,y,z", "", "r g b", "--r,g,b", "r,g,b,a"])
def test_an_invalid_swizzle_is_refused(tmp_path, codes, png, text):
    path = png(tmp_path / "map.png", codes(random_normals(13)))
    with pytest.raises(nm.UsageError, match=r"`swizzle=.*such as r,g,b or -g,r,b"):
        nm.decode_normal_map(nm.read_raster(path), nm.ReadOptions(swizzle=text))


@pytest.mark.parametrize("wrong", [{"green": "sideways"}, {"zero_code": "5"}, {"encoding": "odd"}])
def test_unknown_reading_options_are_refused(wrong):
    with pytest.raises(nm.UsageError, match=next(iter(wrong.values()))):
        nm.ReadOptions(**wrong)


@pytest.mark.parametrize("down", [False, True])
def test_the_green_direction_is_found_from_the_curl(tmp_path, dome, codes, png, down):
    d = dome(bump=0.4)
    normals = d.normals * ([1, -1, 1] if down else [1, 1, 1])
    back = nm.read_normal_map(png(tmp_path / "map.png", codes(normals, 16)))
    assert (back.decoding.green, back.decoding.green_from) == ("down" if down else "up", "found")
    assert np.abs(back.normals - d.normals).max() <= np.sqrt(3) / 65535


def test_a_given_green_direction_wins(tmp_path, dome, codes, png):
    d = dome(bump=0.4)
    path = png(tmp_path / "map.png", codes(d.normals, 16))
    back = nm.read_normal_map(path, nm.ReadOptions(green="down"))
    assert back.decoding.green_from == "given"
    assert np.abs(back.normals - d.normals * [1, -1, 1]).max() <= np.sqrt(3) / 65535


def test_the_green_direction_of_a_nearly_flat_map_is_not_guessed(tmp_path, codes, png):
    # slopes of half a code: any curl comes from rounding
    x = np.linspace(0, 4, 64)
    p, q = np.meshgrid(0.004 * np.sin(x), 0.004 * np.cos(x))
    back = nm.read_normal_map(png(tmp_path / "map.png", codes(nm_unit(np.dstack([p, q, np.ones_like(p)])))))
    assert (back.decoding.green, back.decoding.green_from) == ("up", "assumed")


@pytest.mark.parametrize("ending", [".exr", ".tif"])
@pytest.mark.parametrize("backdrop", [None, "white", "black", "grey", "flat"])
def test_floats_from_0_to_1_are_recognised(tmp_path, dome, picture, ending, backdrop):
    d = dome()
    vectors = d.normals if backdrop is None else np.where(d.inside[..., None], d.normals, BACKDROPS[backdrop])
    path = picture(tmp_path / f"map{ending}", (vectors + 1) / 2)
    back = nm.read_normal_map(path)
    assert back.decoding.encoding == "unsigned"
    assert back.decoding.background == (backdrop or "none")
    assert np.abs(back.normals - d.normals)[d.inside].max() < 1e-6


@pytest.mark.parametrize("backdrop", ["white", "black", "grey"])
def test_unsigned_floats_are_recognised_despite_a_small_motif(tmp_path, dome, picture, backdrop):
    d = dome()
    vectors = np.full((240, 240, 3), BACKDROPS[backdrop], float)
    vectors[60:156, 60:156][d.inside] = d.normals[d.inside]
    back = nm.read_normal_map(picture(tmp_path / "map.exr", (vectors + 1) / 2))
    assert back.decoding.encoding == "unsigned"
    assert np.abs(back.normals[60:156, 60:156] - d.normals)[d.inside].max() < 1e-6


def test_signed_floats_are_recognised_and_a_given_encoding_wins(tmp_path, dome, picture):
    d = dome()
    path = picture(tmp_path / "map.exr", d.normals)
    assert nm.read_normal_map(path).decoding.encoding == "signed"
    other = nm.read_normal_map(path, nm.ReadOptions(encoding="unsigned"))
    assert other.decoding.encoding == "unsigned"
    wanted = nm_unit(2 * d.normals - 1)
    assert np.abs(other.normals - wanted).max() < 1e-5
