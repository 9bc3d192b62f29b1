"""Maps with two components per pixel: x and y, octahedral codes, and an unusable blue channel."""

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.maps.two_channel import derive_z, unfold_octahedral

PAIRS = [("R", "G"), ("X", "Y"), ("N.X", "N.Y"), ("red", "green")]


def sphere(seed, shape=(40, 50)):
    vectors = np.random.default_rng(seed).normal(size=(*shape, 3))
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def facing(seed, shape=(40, 50), lowest=0.1):
    vectors = sphere(seed, shape)
    vectors[..., 2] = np.abs(vectors[..., 2]) + lowest
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def folded(vectors):
    """Octahedral codes by the published formula, the inverse of the tested function."""
    u, v, w = np.moveaxis(vectors / np.abs(vectors).sum(axis=-1, keepdims=True), -1, 0)
    signs = np.where(u >= 0, 1, -1), np.where(v >= 0, 1, -1)
    behind = w < 0
    return np.stack(
        [np.where(behind, (1 - np.abs(v)) * signs[0], u), np.where(behind, (1 - np.abs(u)) * signs[1], v)], axis=-1
    )


def angle_deg(first, second):
    return np.degrees(2 * np.arcsin(np.linalg.norm(first.astype(float) - second, axis=-1).clip(0, 2) / 2))


def test_z_is_computed_from_x_and_y():
    vectors = facing(1)
    assert np.abs(derive_z(vectors[..., :2]) - vectors).max() < 1e-6
    known = derive_z(np.array([[0, 0], [0.6, 0], [0, -0.8], [1, 0], [0.96, 0.72]]))
    assert np.allclose(known, [[0, 0, 1], [0.6, 0, 0.8], [0, -0.8, 0.6], [1, 0, 0], [0.96, 0.72, 0]], atol=1e-7)


def test_octahedral_codes_unfold_to_the_vectors_that_were_folded():
    vectors = sphere(2, (100, 100))
    assert np.abs(unfold_octahedral(folded(vectors)) - vectors).max() < 3e-7


def test_octant_borders_edges_and_corners_of_the_octahedron_are_exact():
    h = np.sqrt(0.5)
    known = {
        (0, 0): (0, 0, 1),
        (1, 0): (1, 0, 0),
        (-1, 0): (-1, 0, 0),
        (0, 1): (0, 1, 0),
        (0, -1): (0, -1, 0),
        (0.5, 0.5): (h, h, 0),
        (-0.5, 0.5): (-h, h, 0),
        (0.5, 0): (h, 0, h),
        (0, -0.5): (0, -h, h),
        (1, 0.5): (h, 0, -h),
        (0.5, 1): (0, h, -h),
        (-1, -0.5): (-h, 0, -h),
        (1, 1): (0, 0, -1),
        (-1, 1): (0, 0, -1),
        (1, -1): (0, 0, -1),
        (-1, -1): (0, 0, -1),
    }
    vectors = unfold_octahedral(np.array(list(known), float))
    assert np.abs(vectors - np.array(list(known.values()))).max() < 1e-7
    assert not np.signbit(vectors[vectors == 0]).any()
    t = np.linspace(-1, 1, 41)
    for axis in (0, 1):  # on the axes of the square, the other component is zero in front, and the fold is continuous
        codes = np.zeros((41, 2))
        codes[:, axis] = t
        assert (unfold_octahedral(codes)[:, 1 - axis] == 0).all()
    rim = np.stack([t, 1 - np.abs(t)], axis=-1)
    assert np.abs(unfold_octahedral(rim * (1 - 1e-9)) - unfold_octahedral(rim * (1 + 1e-9))).max() < 1e-6
    assert np.abs(unfold_octahedral(rim)[:, 2]).max() < 1e-7


def test_out_of_range_components_give_vectors_that_are_too_long():
    assert np.allclose(unfold_octahedral(np.array([1.5, 0.0])), (1.5, 0, 0))
    assert np.allclose(derive_z(np.array([0.9, 0.9])), (0.9, 0.9, 0))


@pytest.mark.parametrize("names", PAIRS, ids=".".join)
@pytest.mark.parametrize("unsigned", [False, True])
def test_two_channels_of_an_exr_are_x_and_y(tmp_path, picture, names, unsigned):
    normals = facing(3)
    stored = (normals[..., :2] + 1) / 2 if unsigned else normals[..., :2]
    back = nm.read_normal_map(picture(tmp_path / "map.exr", stored, names), nm.ReadOptions(green="up"))
    assert (back.decoding.components, back.decoding.components_from) == ("xy", "found")
    assert back.decoding.encoding == ("unsigned" if unsigned else "signed")
    assert angle_deg(back.normals, normals).max() < 1e-3


@pytest.mark.parametrize(("bits", "worst"), [(8, 2.0), (16, 0.01)])
def test_two_channels_of_a_tiff_are_x_and_y(tmp_path, codes, picture, bits, worst):
    normals = facing(4, lowest=0.5)
    path = picture(tmp_path / "map.tif", codes(normals, bits)[..., :2], ("R", "G"))
    back = nm.read_normal_map(path, nm.ReadOptions(green="up"))
    assert back.decoding.components == "xy"
    assert angle_deg(back.normals, normals).max() < worst


def test_two_channels_with_alpha_are_read(tmp_path, dome, picture):
    d = dome()
    stored = np.dstack([d.normals[..., :2], d.inside])
    back = nm.read_normal_map(picture(tmp_path / "map.exr", stored, ("N.X", "N.Y", "A")))
    assert back.decoding.background == "alpha"
    assert np.array_equal(back.coverage > 0.5, d.inside)
    assert np.abs(back.normals - d.normals)[d.inside].max() < 1e-6


def test_a_pair_beside_three_components_is_read_only_by_name(tmp_path, picture):
    normals = facing(5)
    names = ("R", "G", "B", "N.X", "N.Y")
    path = picture(tmp_path / "map.exr", np.dstack([normals, -normals[..., :2]]), names)
    assert np.abs(nm.read_normal_map(path, nm.ReadOptions(green="up")).normals - normals).max() < 1e-6
    named = nm.read_normal_map(f"{path}:N", nm.ReadOptions(green="up"))
    assert named.decoding.components == "xy"
    assert np.abs(named.normals[..., :2] + normals[..., :2]).max() < 1e-6


def test_grey_and_alpha_are_x_and_y_only_on_request(tmp_path, codes, png):
    normals = facing(6)
    path = png(tmp_path / "map.png", codes(normals, 16)[..., :2])
    told = r"needs red, green and blue;.*if the two are x and y, use `components='xy'`"
    with pytest.raises(nm.InputError, match=told):
        nm.read_normal_map(path)
    back = nm.read_normal_map(path, nm.ReadOptions(components="xy", green="up"))
    assert angle_deg(back.normals, normals).max() < 0.05
    assert (back.coverage == 1).all()


@pytest.mark.parametrize("blue", [0, 255])
@pytest.mark.parametrize("bits", [8, 16])
def test_a_constant_blue_that_cannot_be_z_is_ignored(tmp_path, dome, codes, png, blue, bits):
    d = dome()
    pixels = codes(d.normals, bits)
    pixels[..., 2] = blue * (1 if bits == 8 else 257)
    alpha = np.where(d.inside, pixels.dtype.type(2**bits - 1), 0).astype(pixels.dtype)
    for stored in (pixels, np.dstack([pixels, alpha])):
        back = nm.read_normal_map(png(tmp_path / "map.png", stored))
        assert (back.decoding.components, back.decoding.components_from) == ("xy", "found")
        assert back.decoding.green == "up"
        assert angle_deg(back.normals, d.normals)[d.inside].mean() < (0.4 if bits == 8 else 0.002)
    stated = nm.read_normal_map(tmp_path / "map.png", nm.ReadOptions(components="xyz", force=True))
    assert stated.decoding.components == "xyz"
    if blue == 255:  # z is 1 everywhere
        return
    with pytest.raises(nm.InputError, match=r"map.png: \d+% of the motif faces away .* or go on with `force`"):
        nm.read_normal_map(tmp_path / "map.png", nm.ReadOptions(components="xyz"))


def test_a_constant_blue_that_is_z_is_kept(tmp_path, codes, png):
    y, x = np.mgrid[0:64, 0:64] - 31.6
    round_ = np.dstack([x, y, np.hypot(x, y)]) / np.hypot(x, y)[..., None] / np.sqrt(2)  # a cone
    shallow = np.dstack([0.05 * np.cos(x), 0.05 * np.sin(y), np.ones_like(x)])
    for vectors in (round_, shallow):
        path = png(tmp_path / "map.png", codes(vectors))
        assert np.ptp(nm.read_raster(path).pixels[..., 2]) == 0
        assert nm.read_normal_map(path).decoding.components == "xyz"
    one = png(tmp_path / "one.png", np.dstack([codes(round_)[..., :1], np.zeros((64, 64, 2), np.uint8)]))
    # red alone is not a map
    assert nm.read_normal_map(one, nm.ReadOptions(force=True)).decoding.components == "xyz"


def test_an_unusable_blue_is_ignored_on_request(tmp_path, codes, png):
    normals = facing(7, lowest=0.5)
    pixels = codes(normals, 16)
    pixels[..., 2] = np.random.default_rng(7).integers(0, 65536, (40, 50))
    back = nm.read_normal_map(png(tmp_path / "map.png", pixels), nm.ReadOptions(components="xy", green="up"))
    assert angle_deg(back.normals, normals).max() < 0.01
    assert back.decoding.components_from == "given"


@pytest.mark.parametrize("backdrop", ["white", "black", "grey", "flat"])
@pytest.mark.parametrize("smooth", [False, True])
def test_backgrounds_are_recognised_without_blue(tmp_path, dome, codes, png, backdrop, smooth):
    d = dome(128, 128, smooth=smooth)
    pixels = codes(d.normals, 8, backdrop, d.cover)
    back = nm.read_normal_map(png(tmp_path / "map.png", pixels), nm.ReadOptions(components="xy"))
    assert back.decoding.background == backdrop
    assert (back.foreground != d.inside).mean() < 0.02
    if backdrop in ("white", "black"):
        assert np.abs(back.coverage - d.cover).mean() < 0.01
        assert angle_deg(back.normals, d.normals)[d.cover > 0.5].mean() < 0.6
    assert back.decoding.zero_code == ("128" if backdrop == "flat" else "127.5")


@pytest.mark.parametrize("backdrop", ["white", "black", "flat"])
def test_backgrounds_are_recognised_in_two_channels(tmp_path, dome, codes, picture, backdrop):
    d = dome(128, 128)
    path = picture(tmp_path / "map.tif", codes(d.normals, 16, backdrop, d.cover)[..., :2], ("R", "G"))
    back = nm.read_normal_map(path)
    assert back.decoding.background == backdrop
    assert np.array_equal(back.foreground, d.inside)
    named = nm.read_normal_map(path, nm.ReadOptions(background_color="#ffff00"))
    assert named.coverage.min() == (0 if backdrop == "white" else 1)


@pytest.mark.parametrize("bits", [8, 16])
def test_octahedral_maps_cover_both_hemispheres(tmp_path, codes, png, bits):
    normals = sphere(8)
    normals[:5, :5] = (0, 0, 1)
    pixels = codes(np.dstack([folded(normals), np.zeros((40, 50))]), bits)
    path = png(tmp_path / "map.png", pixels)
    back = nm.read_normal_map(path, nm.ReadOptions(components="octahedral", green="up", background_color="none"))
    assert angle_deg(back.normals, normals).max() < (1.0 if bits == 8 else 0.005)
    assert np.array_equal(back.normals[:5, :5], np.broadcast_to(np.float32([0, 0, 1]), (5, 5, 3)))
    turned = nm.read_normal_map(
        path, nm.ReadOptions(components="octahedral", green="up", background_color="none", swizzle="-g,r,b")
    )
    expected = np.stack([-back.normals[..., 1], back.normals[..., 0], back.normals[..., 2]], axis=-1)
    assert np.abs(turned.normals - expected).max() < 1e-6


@pytest.mark.parametrize("backdrop", ["white", "black"])
def test_an_octahedral_map_on_white_or_black_is_read(tmp_path, dome, codes, png, backdrop):
    d = dome(128, 128, smooth=True)
    stored = np.dstack([folded(d.normals), np.zeros((128, 128))])
    pixels = codes(stored, 8, backdrop, d.cover)
    back = nm.read_normal_map(png(tmp_path / "map.png", pixels), nm.ReadOptions(components="octahedral"))
    assert (back.decoding.background, back.decoding.green) == (backdrop, "up")
    assert angle_deg(back.normals, d.normals)[d.cover > 0.5].mean() < 0.6
    assert np.abs(back.coverage - d.cover).mean() < 0.01


def test_an_image_of_another_kind_gives_a_warning(tmp_path, png):
    pixels = np.random.default_rng(9).choice([0, 40, 215, 255], (64, 64, 3)).astype(np.uint8)
    read = nm.read_normal_map(png(tmp_path / "map.png", pixels), nm.ReadOptions(components="xy"))
    assert "does not look like a normal map" in read.decoding.warnings[0]


def test_swizzles_apply_to_two_components(tmp_path, codes, png, picture):
    normals = facing(10)
    two = picture(tmp_path / "two.exr", normals[..., :2], ("R", "G"))
    back = nm.read_normal_map(two, nm.ReadOptions(swizzle="-g,r,b"))
    assert np.abs(back.normals - np.stack([-normals[..., 1], normals[..., 0], normals[..., 2]], -1)).max() < 1e-6
    with pytest.raises(
        nm.UsageError, match=r"two.exr: has no blue; take x and y from r and g, such as `swizzle='-g,r,b'`"
    ):
        nm.read_normal_map(two, nm.ReadOptions(swizzle="b,g,r"))
    with pytest.raises(
        nm.UsageError, match=r"`swizzle='r,g,-b'`: z is computed from x and y and is never negative; remove its minus"
    ):
        nm.read_normal_map(two, nm.ReadOptions(swizzle="r,g,-b"))
    shuffled = png(tmp_path / "bgr.png", codes(normals, 16)[..., ::-1].copy())
    back = nm.read_normal_map(shuffled, nm.ReadOptions(components="xy", swizzle="b,g,r"))
    assert angle_deg(back.normals, normals).max() < 0.05


def test_wrong_options_for_two_components_are_refused(tmp_path, codes, png, picture):
    grey = png(tmp_path / "grey.png", codes(facing(11))[..., :1])
    with pytest.raises(nm.InputError, match=r"grey.png: has 1 channel \(Y\); a two-component map needs two chan"):
        nm.read_normal_map(grey, nm.ReadOptions(components="xy"))
    bad = facing(11)[..., :2].copy()
    bad[3, 4] = np.nan
    with pytest.raises(
        nm.InputError, match=r"bad.exr: found 1 pixel with NaN or infinite values, the first at x=4, y=3"
    ):
        nm.read_normal_map(picture(tmp_path / "bad.exr", bad, ("X", "Y")))
    with pytest.raises(nm.UsageError, match="`components='uv'`: use one of auto, xyz, xy, octahedral"):
        nm.ReadOptions(components="uv")


def test_inspect_and_the_other_commands_report_what_was_found(run, tmp_path, dome, picture):
    d = dome()
    path = picture(tmp_path / "xy.exr", np.dstack([d.normals[..., :2], d.inside]), ("X", "Y", "A"))
    seen = run("inspect", path)
    assert seen.code == 1
    assert "components   x and y, z computed from them (found)" in seen.out
    assert "holds x and y only: it has no blue" in seen.out
    assert "nmap compose convert writes all three" in seen.out
    assert run("inspect", path, "--components", "xy").code == 0
    done = run("relief", path, "-o", tmp_path / "r.stl")
    assert done.code == 0
    assert "x and y, z computed from them (found)" in done.err
