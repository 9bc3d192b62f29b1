"""Reading fonts: files and names of installed fonts."""

from __future__ import annotations

import io
import zlib
from pathlib import Path

import matplotlib
import pytest
from fontTools.ttLib import TTCollection, TTFont

import nmaptool as nm
from nmaptool.io import fonts
from nmaptool.lettering.place import straight
from nmaptool.lettering.shaping import lay_out

FOLDER = Path(matplotlib.get_data_path()) / "fonts" / "ttf"


def test_installed_fonts_are_found_by_family_and_properties():
    for name, file in {
        "DejaVu Serif:bold": "DejaVuSerif-Bold.ttf",
        "dejavu sans": "DejaVuSans.ttf",
        "DejaVu Sans : Bold : oblique": "DejaVuSans-BoldOblique.ttf",
        "DejaVu Serif:italic": "DejaVuSerif-Italic.ttf",
    }.items():
        font = nm.read_font(name)
        assert font.name == f"{name} ({file})"
        assert len(font.data) == (FOLDER / file).stat().st_size


def test_files_are_read(tmp_path):
    font = nm.read_font(FOLDER / "DejaVuSans.ttf")
    assert font.data == (FOLDER / "DejaVuSans.ttf").read_bytes()
    assert repr(font) == f"<Font {FOLDER / 'DejaVuSans.ttf'}, {len(font.data)} bytes>"
    odd = tmp_path / "a#1"
    odd.write_bytes(font.data)
    assert nm.read_font(odd).data == nm.read_font(str(odd)).data == font.data


def test_a_font_of_a_collection_is_chosen_by_number(tmp_path):
    collection = TTCollection()
    collection.fonts = [TTFont(FOLDER / "DejaVuSans.ttf"), TTFont(FOLDER / "DejaVuSerif-Bold.ttf")]
    path = tmp_path / "both.ttc"
    collection.save(path)

    def area(font):
        return straight([lay_out(font, "H", 3.0)]).area_mm2

    assert area(nm.read_font(path)) == area(nm.read_font(f"{path}#0")) == area(nm.read_font("DejaVu Sans"))
    assert area(nm.read_font(f"{path}#1")) == area(nm.read_font("DejaVu Serif:bold"))
    with pytest.raises(nm.InputError, match=r"both.ttc#2: has 2 fonts, numbered from 0"):
        nm.read_font(f"{path}#2")


def without(*tables):
    """Bytes of a font from which tables were removed."""
    opened = TTFont(FOLDER / "DejaVuSans.ttf")
    for table in tables:
        del opened[table]
    stream = io.BytesIO()
    opened.save(stream)
    return stream.getvalue()


FILES = {
    "a.ttf": (b"no font at all", r"a.ttf: is not a TrueType or OpenType font \(it begins with b'no f'\)"),
    "b.woff2": (b"wOF2" + bytes(50), r"b.woff2: is a web font \(WOFF2\); give the TrueType or OpenType file"),
    "c.woff": (b"wOFF" + zlib.compress(bytes(9)), r"c.woff: is a web font \(WOFF\)"),
    "d.otf": (b"OTTO" + bytes(60), r"d.otf: is damaged \(no table of characters or no glyphs\)"),
    "e.ttf": (b"", r"e.ttf: is empty"),
    "f.ttf": (None, r"f.ttf: no such file"),
    "g.ttf": (lambda: without("glyf", "loca"), r"g.ttf: holds pictures of glyphs, not outlines"),
    "h.ttf": (lambda: without("cmap"), r"h.ttf: is damaged \(no table of characters"),
    "i.ttc": (b"ttcf" + bytes(60), r"i.ttc#0: has 0 fonts"),
    "j.ttf": (lambda: (FOLDER / "DejaVuSans.ttf").read_bytes()[:9000], r"j.ttf: is damaged"),
}


@pytest.mark.parametrize("name", FILES)
def test_files_that_are_no_fonts_are_refused(tmp_path, name):
    data, message = FILES[name]
    if data is not None:
        (tmp_path / name).write_bytes(data() if callable(data) else data)
    with pytest.raises(nm.InputError, match=message):
        nm.read_font(str(tmp_path / name))


def test_fonts_that_are_too_large_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(fonts, "_LARGEST", 1000)
    with pytest.raises(nm.InputError, match=r"has \d+ bytes, more than 1000 bytes; give a smaller font"):
        nm.read_font(FOLDER / "DejaVuSans.ttf")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("DejaVoo Sans", "font 'DejaVoo Sans': is not installed; installed are DejaVu Sans"),
        ("zzzzzzz", r"font 'zzzzzzz': is not installed; give a font file \(.ttf, .otf\), or a name such as 'DejaVu"),
        (
            "DejaVu Serif:thin",
            "font 'DejaVu Serif:thin': is not installed; installed are DejaVu Serif, DejaVu Serif:bold",
        ),
        ("DejaVu Serif:bolder", "font 'DejaVu Serif:bolder': 'bolder' is not a property; use thin, extralight"),
    ],
)
def test_another_font_never_takes_the_place_of_one_that_is_missing(name, message):
    with pytest.raises(nm.InputError, match=message):
        nm.read_font(name)
