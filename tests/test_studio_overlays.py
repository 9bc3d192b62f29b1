"""Overlays of the composed map: what the page gets of its curl and its coverage."""

import json
import struct

import numpy as np
import pytest
from stack_cases import write_maps
from test_studio_server import ask, served, until

import nmaptool as nm
from nmaptool.figures.curl import curl_codes
from nmaptool.studio.document import opened
from nmaptool.studio.engine import Engine
from nmaptool.studio.overlays import MOST_PX, overlay


class Ready:
    """A worker whose engine has read the maps of a document."""

    def __init__(self, document):
        self.engine = Engine(document)

    def engine_of(self, document):
        return self.engine if self.engine.fits(document) else None


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


def unpacked(data):
    cols, rows = struct.unpack_from("<II", data)
    return np.frombuffer(data, np.uint8, offset=8).reshape(rows, cols)


def test_the_overlays_are_those_of_the_composed_map(folder):
    with served(folder / "bunny.exr") as client:
        with client.live() as live:
            until(live, "frame")
        composed = nm.read_normal_map(folder / "bunny.exr")
        curl = client.get("/overlay/curl")
        assert (curl.status, curl.getheader("content-type")) == (200, "application/octet-stream")
        assert np.array_equal(unpacked(curl.body), curl_codes(composed))
        coverage = unpacked(client.get("/overlay/coverage").body)
        assert np.array_equal(coverage, np.rint(composed.coverage * 255))
        assert client.get("/overlay/curl", {}).status == 403


def test_frames_tell_when_the_maps_changed(folder):
    with served(folder / "bunny.exr") as client, client.live() as live:
        first = until(live, "frame")[0]
        assert first["full"] == [30, 40]
        ask(live, do="set", values={"beta": 0.05})
        assert until(live, "frame")[0]["maps"] == first["maps"]


def test_other_overlays_and_maps_that_cannot_be_read_are_refused_in_one_line(tmp_path, folder):
    with served(folder / "bunny.exr") as client:
        answer = client.get("/overlay/warmth")
        assert answer.status == 400
        assert json.loads(answer.body)["text"] == "`warmth`: is not an overlay; the studio has curl and coverage"
    (tmp_path / "bad.png").write_bytes(b"no picture")
    with served(tmp_path / "bad.png") as client:
        answer = client.get("/overlay/curl")
        assert answer.status == 400
        assert "have not been read yet" in json.loads(answer.body)["text"]


def test_large_maps_keep_thin_lines_of_curl(tmp_path, png):
    rows, cols = 300, 2500
    normals = np.zeros((rows, cols, 3))
    normals[..., 2] = 1
    normals[100:, :, 0] = 0.6  # a slope across that ends at a row: curl along it
    normals[100:, :, 2] = 0.8
    png(tmp_path / "flat.png", np.rint((normals + 1) * 127.5).astype(np.uint8))
    document = opened([str(tmp_path / "flat.png")])
    found = unpacked(overlay(Ready(document), document, "curl"))
    assert found.shape == (round(rows * MOST_PX / cols), MOST_PX)
    bright = np.flatnonzero((found > 200).all(axis=1))
    assert abs(bright.mean() / len(found) - 100 / rows) < 0.02
    assert found[: bright[0] - 1].max() < 60
    assert unpacked(overlay(Ready(document), document, "coverage")).shape == found.shape
