"""HEIC photos with and without a depth image; the container is put together here around two tiny coded pictures."""

import base64
import struct
import sys

import numpy as np
import pytest

import nmaptool as nm

# 64 x 64 px each, coded once: a photo of one colour, about (90, 140, 200), and a grey ramp of 4 times the column
PHOTO_HEADER = (
    "0RwOV0058x000009`FGC{rLC*01pFT0096PKmiN^|NjGU00093kN^M!000939=ZZRVE_RDD?$MQ18@KU0|1Z!00RI30{|YNAb|yz>PacCZUPz%"
    "2mk;B0LTCU0{{p>VgLaE2SfqEa<C#m"
)
PHOTO_DATA = "0000LC;_h-fcJcbH?)mm9!zfjm=)sDzy"
RAMP_HEADER = (
    "0R#vD005u(000009`FGC{P_3)01pFT0096OKmiN^|NjIC00093pZEX(0{{RXx&lC90096dLID8;2mk;B0H62(00RI39>9VG7F($#rn#^n00096"
    "AOHXZ03l)k0RRU?0l{*xB0v"
)
RAMP_DATA = (
    "0001RC;_evaPgK~lYgkS;B@d*IZQsxvj6;(i@C2mY|(#!N8_l^!_i{Y_%KzT{oKGJ!+~VrT0#QKkLV`)pvd%>Y&o#A1y4WgfEIC6=lb%&I7zna"
    "RM1!t^;&43*Gx+VilO|tFynC>CkWvlHZDCc"
)
DEPTH_TYPE = b"urn:mpeg:hevc:2015:auxid:2\0"


def box(kind, *parts):
    body = b"".join(parts)
    return struct.pack(">I", 8 + len(body)) + kind + body


def full(kind, *parts, version=0):
    return box(kind, bytes([version, 0, 0, 0]), *parts)


def heic(depth=True, size=(64, 64)):
    """The bytes of a photo; its depth image is an auxiliary image of the usual type."""
    coded = [
        [base64.b85decode(text) for text in one] for one in ((PHOTO_HEADER, PHOTO_DATA), (RAMP_HEADER, RAMP_DATA))
    ][: 2 if depth else 1]
    spatial = full(b"ispe", struct.pack(">II", *size))
    properties = [spatial, *(box(b"hvcC", header) for header, _ in coded), full(b"auxC", DEPTH_TYPE)]
    places = struct.pack(">I", len(coded))
    for number in range(len(coded)):
        own = [1, 0x80 | (number + 2), *([len(properties)] if number else [])]
        places += struct.pack(">HB", number + 1, len(own)) + bytes(own)
    names = [full(b"infe", struct.pack(">HH", n + 1, 0), b"hvc1\0", version=2) for n in range(len(coded))]
    links = [full(b"iref", box(b"auxl", struct.pack(">HHH", 2, 1, 1)))] if depth else []

    def meta(start):
        offsets = struct.pack(">HH", 0x4400, len(coded))
        for number, (_, data) in enumerate(coded):
            offsets += struct.pack(">HHHII", number + 1, 0, 1, start, len(data))
            start += len(data)
        return full(
            b"meta",
            full(b"hdlr", bytes(4), b"pict", bytes(13)),
            full(b"pitm", struct.pack(">H", 1)),
            full(b"iloc", offsets),
            full(b"iinf", struct.pack(">H", len(coded)), *names),
            *links,
            box(b"iprp", box(b"ipco", *properties), full(b"ipma", places)),
        )

    head = box(b"ftyp", b"heic", bytes(4), b"mif1heic")
    start = len(head) + len(meta(0)) + 8
    return head + meta(start) + box(b"mdat", *(data for _, data in coded))


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "a.heic"
    path.write_bytes(heic())
    return path


def test_the_depth_image_of_a_photo_is_read_as_depth(photo):
    ramp = np.tile(np.arange(64) * 4, (64, 1))
    for image in (nm.read_raster(photo, holds="depth"), nm.read_raster(f"{photo}:depth")):
        assert image.name == f"{photo}:depth"
        assert image.channels == ("Y",)
        assert image.lossy
        assert np.abs(image.pixels[..., 0].astype(int) - ramp).mean() < 4
        assert image.notes == ("is the depth image of 64 x 64 px in a photo of 64 x 64 px",)


def test_the_photo_itself_is_read_and_says_so(photo):
    for name in (photo, f"{photo}:photo"):
        image = nm.read_raster(name)
        assert image.channels == ("R", "G", "B")
        assert np.abs(image.pixels.reshape(-1, 3).mean(axis=0) - (90, 140, 200)).max() < 6
        assert image.notes == ("is a photo", "also holds a depth image: a.heic:depth")
    with pytest.raises(nm.InputError, match=r"has no layer 'gain'; it holds: photo, depth"):
        nm.read_raster(f"{photo}:gain")


def test_a_photo_without_depth_is_refused_as_depth(tmp_path):
    (tmp_path / "b.heic").write_bytes(heic(depth=False))
    with pytest.raises(nm.InputError, match=r"is a photo without a depth image \(portrait mode stores one\)"):
        nm.read_raster(tmp_path / "b.heic", holds="depth")
    assert nm.read_raster(tmp_path / "b.heic").notes == ("is a photo",)
    assert nm.read_raster(f"{tmp_path / 'b.heic'}:photo", holds="depth").channels == ("R", "G", "B")


def test_without_the_reader_the_message_names_it(photo, monkeypatch):
    monkeypatch.setitem(sys.modules, "pi_heif", None)
    monkeypatch.setitem(sys.modules, "pillow_heif", None)
    with pytest.raises(nm.InputError, match=r'install the reader: pip install "nmaptool-relief\[heic\]"'):
        nm.read_raster(photo)


def test_the_limit_applies_before_the_photo_is_decoded(tmp_path):
    (tmp_path / "a.heic").write_bytes(heic(size=(64, 64)))
    with pytest.raises(nm.LimitError, match=r"64 x 64 is 0\.0041 megapixels, more than the limit of 0\.002"):
        nm.read_raster(tmp_path / "a.heic", nm.ReadOptions(max_megapixels=0.002))


def test_every_truncation_is_refused(photo):
    data = photo.read_bytes()
    for size in [*range(12, len(data), 17), len(data) - 1]:
        photo.write_bytes(data[:size])
        for holds in ("normals", "depth"):
            if holds == "normals" and size >= len(data) - 124:  # the photo is complete, its depth image is not
                continue
            with pytest.raises(nm.InputError, match=r"a\.heic: "):
                nm.read_raster(photo, holds=holds)


def test_the_depth_of_a_photo_becomes_a_normal_map(photo, run, tmp_path):
    done = run("compose", "depth", photo, "-o", tmp_path / "d.exr", "--depth-scale", "16px")
    assert (done.code, done.err) == (0, done.err)
    assert "a.heic:depth" in done.err
    normals = nm.read_normal_map(tmp_path / "d.exr").normals[8:-8, 8:-8]
    slope = (-normals[..., 0] / normals[..., 2]).mean()
    assert abs(slope - 16 / 63) < 0.03
