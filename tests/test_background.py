"""The background of a motif: recognised, reported, overridden, and removed from the anti-aliased rim."""

import numpy as np
import pytest

import nmaptool as nm

KINDS = ["white", "grey", "black", "flat"]


def angle_deg(a, b):
    return np.degrees(np.arccos(np.clip((a * b).sum(axis=-1), -1, 1)))


def rim_of(d):
    return (d.cover > 0) & (d.cover < 1)


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("kind", KINDS)
def test_a_background_is_recognised(tmp_path, dome, codes, png, kind, bits):
    d = dome()
    back = nm.read_normal_map(png(tmp_path / "map.png", codes(d.normals, bits, kind, d.cover)))
    assert (back.decoding.background, back.decoding.background_from) == (kind, "found")
    # only where the surface itself looks like the background could it be mistaken for it
    assert np.array_equal(back.foreground, d.inside)
    assert np.array_equal(back.normals[~d.inside], np.broadcast_to(np.float32([0, 0, 1]), (int((~d.inside).sum()), 3)))
    assert (back.coverage[~d.inside] == (1 if kind == "flat" else 0)).all()
    assert (back.coverage[d.inside] == 1).all()


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("behind", ["white", "black", "flat"])
def test_alpha_takes_precedence_over_colour(tmp_path, dome, codes, png, bits, behind):
    d = dome()
    alpha = (d.inside * (2**bits - 1)).astype(np.uint8 if bits == 8 else np.uint16)
    pixels = np.dstack([codes(d.normals, bits, behind, d.cover), alpha])
    back = nm.read_normal_map(png(tmp_path / "map.png", pixels))
    assert back.decoding.background == "alpha"
    assert np.array_equal(back.coverage, d.inside.astype(np.float32))


@pytest.mark.parametrize("kind", KINDS)
def test_an_opaque_alpha_does_not_hide_a_background(tmp_path, dome, codes, png, kind):
    d = dome()
    pixels = np.dstack([codes(d.normals, 8, kind, d.cover), np.full((96, 96), 255, np.uint8)])
    back = nm.read_normal_map(png(tmp_path / "map.png", pixels))
    assert back.decoding.background == kind
    assert np.array_equal(back.foreground, d.inside)


@pytest.mark.parametrize("code", [127, 128])
def test_both_greys_and_both_flat_colours_are_recognised(tmp_path, dome, codes, png, code):
    d = dome()
    for kind, blue in (("grey", code), ("flat", 255)):
        pixels = codes(d.normals)
        pixels[~d.inside] = (code, code, blue)
        eight = nm.read_normal_map(png(tmp_path / "eight.png", pixels))
        widened = nm.read_normal_map(png(tmp_path / "sixteen.png", pixels.astype(np.uint16) * 257))
        for back in (eight, widened):
            assert back.decoding.background == kind
            assert np.array_equal(back.foreground, d.inside)


@pytest.mark.parametrize(("kind", "stored"), [("white", (1, 1, 1)), ("black", (0, 0, 0)), ("flat", (0, 0, 1))])
def test_a_background_is_recognised_in_signed_exr(tmp_path, dome, picture, kind, stored):
    d = dome()
    path = picture(tmp_path / "map.exr", np.where(d.inside[..., None], d.normals, stored))
    back = nm.read_normal_map(path)
    assert (back.decoding.background, back.decoding.encoding) == (kind, "signed")
    assert np.array_equal(back.foreground, d.inside)


@pytest.mark.parametrize("stored", ["float", "half"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_background_is_recognised_in_floats_that_were_8_bit_codes(tmp_path, dome, codes, picture, kind, stored):
    d = dome()
    path = picture(tmp_path / "map.exr", codes(d.normals, 8, kind, d.cover) / 255, stored=stored)
    back = nm.read_normal_map(path)
    assert (back.decoding.background, back.decoding.encoding) == (kind, "unsigned")
    assert np.array_equal(back.foreground, d.inside)


@pytest.mark.parametrize("kind", ["white", "black"])
def test_a_background_is_recognised_in_jpeg(tmp_path, dome, codes, picture, kind):
    d = dome()
    path = picture(tmp_path / "map.jpg", codes(d.normals, 8, kind, d.cover), CompressionQuality=92)
    back = nm.read_normal_map(path)
    assert back.decoding.background == kind
    assert (back.foreground != d.inside).mean() < 0.02
    deep = d.inside & (d.cover == 1)
    assert np.percentile(angle_deg(back.normals, d.normals)[deep], 90) < 6


def test_a_texture_that_is_surface_everywhere_has_no_background(tmp_path, codes, png):
    y, x = np.mgrid[0:96, 0:96] * 0.4
    p, q = 0.8 * np.cos(x) * np.cos(y), 0.8 * np.sin(x) * np.sin(y)
    normals = np.dstack([-p, -q, np.ones_like(p)])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    for bits in (8, 16):
        back = nm.read_normal_map(png(tmp_path / f"{bits}.png", codes(normals, bits)))
        assert back.decoding.background == "none"
        assert back.foreground.all()
        assert (back.coverage == 1).all()


def test_a_flat_plateau_inside_the_motif_is_motif(tmp_path, dome, codes, png):
    d = dome()
    vectors = np.where(d.inside[..., None], d.normals, (0, 0, 1))
    vectors[40:56, 40:56] = (0, 0, 1)
    back = nm.read_normal_map(png(tmp_path / "map.png", codes(vectors)))
    assert back.decoding.background == "flat"
    assert back.foreground[40:56, 40:56].all()
    assert np.array_equal(back.foreground, d.inside)


@pytest.mark.parametrize("kind", ["white", "grey", "black"])
def test_a_flat_plateau_on_white_grey_or_black_is_motif(tmp_path, dome, codes, png, kind):
    d = dome()
    vectors = d.normals.copy()
    vectors[24:72, 24:72] = (0, 0, 1)
    back = nm.read_normal_map(png(tmp_path / "map.png", codes(vectors, 8, kind, d.cover)))
    assert back.decoding.background == kind
    assert np.array_equal(back.foreground, d.inside)


@pytest.mark.parametrize("kind", ["white", "black"])
def test_a_hole_inside_the_motif_is_background(tmp_path, dome, codes, png, kind):
    d = dome()
    cover = d.cover.copy()
    cover[40:56, 40:56] = 0
    back = nm.read_normal_map(png(tmp_path / "map.png", codes(d.normals, 8, kind, cover)))
    assert np.array_equal(back.foreground, cover > 0)


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("kind", ["white", "grey", "black"])
def test_an_anti_aliased_rim_is_repaired(tmp_path, dome, codes, png, kind, bits):
    d = dome(128, 128, smooth=True)
    back = nm.read_normal_map(png(tmp_path / "map.png", codes(d.normals, bits, kind, d.cover)))
    assert back.decoding.background == kind
    assert back.decoding.rim_pixels > 0
    # the true normals turn by up to 4 degrees per pixel here, and the rim takes them from one or two pixels inside
    assert angle_deg(back.normals, d.normals)[d.cover >= 0.5].max() < 12
    assert np.abs(back.coverage - d.cover)[rim_of(d)].mean() < 0.05
    assert np.abs(back.coverage - d.cover).max() < 0.25
    clear = np.abs(d.cover - 0.5) > 0.03
    assert (back.foreground != (d.cover >= 0.5))[clear].sum() <= 0.01 * rim_of(d).sum()


def test_a_rim_with_straight_alpha_keeps_its_coverage(tmp_path, dome, codes, png):
    d = dome(128, 128, smooth=True)
    alpha = np.floor(d.cover * 65535 + 0.5).astype(np.uint16)
    back = nm.read_normal_map(png(tmp_path / "map.png", np.dstack([codes(d.normals, 16), alpha])))
    assert np.abs(back.coverage - d.cover).max() < 1e-4
    assert np.abs(back.normals - d.normals)[d.cover > 0].max() < 1e-4


def test_a_rim_whose_colours_fade_to_black_with_alpha_is_mostly_repaired(tmp_path, dome, codes, png):
    d = dome(128, 128, smooth=True)
    alpha = np.floor(d.cover * 255 + 0.5).astype(np.uint8)
    pixels = np.dstack([codes(d.normals, 8, "black", d.cover), alpha])
    back = nm.read_normal_map(png(tmp_path / "map.png", pixels))
    assert np.abs(back.coverage - d.cover).max() < 0.01
    assert np.percentile(angle_deg(back.normals, d.normals)[rim_of(d) & (d.cover >= 0.5)], 85) < 12


@pytest.mark.parametrize("bits", [8, 16])
def test_alpha_that_is_a_height_is_ignored_with_a_warning(tmp_path, dome, codes, png, bits):
    d = dome()
    y, x = np.mgrid[0:96, 0:96] / 95
    height = ((0.2 + 0.3 * x + 0.4 * y * x) * (2**bits - 1)).astype(np.uint8 if bits == 8 else np.uint16)
    back = nm.read_normal_map(png(tmp_path / "map.png", np.dstack([codes(d.normals, bits), height])))
    assert back.decoding.background == "none"
    assert (back.coverage == 1).all()
    (warning,) = back.decoding.warnings
    assert "alpha looks like data" in warning
    taken = nm.read_normal_map(tmp_path / "map.png", nm.ReadOptions(background_color="alpha"))
    assert taken.decoding.warnings == ()
    assert np.abs(taken.coverage - height / (2**bits - 1)).max() < 1e-4


@pytest.mark.parametrize("kind", KINDS)
def test_a_background_can_be_named(tmp_path, dome, codes, png, kind):
    d = dome()
    path = png(tmp_path / "map.png", codes(d.normals, 8, kind, d.cover))
    named = nm.read_normal_map(path, nm.ReadOptions(background_color=kind))
    assert (named.decoding.background, named.decoding.background_from) == (kind, "given")
    assert np.array_equal(named.foreground, d.inside)
    none = nm.read_normal_map(path, nm.ReadOptions(background_color="none"))
    assert (none.decoding.background, none.foreground.all()) == ("none", True)


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("swizzle", [None, "-g,r,b"])
def test_a_background_can_be_given_by_its_colour(tmp_path, dome, codes, png, bits, swizzle):
    d = dome()
    pixels = codes(d.normals, bits)
    pixels[~d.inside] = np.array((0x20, 0xC0, 0x40)) * (1 if bits == 8 else 257)
    path = png(tmp_path / "map.png", pixels)
    assert nm.read_normal_map(path).foreground.all()
    back = nm.read_normal_map(path, nm.ReadOptions(background_color="#20C040", swizzle=swizzle))
    assert back.decoding.background == "#20C040"
    assert np.array_equal(back.foreground, d.inside)
    assert (back.coverage[~d.inside] == 0).all()


@pytest.mark.parametrize("wanted", ["white", "alpha", "#20c040"])
def test_a_given_background_that_is_missing_is_reported(tmp_path, dome, codes, png, wanted):
    d = dome()
    path = png(tmp_path / "map.png", codes(d.normals))
    try:
        words = nm.read_normal_map(path, nm.ReadOptions(background_color=wanted)).decoding.warnings
    except nm.InputError as error:
        words = (str(error),)
    assert [word for word in words if wanted in word]


@pytest.mark.parametrize("wanted", ["pink", "", "#12345", "#12345g", "White"])
def test_an_invalid_background_colour_is_refused(wanted):
    with pytest.raises(nm.UsageError, match=r"`background_color=.*use one of auto, none, alpha, white.*#7f7fff"):
        nm.ReadOptions(background_color=wanted)


def on_backdrop(vectors, cover, color, bits=8):
    top = 2**bits - 1
    stored = np.floor((vectors + 1) / 2 * top + 0.5)
    stored[~cover] = np.array(color) * (top // 255)
    return stored


@pytest.mark.parametrize(
    ("color", "kind"), [((254, 254, 254), "white"), ((2, 1, 0), "black"), ((129, 126, 128), "grey")]
)
@pytest.mark.parametrize("bits", [8, 16])
def test_a_background_colour_may_be_slightly_off(tmp_path, dome, png, color, kind, bits):
    d = dome(128, 128)
    pixels = on_backdrop(d.normals, d.inside, color, bits).astype(np.uint8 if bits == 8 else np.uint16)
    back = nm.read_normal_map(png(tmp_path / "map.png", pixels))
    assert back.decoding.background == kind
    assert np.array_equal(back.foreground, d.inside)


@pytest.mark.parametrize("noise", [1, 2])
@pytest.mark.parametrize("color", [(128, 128, 254), (253, 253, 253)])
def test_a_noisy_background_is_recognised(tmp_path, dome, png, color, noise):
    d = dome(128, 128)
    pixels = on_backdrop(d.normals, d.inside, color)
    pixels[~d.inside] += np.random.default_rng(0).integers(-noise, noise + 1, (int((~d.inside).sum()), 3))
    back = nm.read_normal_map(png(tmp_path / "map.png", pixels.clip(0, 255).astype(np.uint8)))
    assert back.decoding.background == ("flat" if color[0] == 128 else "white")
    # a few pixels of the rim may be assigned to either side
    assert (back.foreground != d.inside).mean() < 0.01


def test_a_shallow_surface_is_not_taken_for_noise(tmp_path, png):
    y, x = np.mgrid[0:128, 0:128] / 128
    slope = 0.004 * np.cos(5 * x + 3 * y)
    normals = np.dstack([slope, slope, np.sqrt(1 - 2 * slope**2)])
    pixels = np.floor((normals + 1) / 2 * 65535 + 0.5).astype(np.uint16)
    assert nm.read_normal_map(png(tmp_path / "map.png", pixels)).decoding.background == "none"


def test_a_colour_that_is_not_a_normal_is_background_and_one_that_may_be_is_a_warning(tmp_path, dome, png):
    d = dome(128, 128)
    for color, background in (((90, 90, 90), "#5a5a5a"), ((200, 200, 200), "none")):
        pixels = on_backdrop(d.normals, d.inside, color).astype(np.uint8)
        back = nm.read_normal_map(png(tmp_path / f"{color[0]}.png", pixels))
        assert back.decoding.background == background
    assert "is #c8c8c8; if that is the background, use `background_color='#c8c8c8'`" in back.decoding.warnings[0]


def test_flat_patches_cut_by_the_image_edge_are_not_background(tmp_path, png):
    y, x = np.mgrid[0:128, 0:128]
    p = 0.5 * np.sign(x % 32 - 16) * (np.abs(x % 32 - 16) < 3)
    q = 0.5 * np.sign(y % 32 - 16) * (np.abs(y % 32 - 16) < 3)
    normals = np.dstack([-p, -q, np.ones_like(p)]) / np.sqrt(1 + p**2 + q**2)[..., None]
    pixels = np.floor((normals + 1) / 2 * 255 + 0.5).astype(np.uint8)
    assert nm.read_normal_map(png(tmp_path / "tiles.png", pixels)).decoding.background == "none"
