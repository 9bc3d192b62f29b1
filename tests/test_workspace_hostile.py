"""Malicious and lying workspace files: one clear line each, before memory is allocated."""

import struct
import zipfile

import numpy as np
import pytest
from workspace_cases import bumpy, random_workspace

import nmaptool as nm

STACK = '<image w="8" h="8"><stack>{}</stack></image>'
LAYER = '<layer name="a" src="data/a.png"/>'
ONE = STACK.format(LAYER)


@pytest.fixture
def ora(tmp_path, png):
    """``ora(entries, stack=..., compression=...)`` writes a zip with these entries; data/a.png is a valid image."""

    def write(entries=(), stack=ONE, drop=(), compression=zipfile.ZIP_STORED):
        codes = np.full((8, 8, 3), 32768, np.uint16)
        good = {
            "mimetype": b"image/openraster",
            "data/a.png": png(tmp_path / "a.png", codes).read_bytes(),
            "stack.xml": stack.encode() if isinstance(stack, str) else stack,
        }
        path = tmp_path / "a.ora"
        with zipfile.ZipFile(path, "w", compression) as archive:
            for name, data in good.items():
                if name not in drop:
                    archive.writestr(name, data)
            for name, data in entries:
                archive.writestr(name, data)
        return path

    return write


def refuses(path, pattern, error=nm.InputError, limit=270.0):
    with pytest.raises(error, match=pattern) as caught:
        nm.read_workspace(path, max_megapixels=limit)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)
    if error is nm.InputError:
        assert not isinstance(caught.value, nm.LimitError)


def test_a_valid_ora_is_read(ora):
    assert nm.read_workspace(ora()).layers[0].size == (8, 8)


@pytest.mark.parametrize("name", ["../../etc/x.png", "/etc/x.png", "data/../../x.png", "c:/x.png", "a\\..\\b.png"])
def test_paths_that_point_outside_are_refused(ora, name):
    refuses(ora([(name, b"x")]), "whose path is not safe; save it again")


def test_links_are_refused(ora):
    link = zipfile.ZipInfo("data/link.png")
    link.external_attr = 0o120777 << 16
    refuses(ora([(link, b"/etc/passwd")]), "holds the link 'data/link.png'; save it again without links")


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_two_entries_of_one_name_are_refused(ora):
    refuses(ora([("data/a.png", b"x")]), r"holds two entries named 'data/a\.png'")


def test_encrypted_entries_and_unknown_compression_are_refused(ora):
    path = ora()
    data = bytearray(path.read_bytes())
    at = data.find(b"PK\1\2")
    data[at + 8] |= 1
    path.write_bytes(data)
    refuses(path, "holds the encrypted entry 'mimetype'; save it without a password")
    refuses(ora(compression=zipfile.ZIP_BZIP2), "has an unsupported compression; save it again")


def test_a_zip_bomb_is_refused_by_its_claimed_size(ora):
    path = ora([("nmaptool.json", b" " * 40_000_000)], compression=zipfile.ZIP_DEFLATED)
    assert path.stat().st_size < 100_000
    refuses(path, r"entry 'nmaptool\.json' unpacks to 40 MB, more than the limit of 16 MB", nm.LimitError)


def test_a_zip_bomb_that_lies_about_its_size_is_refused(ora):
    path = ora([("nmaptool.json", b" " * 40_000_000)], compression=zipfile.ZIP_DEFLATED)
    data = path.read_bytes()
    path.write_bytes(data.replace(struct.pack("<I", 40_000_000), struct.pack("<I", 1000)))
    refuses(path, "truncated or damaged")
    path.write_bytes(data.replace(struct.pack("<I", 40_000_000), struct.pack("<I", 4_000_000_000)))
    refuses(path, "declares a larger size than its data can unpack to")


def test_too_many_entries_and_lying_directories_are_refused(ora):
    refuses(ora([(f"{i}", b"") for i in range(20_001)]), "declares 20004 entries", nm.LimitError)
    path = ora()
    data = bytearray(path.read_bytes())
    end = data.rfind(b"PK\5\6")
    data[end + 12 : end + 16] = struct.pack("<I", 0xFFFFFFF0)
    path.write_bytes(data)
    refuses(path, "entries; the limit is 20000", nm.LimitError)
    data[end + 10 : end + 16] = b"\xff" * 6
    path.write_bytes(data)
    refuses(path, "64-bit ZIP archive", nm.LimitError)


@pytest.mark.parametrize(
    "text",
    [
        '<!DOCTYPE image [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>' + STACK.format('<layer name="&b;"/>'),
        '<!DOCTYPE image SYSTEM "file:///etc/passwd">' + STACK.format(LAYER),
    ],
)
def test_document_types_and_entities_are_refused(ora, text):
    refuses(ora(stack=text), r"stack\.xml: declares a document type or entities")


@pytest.mark.parametrize(
    ("stack", "message"),
    [
        (b"\xff\xfe<\0", r"stack\.xml: is damaged"),
        ("<image", r"stack\.xml: is damaged"),
        ("<svg/>", "truncated or damaged"),
        ('<image w="0" h="8"><stack/></image>', "has w=0, which is out of range"),
        ('<image w="nan" h="8"><stack/></image>', "has w=nan, which is out of range"),
        ('<image w="x" h="8"><stack/></image>', "truncated or damaged"),
        (STACK.format('<layer name="a" src="data/b.png"/>'), r"lists 'data/b\.png' but does not contain it"),
        (STACK.format('<layer src="data/a.png" x="1e30"/>'), "has x=1e.30, which is out of range"),
        (STACK.format('<layer src="data/a.png" opacity="half"/>'), "truncated or damaged"),
        (STACK.format(""), "has no pixel layer"),
        (STACK.format("<stack>" * 80 + "</stack>" * 80), "nested more than 64 levels deep"),
    ],
)
def test_invalid_layer_lists_are_refused(ora, stack, message):
    refuses(ora(stack=stack), message)


def test_sizes_over_the_limit_are_refused(ora, tmp_path, png):
    big = '<image w="100000" h="100000"><stack/></image>'
    refuses(ora(stack=big), "100000 x 100000 is 10000 megapixels, more than the limit of 270", nm.LimitError)
    huge = png(tmp_path / "b.png", np.zeros((8, 8, 3), np.uint8), size=(60_000, 60_000)).read_bytes()
    one = STACK.format('<layer name="b" src="b.png"/>')
    refuses(ora([("b.png", huge)], stack=one), "layer 'b': 60000 x 60000 is 3600 megapixels", nm.LimitError)
    # one small image, listed a thousand times
    refuses(ora(stack=STACK.format(LAYER * 1000)), "hold more than 0.01 megapixels together", nm.LimitError, 0.01)
    refuses(ora(stack=STACK.format(LAYER * 8001)), "holds 8001 layers", nm.LimitError)


def test_zips_that_are_not_ora_are_refused(ora):
    refuses(ora(drop=("stack.xml",)), r"is a ZIP archive without stack\.xml, not an OpenRaster file")
    refuses(ora([("mimetype", b"application/zip")], drop=("mimetype",)), "is a ZIP archive but not an OpenRaster file")
    refuses(ora([("data/a.png", b"hello")], drop=("data/a.png",)), "truncated or damaged")


def patched(path, at, data):
    raw = bytearray(path.read_bytes())
    raw[at : at + len(data)] = data
    path.write_bytes(raw)
    return path


@pytest.fixture
def psd(tmp_path):
    path = tmp_path / "a.psd"
    nm.write_workspace(random_workspace(), path)
    return path


@pytest.mark.parametrize(
    ("at", "data", "message"),
    [
        (24, b"\0\4", "is a CMYK picture; normal maps need RGB"),
        (24, b"\0\1", "is a grey picture"),
        (24, b"\0\x63", "is a picture of an unknown colour mode"),
        (22, b"\0\1", "has a depth of 1 per channel; use 8, 16 or 32 bits"),
        (12, b"\0\0", "truncated or damaged"),
        (14, b"\0\0\0\0", "truncated or damaged"),
    ],
)
def test_damaged_psd_headers_are_refused(psd, at, data, message):
    refuses(patched(psd, at, data), message)


def test_psd_sizes_over_the_limit_are_refused(psd):
    refuses(patched(psd, 14, struct.pack(">II", 300_000, 300_000)), "300000 x 300000 is 90000", nm.LimitError)
    patched(psd, 14, struct.pack(">II", 90, 100))
    refuses(psd, "its layers and masks hold more than 0.0095 megapixels", nm.LimitError, 0.0095)
    record = struct.pack(">4i", 0, 0, 90, 100)
    at = psd.read_bytes().find(record)
    refuses(patched(psd, at, struct.pack(">4i", 0, 0, 30_000, 30_000)), "layer 'base': 30000 x 30000", nm.LimitError)
    refuses(
        patched(psd, at, struct.pack(">4i", -(2**31), 0, 2**31 - 1, 1)), "the limit is 300000 px a side", nm.LimitError
    )


@pytest.mark.parametrize("name", ["a.psd", "a.ora", "a.tif", "a.exr"])
def test_truncated_workspaces_are_refused(tmp_path, name):
    nm.write_workspace(random_workspace(np.float32 if name == "a.exr" else np.uint16), tmp_path / name)
    data = (tmp_path / name).read_bytes()
    for share in (0.1, 0.5, 0.9):
        (tmp_path / name).write_bytes(data[: int(len(data) * share)])
        refuses(tmp_path / name, "truncated or damaged|cannot be decoded|header claims more")


def test_wrong_endings_and_other_files_are_refused(tmp_path, psd):
    refuses(psd.rename(tmp_path / "b.ora"), r"holds PSD data; rename it to b\.psd")
    for name, data, message in (
        ("a.xcf", b"gimp xcf v011\0", "is in GIMP's own format, which is not supported; export it as PSD"),
        ("a.psd", b"hello world", "is not a workspace in a supported format; export it as PSD, PSB, ORA, TIFF or EXR"),
        ("b.psd", b"", "is empty"),
    ):
        (tmp_path / name).write_bytes(data)
        refuses(tmp_path / name, message)
    refuses(tmp_path / "missing.psd", "no such file")
    refuses(tmp_path, "is a folder; give a workspace file")


def test_tiff_pages_over_the_limit_in_total_are_refused(tmp_path):
    nm.write_workspace(nm.pack([bumpy()] * 4), tmp_path / "a.tif")
    refuses(tmp_path / "a.tif", "hold more than 0.1 megapixels together", nm.LimitError, 0.1)
    nm.write_workspace(nm.pack([bumpy()] * 4, nm.PackOptions(bits=32)), tmp_path / "a.exr")
    refuses(tmp_path / "a.exr", "hold 0.115 megapixels together, more than the limit of 0.1", nm.LimitError, 0.1)
