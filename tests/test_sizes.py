"""Sizes that can hardly be meant are said, with the option that sets them."""

import dataclasses

import numpy as np
import pytest
from mesh_cases import sphere
from relief_cases import dome, solve

import nmaptool as nm

TINY = "the mesh is {} mm large if its units are mm; set its `unit`, or `width='100mm'`"


def sized(longest, **changes):
    """A ball of a size, rendered small."""
    mesh = sphere(8, longest / 2)
    return dataclasses.replace(mesh, **changes)


def bake(mesh, **options):
    baked = nm.bake(mesh, nm.BakeOptions(size="48x40", renderer="numpy", **options), nm.FilterOptions(sigma_s="2%"))
    return [warning for warning in baked.report.warnings if "large" in warning], baked


@pytest.mark.parametrize(("longest", "said"), [(1, "1"), (4.9, "4.9"), (0.02, "0.02"), (6000, "6000")])
def test_units_are_doubted_only_if_they_were_assumed(longest, said):
    assert bake(sized(longest))[0] == [TINY.format(said)]
    assert bake(sized(longest, unit_from="given"))[0] == []
    assert bake(sized(longest), width="80mm")[0] == []
    assert bake(sized(longest), pitch=f"{longest / 40}mm")[0] == []
    assert bake(sized(longest, unit_from="file"))[0] == []


def test_a_scene_as_large_as_a_district_is_doubted():
    said = "the mesh is 80 m large by the units of its file; set its `unit`, or `width='100mm'`"
    assert bake(sized(80, mm_per_unit=1000.0, unit_from="file"))[0] == [said]
    assert bake(sized(30, mm_per_unit=1000.0, unit_from="file"))[0] == []


def doubts(relief):
    return [warning for warning in relief.report.warnings if "picture" in warning and "width" in warning]


def with_pitch(pitch_mm):
    original = dome()[0]
    return dataclasses.replace(original, frame=dataclasses.replace(original.frame, pitch_mm=pitch_mm))


def test_a_relief_higher_than_its_picture_is_doubted():
    remedy = "use a larger `width`, such as `width='80mm'`, or a smaller `height`"
    found = doubts(solve(with_pitch(0.01), height=nm.length("4mm")))
    assert found == [f"the relief is 4 mm high, but the picture only 0.96 x 0.96 mm by the size in the file; {remedy}"]
    found = doubts(solve(dome()[0], height=nm.length("150mm")))
    assert found == [f"the relief is 150 mm high, but the picture only 100 x 100 mm as assumed; {remedy}"]
    found = doubts(solve(dome()[0], height=nm.length("4mm"), width=nm.length("3mm")))
    assert found == [f"the relief is 4 mm high, but the picture only 3 x 3 mm; {remedy}"]
    assert doubts(solve(with_pitch(0.1), height=nm.length("4mm"))) == []
    assert doubts(solve(dome()[0], height=nm.length("4mm"))) == []


def test_a_picture_without_a_likely_size_is_doubted():
    for pitch, size in ((0.02, "1.92 x 1.92 mm"), (100.0, "9600 x 9600 mm")):
        found = doubts(solve(with_pitch(pitch), height=nm.length("1mm")))
        assert found == [f"the picture is {size} by the size in the file; set its `width`, such as `width='80mm'`"]
    assert doubts(solve(with_pitch(0.02), height=nm.length("1mm"), width=nm.length("2mm"))) == []


def test_a_mesh_of_one_unit_is_doubted_up_to_its_relief():
    found, layers = bake(sized(1))
    relief = nm.relief(layers.original, options=nm.ReliefOptions(height=nm.length("4mm")))
    assert len(found) == len(doubts(relief)) == 1
    assert np.ptp(relief.z_mm) == pytest.approx(4)
