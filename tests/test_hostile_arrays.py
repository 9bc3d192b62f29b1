"""Array files that lie about themselves, hold no picture, or are other archives."""

import io
import sys
import tracemalloc
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest

import nmaptool as nm


def hostile(header, version=1, data=bytes(4096)):
    size = len(header).to_bytes(2 if version == 1 else 4, "little")
    return b"\x93NUMPY" + bytes([version, 0]) + size + header + data


def test_a_header_in_an_archive_is_not_unpacked_beyond_its_limit(tmp_path):
    header = b"{'descr': '<f4', 'fortran_order': False, 'shape': (10, 10), }" + b" " * (64 << 20)
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.npy", hostile(header, 2))
    del header
    tracemalloc.start()
    with pytest.raises(nm.InputError, match=r"a\.npz:a: is not a NumPy array file, or is truncated"):
        nm.read_raster(tmp_path / "a.npz")
    assert tracemalloc.get_traced_memory()[1] < 8 << 20
    tracemalloc.stop()


def test_data_of_other_types_are_not_unpacked(tmp_path):
    header = b"{'descr': '|S500000', 'fortran_order': False, 'shape': (20, 20), }"
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.npy", hostile(header, data=bytes(64 << 20)))
    tracemalloc.start()
    with pytest.raises(nm.InputError, match=r"a\.npz:a: stores \|S500000 values; save plain integers or floats"):
        nm.read_raster(tmp_path / "a.npz")
    assert tracemalloc.get_traced_memory()[1] < 8 << 20
    tracemalloc.stop()


@pytest.mark.parametrize("shape", ["(True, 4)", "(-1, 4)", "(4, 4.0)", "'44'"])
def test_a_shape_must_be_of_whole_numbers(tmp_path, shape):
    text = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}"
    (tmp_path / "a.npy").write_bytes(hostile(text.encode()))
    with pytest.raises(nm.InputError, match=r"a\.npy: is not a NumPy array file, or is truncated; save it again"):
        nm.read_raster(tmp_path / "a.npy")


def test_raw_bytes_are_no_picture(tmp_path):
    (tmp_path / "a.npy").write_bytes(hostile(b"{'descr': '|V4', 'fortran_order': False, 'shape': (4, 4, 3), }"))
    with pytest.raises(nm.InputError, match=r"stores \|V4 values; save plain integers or floats"):
        nm.read_raster(tmp_path / "a.npy")


def test_signalling_nan_is_read_without_a_warning(tmp_path):
    values = np.full((4, 5), 0x7FF0000000000001, np.uint64).view(np.float64)
    np.save(tmp_path / "a.npy", values)
    assert np.isnan(nm.read_raster(tmp_path / "a.npy", holds="depth").pixels).all()


def test_an_archive_in_which_nothing_is_a_picture_says_so(tmp_path):
    np.savez(tmp_path / "a.npz", camera=np.eye(3)[:, 0], names=np.array(["x"]))
    with pytest.raises(nm.InputError, match=r"none of its arrays \(camera, names\) is a picture; accepted are \(rows"):
        nm.read_raster(tmp_path / "a.npz")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.zip", r"is a ZIP archive; unpack it and give the picture in it"),
        ("a.3mf", r"is a mesh; render its maps first with nmap bake"),
        ("a.npz", r"is a ZIP archive without NumPy arrays"),
    ],
)
def test_other_archives_are_not_called_arrays(tmp_path, name, text):
    with zipfile.ZipFile(tmp_path / name, "w") as archive:
        archive.writestr("map.png", b"x")
    with pytest.raises(nm.InputError, match=rf"{name}: {text}"):
        nm.read_raster(tmp_path / name)
    with pytest.raises(nm.InputError, match=r"is not a workspace in a supported format; export it as PSD, PSB, ORA"):
        nm.read_workspace(tmp_path / name)


def test_an_array_from_standard_input_is_not_named_by_its_temporary_file(tmp_path, dome, run, monkeypatch):
    np.savez(tmp_path / "a.npz", normal=dome(24, 30).normals, other=np.ones((24, 30)))
    data = (tmp_path / "a.npz").read_bytes()
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(data)))
    assert run("inspect", "-").out.startswith("standard input:normal: 30 x 24")
