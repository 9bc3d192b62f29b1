"""Pictures in NumPy array files: axes, types, archives, and what is refused."""

import io
import pickle
import zipfile

import numpy as np
import pytest

import nmaptool as nm

SHAPES = {
    "rows, columns, channels": lambda n: n,
    "channels first": lambda n: np.moveaxis(n, -1, 0),
    "a batch of one": lambda n: n[None],
    "a batch of one, channels first": lambda n: np.moveaxis(n, -1, 0)[None],
    "columns in memory": np.asfortranarray,
}


@pytest.fixture
def normals(dome):
    return dome(24, 30).normals.astype(np.float32)


def save(path, values, **more):
    np.save(path, values, **more)
    return path


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("ending", ["npy", "npz"])
def test_the_channels_may_be_the_last_or_the_first_axis(tmp_path, normals, kind, ending):
    path = tmp_path / f"normal.{ending}"
    values = SHAPES[kind](normals)
    if ending == "npz":
        np.savez_compressed(path, normal=values)
    else:
        np.save(path, values)
    image = nm.read_raster(path)
    assert np.array_equal(image.pixels, normals)
    assert image.channels == ("R", "G", "B")
    assert ("its first axis holds the channels" in image.notes) == ("first" in kind)
    assert np.abs(nm.read_normal_map(path).normals - normals).max() < 1e-6


@pytest.mark.parametrize("shape", [(24, 30), (1, 24, 30), (24, 30, 1), (1, 1, 24, 30)])
def test_one_channel_is_grey_whatever_its_axes(tmp_path, shape):
    values = np.random.default_rng(1).normal(size=(24, 30)).astype(np.float32)
    image = nm.read_raster(save(tmp_path / "a.npy", values.reshape(shape)))
    assert image.channels == ("Y",)
    assert np.array_equal(image.pixels[..., 0], values)


@pytest.mark.parametrize("kind", ["f2", "f4", "f8", ">f4", ">f8"])
def test_floats_are_read_as_signed_or_unsigned_by_what_they_hold(tmp_path, normals, kind):
    for name, values in (("signed", normals), ("unsigned", (normals + 1) / 2)):
        back = nm.read_normal_map(save(tmp_path / f"{name}.npy", values.astype(kind)))
        assert back.decoding.encoding == name
        assert np.abs(back.normals - normals).max() < (4e-3 if kind == "f2" else 1e-6)


def test_half_floats_have_16_bits_and_codes_keep_theirs(tmp_path, normals, codes):
    assert nm.read_raster(save(tmp_path / "h.npy", normals.astype(np.float16))).bits == 16
    for bits in (8, 16):
        image = nm.read_raster(save(tmp_path / f"{bits}.npy", codes(normals, bits)))
        assert (image.bits, image.pixels.dtype.itemsize) == (bits, bits // 8)
        assert np.array_equal(image.pixels, codes(normals, bits))


@pytest.mark.parametrize("kind", ["i2", "i4", "i8", "u4", "f4", "f8"])
def test_whole_numbers_to_255_in_wider_types_are_codes(tmp_path, normals, codes, kind):
    image = nm.read_raster(save(tmp_path / "a.npy", codes(normals).astype(kind)))
    assert image.pixels.dtype == np.uint8
    assert np.array_equal(image.pixels, codes(normals))
    assert "read as 8-bit codes" in image.notes[0]


@pytest.mark.parametrize("kind", ["i1", "i2", "i4", "i8", "u4", "u8"])
def test_integers_become_floats_with_the_same_values(tmp_path, kind):
    values = np.random.default_rng(2).integers(0, 100, (8, 9)).astype(kind)
    values[0, 0] = np.iinfo(kind).min
    image = nm.read_raster(save(tmp_path / "a.npy", values), holds="depth")
    assert np.array_equal(image.pixels[..., 0], values.astype(np.float32))
    assert (image.bits, image.is_float) == (32, True)
    assert f"{8 * values.dtype.itemsize}-bit {'signed' if kind[0] == 'i' else 'unsigned'} integers" in image.notes[0]
    assert "rounded" not in image.notes[0]
    values[0, 0] = np.iinfo(kind).max
    rounded = "rounded" in nm.read_raster(save(tmp_path / "b.npy", values)).notes[0]
    assert rounded == (values.dtype.itemsize > 2)


def test_a_bool_array_is_a_mask(tmp_path):
    mask = np.zeros((8, 9), bool)
    mask[2:5, 3:7] = True
    assert np.array_equal(nm.read_grey(save(tmp_path / "m.npy", mask)), mask.astype(np.float32))


def test_a_fourth_channel_is_alpha_only_from_0_to_1(tmp_path, normals):
    cover = np.linspace(0, 1, 24 * 30, dtype=np.float32).reshape(24, 30)
    image = nm.read_raster(save(tmp_path / "a.npy", np.dstack([normals, cover])))
    assert image.channels == ("R", "G", "B", "A")
    image = nm.read_raster(save(tmp_path / "b.npy", np.dstack([normals, cover * 20])))
    assert image.channels == ("R", "G", "B")
    assert "not read as alpha" in image.notes[0]


def test_the_array_with_the_fitting_name_or_shape_is_chosen(tmp_path, normals):
    depth = normals[..., 2]
    path = tmp_path / "out.npz"
    np.savez(path, points=normals + 5, depth=depth, intrinsics=np.eye(3), mask=depth > 0, normal=normals)
    assert np.array_equal(nm.read_raster(path).pixels, normals)
    image = nm.read_raster(path, holds="depth")
    assert image.name == f"{path}:depth"
    assert image.layer == "depth"
    assert np.array_equal(image.pixels[..., 0], depth)
    assert "also holds the arrays points, intrinsics, mask, normal" in image.notes
    assert np.array_equal(nm.read_raster(f"{path}:points").pixels, normals + 5)
    np.savez(path, a=normals, b=depth, k=np.zeros(5))
    assert nm.read_raster(path).layer == "a"


def test_an_archive_without_an_obvious_array_lists_all(tmp_path, normals):
    path = tmp_path / "out.npz"
    np.savez(path, left=normals, right=normals)
    with pytest.raises(nm.InputError, match=r"holds several arrays \(left, right\); name one, such as out\.npz:left"):
        nm.read_raster(path)
    with pytest.raises(nm.InputError, match=r"has no array 'middle'; it holds: left, right"):
        nm.read_raster(f"{path}:middle")


def test_pickles_are_refused_and_never_run(tmp_path):
    objects = np.array([{"normal": 1}, None], object)
    np.save(tmp_path / "o.npy", objects, allow_pickle=True)
    np.savez(tmp_path / "o.npz", normal=objects)
    for name in ("o.npy", "o.npz:normal"):
        with pytest.raises(
            nm.InputError, match=r"holds Python objects \(a pickle\), which may run code and are not read"
        ):
            nm.read_raster(tmp_path / name)
    (tmp_path / "p.npy").write_bytes(pickle.dumps(objects))
    with pytest.raises(nm.InputError, match=r"is a Python pickle; save its array with numpy\.save as \.npy"):
        nm.read_raster(tmp_path / "p.npy")


@pytest.mark.parametrize("shape", [(7,), (), (2, 8, 9, 3), (8, 9, 5), (0, 9, 3)])
def test_arrays_that_are_no_picture_are_refused(tmp_path, shape):
    with pytest.raises(nm.InputError, match=r"holds an array of shape .*; accepted are \(rows, columns\)"):
        nm.read_raster(save(tmp_path / "a.npy", np.zeros(shape, np.float32)))


def test_complex_numbers_records_and_text_are_refused(tmp_path):
    with pytest.raises(nm.InputError, match=r"stores complex numbers; save their real part"):
        nm.read_raster(save(tmp_path / "c.npy", np.zeros((4, 5), complex)))
    with pytest.raises(nm.InputError, match=r"holds records \(a\), not a picture"):
        nm.read_raster(save(tmp_path / "r.npy", np.zeros((4, 5), [("a", "f4")])))
    with pytest.raises(nm.InputError, match=r"stores <U3 values"):
        nm.read_raster(save(tmp_path / "t.npy", np.full((4, 5), "abc")))


def header(shape, kind="<f4"):
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": kind, "fortran_order": False, "shape": shape})
    return stream.getvalue()


def test_the_limit_applies_to_what_the_header_declares(tmp_path):
    claim = header((100_000, 100_000, 3)) + bytes(100)
    (tmp_path / "a.npy").write_bytes(claim)
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("normal.npy", claim)
    for name in ("a.npy", "a.npz"):
        with pytest.raises(nm.LimitError, match=r"100000 x 100000 is 10000 megapixels"):
            nm.read_raster(tmp_path / name)


def test_an_archive_that_unpacks_to_more_than_its_header_says_is_refused(tmp_path):
    with zipfile.ZipFile(tmp_path / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("normal.npy", header((4, 5, 3)) + bytes(50_000_000))
    with pytest.raises(nm.InputError, match=r"bomb\.npz: the NumPy \.npz file is truncated or damaged"):
        nm.read_raster(tmp_path / "bomb.npz")


@pytest.mark.parametrize("ending", ["npy", "npz"])
def test_every_truncation_is_refused(tmp_path, normals, ending):
    path = tmp_path / f"a.{ending}"
    np.savez(path, normal=normals, mask=normals[..., 0] > 0) if ending == "npz" else np.save(path, normals)
    data = path.read_bytes()
    for size in [*range(1, 200, 7), *range(200, len(data), 311), len(data) - 1]:
        path.write_bytes(data[:size])
        with pytest.raises(nm.InputError, match=rf"a\.{ending}: .*(truncated|supported format)"):
            nm.read_raster(path)


def test_a_zip_without_arrays_is_named(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("hello.txt", "x")
    with pytest.raises(nm.InputError, match=r"is a ZIP archive without NumPy arrays"):
        nm.read_raster(tmp_path / "a.npz")


def test_an_array_is_read_wherever_a_picture_is(tmp_path, dome, run):
    d = dome()
    np.save(tmp_path / "n.npy", d.normals.astype(np.float32))
    np.save(tmp_path / "m.npy", d.inside)
    np.save(tmp_path / "z.npy", np.hypot(*np.mgrid[0:96, 0:96]).astype(np.float32))
    assert run("inspect", tmp_path / "n.npy").code in (0, 1)
    done = run("relief", tmp_path / "n.npy", "--mask", tmp_path / "m.npy", "-o", tmp_path / "h.exr", "--height", "3mm")
    assert (done.code, done.err) == (0, done.err)
    assert run("compose", "convert", tmp_path / "n.npy", tmp_path / "c.exr").code == 0
    assert np.abs(nm.read_raster(tmp_path / "c.exr").pixels - d.normals).max() < 1e-6
    assert run("compose", "depth", tmp_path / "z.npy", "-o", tmp_path / "d.exr", "--depth-scale", "96px").code == 0


def test_an_array_of_normals_is_a_curved_background_and_one_of_heights_still_is(tmp_path, clean_map, dome):
    leaf = nm.read_normal_map(clean_map)
    np.save(tmp_path / "n.npy", dome().normals.astype(np.float32))
    np.save(tmp_path / "z.npy", np.zeros((96, 96)))
    assert isinstance(nm.read_surface(tmp_path / "n.npy", like=leaf, pitch_mm=0.5), nm.NormalMap)
    assert isinstance(nm.read_surface(tmp_path / "z.npy", like=leaf, pitch_mm=0.5), nm.Height)
