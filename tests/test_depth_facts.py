"""The metadata of a depth file are read once, into values that everything else uses."""

import json

import numpy as np
import pytest
from depth_cases import grid

import nmaptool as nm
from nmaptool.io.pictures.metadata import depth_facts
from nmaptool.io.pictures.writer import write_image


def bowl():
    x, y = grid(40, 50)
    return (100 + (x * x + y * y) / 90).astype(np.float32)[..., None]


def test_json_text_alone_does_not_affect_the_depths():
    text = {"kind": "depth", "pitch_mm": "0.5", "recipe": json.dumps({"fov": 50.0})}
    plain = nm.RasterImage(bowl(), ("Y",), bits=32, attributes={"pitch_mm": "0.5"})
    result = nm.depth_to_normals(nm.RasterImage(bowl(), ("Y",), bits=32, attributes=text))
    assert np.array_equal(result.normal_map.normals, nm.depth_to_normals(plain).normal_map.normals)
    assert (result.report.kind, result.report.fov, result.report.fov_from) == ("grey", 0, "assumed")


def test_the_facts_set_the_depths():
    attributes, facts = {"pitch_mm": "0.5"}, nm.DepthFacts("depth", fov_deg=50.0)
    image = nm.RasterImage(bowl(), ("Y",), bits=32, attributes=attributes, depth_facts=facts)
    report = nm.depth_to_normals(image).report
    assert (report.kind, report.fov, report.fov_from, report.inverted_from) == ("depth", 50, "file", "file")
    codes = np.full((20, 30, 1), 30000, np.uint16)
    codes[5:15, 5:15] = 60000
    facts = nm.DepthFacts("height", black_mm=1.0, white_mm=3.0)
    image = nm.RasterImage(codes, ("Y",), bits=16, attributes=attributes, depth_facts=facts)
    report = nm.depth_to_normals(image, nm.DepthOptions(background="none")).report
    assert report.scale_px == pytest.approx(2 / 0.5)
    assert report.range_px == pytest.approx(2 / 0.5 * 30000 / 65535)


@pytest.mark.parametrize("ending", ["exr", "png", "tif"])
def test_reading_a_file_gives_its_facts(tmp_path, ending):
    path = tmp_path / f"depth.{ending}"
    recipe = json.dumps({"fov": 35, "view": "front"})
    said = {"kind": "depth", "near_mm": "90.5", "far_mm": "120.25", "recipe": recipe}
    pixels = bowl() if ending == "exr" else np.zeros((40, 50, 1), np.uint16)
    write_image(pixels, path, ("Y",), said)
    assert nm.read_raster(path).depth_facts == nm.DepthFacts("depth", black_mm=120.25, white_mm=90.5, fov_deg=35.0)
    write_image(pixels, path, ("Y",), {"kind": "height", "height_min_mm": "-1", "height_max_mm": "2", "recipe": recipe})
    assert nm.read_raster(path).depth_facts == nm.DepthFacts("height", black_mm=-1.0, white_mm=2.0)
    write_image(pixels, path, ("Y",), {"kind": "mask", "near_mm": "1"})
    assert nm.read_raster(path).depth_facts is None


@pytest.mark.parametrize(
    "recipe", ["", "{", "[1]", '{"fov": "wide"}', '{"fov": null}', '{"fov": NaN}', "[" * 100_000, '{"fov": [1]}']
)
def test_damaged_facts_count_as_missing(recipe):
    said = {"kind": "depth", "near_mm": "near", "far_mm": "inf", "recipe": recipe}
    assert depth_facts(said) == nm.DepthFacts("depth")
