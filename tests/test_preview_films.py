"""Films of reliefs, read back, and contact sheets."""

import itertools

import cv2
import numpy as np
import pytest
from PIL import Image
from preview_cases import cone, disc

import nmaptool as nm
from nmaptool.core.errors import OutputError, UsageError
from nmaptool.figures.labelled import labelled_sheet
from nmaptool.figures.preview import film

FILMS = {"turntable": {"turntable": True}, "sweep": {"light_sweep": True}}
FILMS["sweep in perspective"] = {"light_sweep": True, "view": "iso"}


@pytest.mark.parametrize("words", FILMS.values(), ids=FILMS)
def test_the_pictures_of_a_film_have_one_size_and_differ(words):
    pictures = list(film(disc(), nm.PreviewOptions(frames=4, size=96, **words)))
    assert len(pictures) == 4
    assert len({picture.shape for picture in pictures}) == 1
    for first, second in itertools.pairwise(pictures):
        assert np.abs(first.astype(int) - second).mean() > 1


@pytest.mark.parametrize("ending", [".webp", ".gif", ".mp4"])
def test_films_are_read_back_whole(ending, tmp_path):
    path = tmp_path / f"turn{ending}"
    nm.write_preview(disc(), path, nm.PreviewOptions(turntable=True, frames=5, size=97))
    if ending == ".mp4":
        found = cv2.VideoCapture(str(path))
        shown = []
        while (read := found.read())[0]:
            shown.append(read[1])
        assert len(shown) == 5
        assert max(shown[0].shape) == 96  # even sides
        assert found.get(cv2.CAP_PROP_FPS) == pytest.approx(1.25)
        return
    with Image.open(path) as image:
        assert image.n_frames == 5
        assert max(image.size) == 97
        assert image.info["loop"] == 0
        pictures = []
        for number in range(5):
            image.seek(number)
            pictures.append(np.asarray(image.convert("RGB")).astype(int))
            assert image.info["duration"] == 800
    expected = list(film(disc(), nm.PreviewOptions(turntable=True, frames=5, size=97)))
    for picture, drawn in zip(pictures, expected, strict=True):
        assert np.abs(picture - drawn).mean() < 4


def test_a_missing_encoder_is_one_line(tmp_path, monkeypatch):
    class Closed:
        fourcc = staticmethod(lambda *letters: 0)

        def __init__(self, *arguments):
            pass

        def isOpened(self):  # noqa: N802 - the name in OpenCV
            return False

    options = nm.PreviewOptions(light_sweep=True, frames=2, size=32)
    monkeypatch.setattr(cv2, "VideoWriter", Closed)
    with pytest.raises(OutputError, match=r"a.mp4: this OpenCV has no encoder for MP4; write a .webp or a .gif"):
        nm.write_preview(disc(), tmp_path / "a.mp4", options)
    monkeypatch.setattr("PIL.features.check", lambda name: False)
    with pytest.raises(OutputError, match=r"a.webp: this Pillow has no WebP encoder; write a .gif or an .mp4"):
        nm.write_preview(disc(), tmp_path / "a.webp", options)
    assert list(tmp_path.iterdir()) == []


def test_endings_fit_what_is_drawn(tmp_path):
    with pytest.raises(UsageError, match=r"a.gif: a preview is written as .png"):
        nm.write_preview(disc(), tmp_path / "a.gif")
    with pytest.raises(UsageError, match=r"a.png: ends in .png; a film is written as .webp, .gif, .mp4"):
        nm.write_preview(disc(), tmp_path / "a.png", nm.PreviewOptions(turntable=True))


def test_a_contact_sheet_has_a_labelled_cell_for_each(tmp_path):
    values = {"cone.exr": cone(), "disc.exr": disc(), "a name that is much too long for its picture.exr": disc(40)}
    sheet = nm.preview(values, nm.PreviewOptions(size=120))
    rows, cols = sheet.shape[:2]
    assert (rows, cols) == (2 * (120 + 44) + 14, 2 * (120 + 14) + 14)
    single = nm.preview(disc(), nm.PreviewOptions(size=120))
    np.testing.assert_array_equal(sheet[14:134, 14 + 134 : 14 + 134 + 120], single)
    label = sheet[14 + 120 : 14 + 120 + 30, 14:134]
    assert label.max() > 150
    assert (sheet[-30:, -130:] == 26).all()  # the fourth cell is empty
    assert labelled_sheet({"one": single}).shape == (120 + 58, 120 + 28, 3)
