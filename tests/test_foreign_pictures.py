"""Formats that are not read: each is named, with the way to one that is."""

import pytest

import nmaptool as nm
from nmaptool.io.pictures.foreign import FOREIGN_FORMATS
from nmaptool.io.pictures.formats import READ_FORMATS, format_names, is_picture

CASES = {
    "a.gif": (b"GIF89a", r"is a GIF, which holds at most 256 colours; export the map as PNG, EXR or TIFF"),
    "a.avif": (b"\0\0\0\x20ftypavif", r"is an AVIF picture, which is lossy; export the map"),
    "a.jxl": (b"\xff\x0a\x00", r"is a JPEG XL picture; export the map"),
    "b.jxl": (b"\0\0\0\x0cJXL \r\n", r"is a JPEG XL picture"),
    "a.jp2": (b"\0\0\0\x0cjP  \r\n", r"is a JPEG 2000 picture"),
    "a.ktx2": (b"\xabKTX 20\xbb\r\n", r"is a KTX texture; unpack it with ktx extract, or convert it to DDS or PNG"),
    "a.psd": (b"8BPS\0\1", r"is a layered file; read its layers with nmap compose unpack"),
    "a.ora": (b"PK\3\4" + bytes(26) + b"mimetypeimage/openraster", r"is an OpenRaster file; .*nmap compose unpack"),
    "a.kra": (b"PK\3\4" + bytes(26) + b"mimetypeapplication/x-krita", r"is a Krita file; export it as PNG or EXR"),
    "a.xcf": (b"gimp xcf v011", r"is a GIMP file; export it as PNG or TIFF, or as PSD"),
    "a.svg": (b"<?xml version='1.0'?>\n<!-- x --><svg", r"is an SVG drawing; render it as PNG"),
    "b.svg": (b"\xef\xbb\xbf  <svg xmlns", r"is an SVG drawing"),
    "a.pdf": (b"%PDF-1.7", r"is a PDF or PostScript document; render it as PNG"),
    "a.cr2": (b"II*\0\x10\0\0\0CR\x02\0", r"is a camera raw file; develop it to a 16-bit TIFF first"),
    "a.nef": (b"MM\0*\0\0\0\x08", r"is a camera raw file"),
    "a.raf": (b"FUJIFILMCCD-RAW 0201", r"is a camera raw file"),
    "a.mp4": (b"\0\0\0\x20ftypisom", r"is a video; export one frame as PNG or TIFF"),
    "a.pgm": (b"P2\n4 4\n255\n", r"is a text of numbers \(PGM or PPM, plain\); save it in binary form, or as PNG"),
    "a.fits": (b"SIMPLE  =   T", r"is a FITS file; save its array with numpy\.save as \.npy"),
    "a.mat": (b"MATLAB 5.0 MAT-file", r"is an HDF5 or MATLAB file; save its array"),
    "a.pkl": (b"\x80\x04\x95", r"is a Python pickle; save its array"),
    "a.glb": (b"glTF\2\0\0\0", r"is a mesh; render its maps first with nmap bake"),
}


@pytest.mark.parametrize("name", CASES)
def test_a_foreign_format_is_named_with_the_way(tmp_path, name):
    data, text = CASES[name]
    for each in (name, "map.png"):
        if each != name and name == "a.nef":  # a TIFF, but for its name
            continue
        (tmp_path / each).write_bytes(data + bytes(64))
        with pytest.raises(nm.InputError, match=rf"{each}: {text}") as caught:
            nm.read_raster(tmp_path / each)
        assert "\n" not in str(caught.value)


def test_every_entry_of_the_table_is_tried():
    for one in FOREIGN_FORMATS:
        assert any(text.replace("\\", "").startswith(one.what.split(",")[0][:12]) for _, text in CASES.values()), (
            one.what
        )


def test_the_tables_do_not_claim_each_other():
    for foreign in FOREIGN_FORMATS:
        for at, magic in foreign.magic:
            head = bytes(at) + magic
            assert not any(one.begins(head) for one in READ_FORMATS)


def test_help_lists_the_formats_of_the_table(run, wide_help):
    shown = " ".join(run("inspect", "--help").out.split())
    assert format_names() in shown
    assert format_names().endswith("NumPy .npz or HEIC")


def test_short_or_missing_magic_never_makes_a_text_a_picture():
    assert is_picture(b"\x89PNG\r\n\x1a\n")
    assert is_picture(b"\x93NUMPY\1\0")
    assert not is_picture(b"BM = 3\n")
    assert not is_picture(b"PF = 3\n")
    assert not is_picture(b"# a recipe\n")


def test_standard_input_may_be_of_any_format(tmp_path, dome, monkeypatch, run):
    import io
    import sys
    from types import SimpleNamespace

    import numpy as np

    stream = io.BytesIO()
    np.save(stream, dome().normals.astype(np.float32))
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(stream.getvalue())))
    assert run("compose", "convert", "-", tmp_path / "o.exr").code == 0
    assert np.abs(nm.read_raster(tmp_path / "o.exr").pixels - dome().normals).max() < 1e-6
