"""Unusable files: the right error, which names the file, the fault and a remedy."""

import os
import struct
import subprocess
import sys

import numpy as np
import pytest
from cli_cases import LONG_NAMES

import nmaptool as nm
from nmaptool.io.pictures.heights import write_height

RGB = ("R", "G", "B")
CUT = r"file (is truncated or damaged|cannot be read).*export or download it again"


@pytest.fixture
def good(tmp_path, dome, codes, png, picture):
    """A sound map in each readable format."""
    normals = dome().normals
    return {
        "png": png(tmp_path / "good.png", codes(normals, 16)),
        "exr": picture(tmp_path / "good.exr", normals),
        "tif": picture(tmp_path / "good.tif", codes(normals, 16), compression="zip"),
        "jpg": picture(tmp_path / "good.jpg", codes(normals)),
        "bmp": picture(tmp_path / "good.bmp", codes(normals)),
    }


def tiff_header(cols, rows):
    """A TIFF of one uncompressed strip that claims a size and holds 64 bytes."""
    tags = [
        (256, 4, 1, cols),
        (257, 4, 1, rows),
        (258, 3, 1, 8),
        (259, 3, 1, 1),
        (262, 3, 1, 2),
        (273, 4, 1, 200),
        (277, 3, 1, 3),
        (278, 4, 1, rows),
        (279, 4, 1, min(cols * rows * 3, 2**32 - 1)),
        (284, 3, 1, 1),
    ]
    body = b"".join(struct.pack("<HHII", *tag) for tag in tags)
    return (b"II*\0" + struct.pack("<IH", 8, len(tags)) + body + b"\0\0\0\0").ljust(200, b"\0") + bytes(64)


def bmp_header(cols, rows):
    info = struct.pack("<IiiHHIIiiII", 40, cols, rows, 1, 24, 0, 0, 2835, 2835, 0, 0)
    return b"BM" + struct.pack("<IHHI", 118, 0, 0, 54) + info + bytes(64)


def exr_header(cols, rows):
    def attribute(name, kind, value):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value

    window = struct.pack("<4i", 0, 0, cols - 1, rows - 1)
    names = b"".join(c + b"\0" + struct.pack("<IIii", 2, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
    parts = [
        attribute(b"channels", b"chlist", names),
        attribute(b"compression", b"compression", b"\0"),
        *(attribute(name, b"box2i", window) for name in (b"dataWindow", b"displayWindow")),
        attribute(b"lineOrder", b"lineOrder", b"\0"),
        attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        attribute(b"screenWindowCenter", b"v2f", bytes(8)),
        attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)),
    ]
    return b"\x76\x2f\x31\x01" + struct.pack("<I", 2) + b"".join(parts) + b"\0" + bytes(64)


HEADERS = {"tif": tiff_header, "bmp": bmp_header, "exr": exr_header}


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    with pytest.raises(nm.InputError, match=r"none\.png: no such file"):
        nm.read_normal_map(tmp_path / "none.png")
    with pytest.raises(nm.InputError, match=r"is a folder; give a picture file"):
        nm.read_normal_map(tmp_path)


def test_a_path_through_a_file_is_refused(tmp_path):
    (tmp_path / "file").write_text("x", encoding="utf-8")
    with pytest.raises(nm.InputError, match=r"map\.png: (cannot be read \(Not a directory\)|no such file)"):
        nm.read_normal_map(tmp_path / "file" / "map.png")


@LONG_NAMES
@pytest.mark.parametrize("ending", [".png", ".exr:base"])
def test_a_name_that_is_too_long_is_refused(tmp_path, ending):
    with pytest.raises(nm.InputError, match=r"cannot be read \(File name too long\)"):
        nm.read_normal_map(tmp_path / ("n" * 300 + ending))


@pytest.mark.parametrize("ending", ["png", "exr", "tif", "jpg"])
def test_an_empty_file_is_refused(tmp_path, ending):
    (tmp_path / f"map.{ending}").touch()
    with pytest.raises(nm.InputError, match=rf"map\.{ending}: is empty; export or download it again"):
        nm.read_normal_map(tmp_path / f"map.{ending}")


@pytest.mark.parametrize("share", [0.03, 0.3, 0.7, 0.97])
@pytest.mark.parametrize("ending", ["png", "exr", "tif", "jpg", "bmp"])
def test_a_truncated_file_is_refused(good, ending, share):
    data = good[ending].read_bytes()
    good[ending].write_bytes(data[: int(len(data) * share)])
    with pytest.raises(nm.InputError, match=rf"good\.{ending}: the \w+ {CUT}") as caught:
        nm.read_normal_map(good[ending])
    assert "\n" not in str(caught.value)
    assert "subimage" not in str(caught.value)


@pytest.mark.parametrize("ending", ["png", "exr", "tif"])
def test_a_file_damaged_in_the_middle_is_refused(good, ending):
    data = bytearray(good[ending].read_bytes())
    middle = len(data) // 2
    data[middle : middle + 40] = bytes(value ^ 0xFF for value in data[middle : middle + 40])
    good[ending].write_bytes(data)
    with pytest.raises(nm.InputError, match=rf"good\.{ending}: the \w+ {CUT}"):
        nm.read_normal_map(good[ending])


def test_a_png_with_valid_checksums_but_missing_rows_is_refused(tmp_path, dome, codes, png):
    path = png(tmp_path / "map.png", codes(dome().normals), cut=3000)
    with pytest.raises(nm.InputError, match=rf"map\.png: the \w+ {CUT}"):
        nm.read_normal_map(path)


@pytest.mark.parametrize(("kind", "named"), [("png", "exr"), ("exr", "png"), ("tif", "jpg"), ("jpg", "tif")])
def test_a_file_with_the_ending_of_another_format_is_refused(good, kind, named):
    wrong = good[kind].rename(good[kind].with_suffix(f".{named}"))
    with pytest.raises(nm.InputError, match=rf"good\.{named}: holds [A-Z]+ data; rename it to good\.{kind}"):
        nm.read_normal_map(wrong)


@pytest.mark.parametrize(
    "data", [b"not a picture\n", b"<!DOCTYPE html><html>", b"\0" * 4096, b"\x89PN", b"RIFFWEBP", b"PF", b"DDS"]
)
def test_bytes_that_are_not_an_image_are_refused(tmp_path, data):
    (tmp_path / "map.png").write_bytes(data)
    with pytest.raises(nm.InputError, match=r"map\.png: is not a picture .*; export it as PNG, EXR or TIFF"):
        nm.read_normal_map(tmp_path / "map.png")


@pytest.mark.parametrize("ending", ["png", "exr", "tif", "jpg", "bmp"])
def test_a_file_with_only_a_signature_is_refused(good, ending):
    good[ending].write_bytes(good[ending].read_bytes()[:8])
    with pytest.raises(nm.InputError, match=rf"good\.{ending}: .*export or download it again"):
        nm.read_normal_map(good[ending])


@pytest.mark.parametrize(("count", "stated"), [(1, r"has 1 channel"), (2, r"has 2 channel")])
def test_too_few_channels_are_refused(tmp_path, dome, codes, png, picture, count, stated):
    normals = dome().normals
    names = (("Y",), ("Y", "A"))[count - 1]
    paths = [
        png(tmp_path / "map.png", codes(normals, 16)[..., :count]),
        picture(tmp_path / "map.tif", codes(normals, 16)[..., :count], names),
        picture(tmp_path / "map.exr", normals[..., :count], names),
        picture(tmp_path / "xz.exr", normals[..., :count], ("N.X", "N.Z")[:count]),
    ]
    for path in paths:
        with pytest.raises(nm.InputError, match=rf"{path.name}: {stated}.*needs red, green and blue"):
            nm.read_normal_map(path)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("ending", [".exr", ".tif"])
def test_nonfinite_values_in_the_motif_are_refused(tmp_path, dome, picture, value, ending):
    normals = dome().normals.copy()
    normals[17, 5, 1] = normals[40, 50, 2] = value
    path = picture(tmp_path / f"map{ending}", normals)
    with pytest.raises(
        nm.InputError, match=r"found 2 pixels with NaN or infinite values, the first at x=5, y=17; repair"
    ):
        nm.read_normal_map(path)


def test_nonfinite_values_outside_the_coverage_are_ignored(tmp_path, dome, picture):
    d = dome()
    normals = d.normals.copy()
    normals[~d.inside] = (np.nan, np.inf, -np.inf)
    path = picture(tmp_path / "map.exr", np.dstack([normals, d.inside]), (*RGB, "A"))
    back = nm.read_normal_map(path)
    assert np.isfinite(back.normals).all()
    assert np.abs(back.normals - d.normals)[d.inside].max() < 1e-6
    assert np.array_equal(back.foreground, d.inside)
    assert nm.inspect_map(nm.read_raster(path)).findings == ()


def test_nonfinite_alpha_is_refused(tmp_path, dome, picture):
    alpha = np.ones((96, 96))
    alpha[3, 3] = np.nan
    path = picture(tmp_path / "map.exr", np.dstack([dome().normals, alpha]), (*RGB, "A"))
    with pytest.raises(nm.InputError, match=r"alpha holds NaN or infinite values"):
        nm.read_normal_map(path)


def test_nonfinite_masks_are_refused(tmp_path, picture):
    path = picture(tmp_path / "mask.exr", np.full((4, 4, 1), np.nan), ("Y",))
    with pytest.raises(nm.InputError, match=r"mask\.exr: holds NaN or infinite values"):
        nm.read_grey(path)


@pytest.mark.parametrize("ending", ["png", "exr", "tif", "npy"])
def test_a_height_file_with_holes_is_refused_as_curved_background(tmp_path, ending):
    inside = np.ones((8, 9), bool)
    inside[2:4, 3:6] = False
    z = np.random.default_rng(22).uniform(size=(9, 10))
    write_height(nm.Height(z, inside, nm.Frame(8, 9, 0.1)), tmp_path / f"ground.{ending}", {})
    with pytest.raises(nm.InputError, match=rf"ground\.{ending}: .*must be defined everywhere"):
        nm.read_height(tmp_path / f"ground.{ending}", pitch_mm=0.1)


def test_values_far_beyond_unit_length_are_normalised(tmp_path, dome, picture):
    normals = dome().normals.copy()
    normals[10, 10] *= 1e30
    normals[11, 11] *= 1e-30
    image = nm.read_raster(picture(tmp_path / "map.exr", normals))
    assert np.abs(nm.decode_normal_map(image).normals[10, 10] - dome().normals[10, 10]).max() < 1e-6
    assert np.isfinite(nm.inspect_map(image).unit_length_error)


@pytest.fixture
def claiming(tmp_path, png):
    """``claiming(ending, side)``: an image whose header claims ``side`` x ``side`` pixels."""

    def write(ending, side):
        path = tmp_path / f"map.{ending}"
        if ending == "png":
            return png(path, np.zeros((2, 2, 3), np.uint8), size=(side, side))
        path.write_bytes(HEADERS[ending](side, side))
        return path

    return write


@pytest.mark.parametrize("ending", ["png", *HEADERS])
def test_a_header_that_claims_too_many_pixels_is_refused(claiming, ending):
    path = claiming(ending, 100_000)
    with pytest.raises(nm.LimitError, match=r"100000 x 100000 is 10000 megapixels, more than the limit of 270"):
        nm.read_normal_map(path)
    with pytest.raises((nm.InputError, nm.LimitError), match=rf"map\.{ending}: ") as caught:
        nm.read_normal_map(path, nm.ReadOptions(max_megapixels=1e6))  # the data are still missing
    assert "OIIO" not in str(caught.value)


def test_a_jpeg_header_that_claims_too_many_pixels_is_refused(good):
    data = good["jpg"].read_bytes()
    frame = data.index(b"\xff\xc0") + 5
    good["jpg"].write_bytes(data[:frame] + struct.pack(">HH", 65_500, 65_500) + data[frame + 4 :])
    with pytest.raises((nm.LimitError, nm.InputError), match=r"good\.jpg: .*(more than the limit|header claims)"):
        nm.read_normal_map(good["jpg"])


@pytest.mark.parametrize("window", [b"dataWindow", b"displayWindow"])
def test_an_exr_window_that_claims_too_many_pixels_is_refused(good, window):
    data = bytearray(good["exr"].read_bytes())
    value = data.index(window + b"\0box2i\0") + len(window) + 11
    data[value : value + 16] = struct.pack("<4i", 0, 0, 99_999, 99_999)
    good["exr"].write_bytes(data)
    with pytest.raises(nm.LimitError, match=r"100000 x 100000 is 10000 megapixels, more than the limit of 270"):
        nm.read_normal_map(good["exr"])


def test_the_limit_can_be_set(good):
    assert nm.read_normal_map(good["png"], nm.ReadOptions(max_megapixels=0.0093)).frame.shape == (96, 96)
    for path in good.values():
        with pytest.raises(nm.LimitError, match=r"96 x 96 .* 0\.009; make it smaller or raise `max_megapixels`"):
            nm.read_normal_map(path, nm.ReadOptions(max_megapixels=0.009))


@pytest.mark.skipif(sys.platform != "linux", reason="other systems count memory in other units")
@pytest.mark.parametrize("ending", ["png", *HEADERS])
def test_a_header_within_the_limit_without_its_data_takes_no_memory(claiming, ending):
    path = claiming(ending, 16_000)
    script = (
        "import resource, sys, nmaptool as nm\n"
        "try: nm.read_normal_map(sys.argv[1])\n"
        "except nm.InputError: print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)\n"
    )
    # a process in between: the system counts the parent's memory as the child's
    apart = "import subprocess, sys; sys.exit(subprocess.run([sys.executable, '-c', *sys.argv[1:]]).returncode)"
    words = [sys.executable, "-c", apart, script, path]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert int(done.stdout) < 500  # MB; the image would take 768


def test_a_name_outside_ascii_is_read(good):
    path = good["png"].rename(good["png"].with_name("größe 頭.png"))
    assert nm.read_normal_map(path).frame.shape == (96, 96)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere every file name is text")
def test_a_name_that_is_not_text_is_refused(good):
    with pytest.raises(nm.InputError, match=r"rename"):
        nm.read_normal_map(good["png"].rename(good["png"].with_name(os.fsdecode(b"caf\xe9.png"))))
