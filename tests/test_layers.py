"""Which channels and parts of a file form a normal map, and the other readable formats."""

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

import nmaptool as nm

RGB = ("R", "G", "B")


@pytest.fixture
def rng():
    return np.random.default_rng(21)


def upward(rng):
    vectors = rng.normal(size=(24, 30, 3))
    vectors[..., 2] = np.abs(vectors[..., 2]) + 0.1
    return (vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)).astype(np.float32)


def write_parts(path, parts):
    """Write a multi-part EXR from (name, channel names, pixels)."""
    specs = []
    for name, channels, pixels in parts:
        spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], "float")
        spec.channelnames = channels
        spec.attribute("oiio:subimagename", name)
        specs.append(spec)
    sink = oiio.ImageOutput.create(str(path))
    assert sink.open(str(path), tuple(specs)), sink.geterror()
    for place, (_, _, pixels) in enumerate(parts):
        if place:
            assert sink.open(str(path), specs[place], "AppendSubimage"), sink.geterror()
        assert sink.write_image(np.ascontiguousarray(pixels)), sink.geterror()
    assert sink.close()
    return path


@pytest.mark.parametrize(
    "names",
    [
        RGB,
        ("N.X", "N.Y", "N.Z"),
        ("N.x", "N.y", "N.z"),
        ("X", "Y", "Z"),
        ("x", "y", "z"),
        ("normal.R", "normal.G", "normal.B"),
        ("red", "green", "blue"),
        ("ViewLayer.Normal.X", "ViewLayer.Normal.Y", "ViewLayer.Normal.Z"),
    ],
)
def test_three_channels_are_read_by_their_names(tmp_path, rng, picture, names):
    normals = upward(rng)
    back = nm.read_normal_map(picture(tmp_path / "map.exr", normals, names))
    assert np.array_equal(back.normals, normals)


@pytest.mark.parametrize("order", [(2, 1, 0), (1, 2, 0)])
def test_the_order_in_the_file_does_not_matter(tmp_path, rng, picture, order):
    normals = upward(rng)
    names = [("N.X", "N.Y", "N.Z")[i] for i in order]
    back = nm.read_normal_map(picture(tmp_path / "map.exr", normals[..., list(order)], names))
    assert np.array_equal(back.normals, normals)


@pytest.mark.parametrize("names", [("R", "G", "B", "A"), ("N.X", "N.Y", "N.Z", "A"), ("N.X", "N.Y", "N.Z", "N.A")])
def test_alpha_belongs_to_its_layer_or_to_the_file(tmp_path, rng, picture, names):
    normals = upward(rng)
    alpha = (rng.uniform(size=(24, 30, 1)) > 0.3).astype(np.float32)
    back = nm.read_normal_map(picture(tmp_path / "map.exr", np.dstack([normals, alpha]), names))
    assert np.array_equal(back.coverage, alpha[..., 0])
    assert np.array_equal(back.normals[alpha[..., 0] > 0], normals[alpha[..., 0] > 0])


@pytest.mark.parametrize("extra", ["Z", "depth.Z", "Y", "zzz", "depth"])
def test_a_depth_channel_beside_the_colours_is_ignored(tmp_path, rng, picture, extra):
    normals = upward(rng)
    depth = rng.uniform(5, 9, size=(24, 30, 1))
    back = nm.read_normal_map(picture(tmp_path / "map.exr", np.dstack([normals, depth]), (*RGB, extra)))
    assert np.array_equal(back.normals, normals)


def test_a_layer_with_a_prefix_is_read_by_name(tmp_path, rng, picture):
    base, detail = upward(rng), upward(rng)
    names = [f"{layer}.{axis}" for layer in ("base", "detail") for axis in "XYZ"]
    path = picture(tmp_path / "maps.exr", np.dstack([base, detail]), names)
    for wanted, truth in (("base", base), ("detail", detail), ("DETAIL", detail)):
        named = nm.read_normal_map(f"{path}:{wanted}")
        assert np.array_equal(named.normals, truth)
        assert named.name == f"{path}:{wanted.lower()}"
        assert np.array_equal(nm.read_normal_map(path, nm.ReadOptions(layer=wanted)).normals, truth)


def test_several_layers_without_a_choice_are_an_error_that_lists_them(tmp_path, rng, picture):
    names = [f"{layer}.{axis}" for layer in ("base", "detail") for axis in "XYZ"]
    path = picture(tmp_path / "maps.exr", np.dstack([upward(rng), upward(rng)]), names)
    with pytest.raises(nm.InputError, match=r"several layers \(base, detail\); name one, such as maps\.exr:base"):
        nm.read_normal_map(path)
    with pytest.raises(nm.InputError, match=r"has no layer 'detial'; it holds: base, detail"):
        nm.read_normal_map(f"{path}:detial")


@pytest.mark.parametrize("first", ["original", "N", "normal"])
def test_the_obvious_layer_of_several_is_chosen(tmp_path, rng, picture, first):
    wanted = upward(rng)
    names = [f"{layer}.{axis}" for layer in ("albedo", first) for axis in "XYZ"]
    back = nm.read_normal_map(picture(tmp_path / "maps.exr", np.dstack([upward(rng), wanted]), names))
    assert np.array_equal(back.normals, wanted)


def test_a_colon_in_a_file_name_does_not_name_a_layer(tmp_path, rng, picture):
    normals = upward(rng)
    path = picture(tmp_path / "a.exr", normals).rename(tmp_path / "a.exr:b.exr")
    assert np.array_equal(nm.read_normal_map(path).normals, normals)


def test_a_layer_of_a_missing_file_names_the_file(tmp_path):
    with pytest.raises(nm.InputError, match=r"maps\.exr: no such file"):
        nm.read_normal_map(f"{tmp_path / 'maps.exr'}:base")


def test_parts_are_layers(tmp_path, rng):
    base, detail = upward(rng), upward(rng)
    path = write_parts(tmp_path / "parts.exr", [("base", RGB, base), ("detail", RGB, detail)])
    assert np.array_equal(nm.read_normal_map(f"{path}:base").normals, base)
    assert np.array_equal(nm.read_normal_map(f"{path}:detail").normals, detail)
    with pytest.raises(nm.InputError, match=r"several layers \(base, detail\)"):
        nm.read_normal_map(path)


def test_a_part_whose_channels_repeat_its_name_is_found_by_that_name(tmp_path, rng):
    base, detail = upward(rng), upward(rng)
    names = {layer: tuple(f"{layer}.{axis}" for axis in "XYZ") for layer in ("base", "detail")}
    path = write_parts(tmp_path / "p.exr", [("base", names["base"], base), ("detail", names["detail"], detail)])
    assert np.array_equal(nm.read_normal_map(f"{path}:detail").normals, detail)


@pytest.mark.parametrize(("x", "y"), [(5, 7), (0, 3), (-4, -6)])
def test_a_data_window_is_placed_at_its_offset(tmp_path, rng, picture, x, y):
    normals = upward(rng)
    path = picture(tmp_path / "map.exr", normals, x=x, y=y, full_x=0, full_y=0, full_width=60, full_height=50)
    back = nm.read_normal_map(path)
    assert back.frame.shape == (50, 60)
    left, top = max(x, 0), max(y, 0)
    inside = np.zeros((50, 60), bool)
    inside[top : y + 24, left : x + 30] = True
    assert np.array_equal(back.coverage, inside.astype(np.float32))
    assert np.array_equal(back.normals[top : y + 24, left : x + 30], normals[top - y :, left - x :])
    assert np.array_equal(np.unique(back.normals[~inside], axis=0), [[0, 0, 1]])


def test_a_data_window_equal_to_a_shifted_display_window_is_the_whole_image(tmp_path, rng, picture):
    normals = upward(rng)
    path = picture(tmp_path / "map.exr", normals, x=9, y=4, full_x=9, full_y=4, full_width=30, full_height=24)
    back = nm.read_normal_map(path)
    assert np.array_equal(back.normals, normals)
    assert (back.coverage == 1).all()


def test_deep_data_is_refused(tmp_path):
    path = tmp_path / "deep.exr"
    spec = oiio.ImageSpec(4, 4, 3, "float")
    spec.channelnames = RGB
    spec.deep = True
    deep = oiio.DeepData()
    deep.init(spec)
    for pixel in range(16):
        deep.set_samples(pixel, 2)
    sink = oiio.ImageOutput.create(str(path))
    if not (sink.supports("deepdata") and sink.open(str(path), spec) and sink.write_deep_image(deep)):
        pytest.skip("this OpenImageIO cannot write deep data")
    sink.close()
    with pytest.raises(nm.InputError, match=r"deep\.exr: holds deep data .*flatten it on export"):
        nm.read_normal_map(path)


@pytest.mark.parametrize(("ending", "bits"), [("tif", 8), ("tif", 16), ("tiff", 16), ("bmp", 8), ("TIF", 16)])
def test_other_lossless_formats_are_read(tmp_path, rng, picture, codes, ending, bits):
    normals = upward(rng)
    path = picture(tmp_path / f"map.{ending}", codes(normals, bits))
    image = nm.read_raster(path)
    assert (image.bits, image.channels, image.lossy) == (bits, RGB, False)
    back = nm.decode_normal_map(image)
    assert np.abs(back.normals - normals).max() <= np.sqrt(3) / (2**bits - 1)


def test_jpeg_is_read_as_lossy(tmp_path, dome, codes, picture):
    d = dome()
    image = nm.read_raster(picture(tmp_path / "map.JPG", codes(d.normals), CompressionQuality=98))
    assert (image.bits, image.lossy) == (8, True)
    assert np.abs(nm.decode_normal_map(image).normals - d.normals).mean() < 0.02


def test_a_tiff_with_unassociated_alpha_is_not_multiplied(tmp_path, rng, codes, picture):
    normals = upward(rng)
    alpha = np.full((24, 30, 1), 20000, np.uint16)
    alpha[:, 6:] = 65535
    image = nm.read_raster(picture(tmp_path / "map.tif", np.dstack([codes(normals, 16), alpha]), ("R", "G", "B", "A")))
    assert np.array_equal(image.pixels[..., :3], codes(normals, 16))
    assert np.array_equal(image.pixels[..., 3:], alpha)


def test_a_grey_mask_is_read_from_any_format(tmp_path, png, picture):
    mask = np.zeros((8, 9), np.uint8)
    mask[2:5, 3:7] = 255
    opaque = np.full_like(mask, 255)
    sheets = {
        "grey.png": png(tmp_path / "grey.png", mask),
        "sixteen.png": png(tmp_path / "sixteen.png", mask.astype(np.uint16) * 257),
        "colour.png": png(tmp_path / "colour.png", np.dstack([mask] * 3)),
        "opaque.png": png(tmp_path / "opaque.png", np.dstack([mask, mask, mask, opaque])),
        "alpha.png": png(tmp_path / "alpha.png", np.dstack([opaque, opaque, opaque, mask])),
        "black-alpha.png": png(tmp_path / "black-alpha.png", np.dstack([mask * 0, mask])),
        "y.exr": picture(tmp_path / "y.exr", mask[..., None] / 255, ("Y",)),
        "z.exr": picture(tmp_path / "z.exr", mask[..., None] / 255, ("Z",)),
        "a.exr": picture(tmp_path / "a.exr", mask[..., None] / 255, ("A",)),
        "mask.tif": picture(tmp_path / "mask.tif", mask[..., None], ("Y",)),
        "mask.jpg": picture(tmp_path / "mask.jpg", np.dstack([mask] * 3), CompressionQuality=100),
    }
    for name, path in sheets.items():
        assert np.array_equal(nm.read_grey(path) >= 0.5, mask == 255), name
    tinted = png(tmp_path / "tinted.png", np.dstack([mask, mask, opaque]))
    with pytest.raises(nm.InputError, match=r"tinted\.png: is a colour picture; a mask or weight map must be grey"):
        nm.read_grey(tinted)
