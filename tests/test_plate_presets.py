"""Every preset that makes a plate, from motifs of every kind: a proven solid of the exact size, in STL and 3MF."""

import numpy as np
import pytest
import trimesh
from motif_cases import MOTIFS

import nmaptool as nm
from nmaptool.options.relief_presets import RELIEF_PRESETS

WIDTH_MM = 24.0
PLATES = [name for name, preset in RELIEF_PRESETS.items() if preset.plate]


def made(name, normal_map):
    """The relief and the solid of a preset, 24 mm wide; 0.03 mm of error keep the files small."""
    preset = RELIEF_PRESETS[name]
    design = nm.read_design(
        nm.PlateOptions(**preset.plate), nm.FrameOptions(**preset.frame), machine=nm.MachineOptions(pitch="0.15mm")
    )
    relief = nm.plate(normal_map, options=nm.ReliefOptions(**preset.options, width=f"{WIDTH_MM}mm"), design=design)
    return relief, nm.solid(relief, nm.SolidOptions(**preset.solid, max_error="0.03mm"))


def test_there_is_a_preset_for_each_kind_of_plate():
    assert PLATES == ["coin", "medal", "cameo", "plaque", "pendant", "tile", "box-lid"]
    assert len(MOTIFS) == 8


@pytest.mark.parametrize("motif", MOTIFS)
@pytest.mark.parametrize("name", PLATES)
def test_a_preset_makes_a_proven_solid_of_any_motif(name, motif, tmp_path):
    relief, body = made(name, MOTIFS[motif]())
    report, preset = relief.plate, RELIEF_PRESETS[name]
    longer_mm = max(report.width_mm, report.height_mm)
    assert report.width_mm == pytest.approx(WIDTH_MM, rel=1e-9)
    assert body.is_closed
    assert relief.report.height_range_mm == pytest.approx(
        float(preset.options["height"].rstrip("%")) / 100 * longer_mm, rel=1e-6
    )
    assert report.frame["height_mm"] == pytest.approx(
        float(preset.frame["frame_height"].rstrip("%")) / 100 * longer_mm, rel=1e-6
    )
    size = np.array(body.size_mm)
    loop_mm = sum(2 * hole["rim_mm"] + hole["diameter_mm"] for hole in report.holes if hole["loop"])
    assert size[0] == pytest.approx(WIDTH_MM, abs=2e-4)
    assert -2e-4 <= size[1] - report.height_mm <= loop_mm + 2e-4
    base_mm = float(preset.solid["base"].rstrip("%")) / 100 * longer_mm
    assert size[2] == pytest.approx(base_mm + report.top_mm, abs=1e-6)
    nm.write_relief(relief, tmp_path / "a.stl", tmp_path / "a.3mf", solid=body)  # reads them back and checks them
    for ending in ("stl", "3mf"):
        read = nm.read_mesh(tmp_path / f"a.{ending}")
        mesh = trimesh.Trimesh(read.vertices, read.faces, process=True)
        assert mesh.is_watertight
        assert mesh.is_winding_consistent
        assert mesh.extents == pytest.approx(size, rel=1e-5)
        assert mesh.volume == pytest.approx(body.volume_mm3, rel=1e-4)


def area_of(name, report):
    """The area inside the outline of a preset's plate, from its formula."""
    width, height = report.width_mm, report.height_mm
    preset = RELIEF_PRESETS[name].plate
    if preset["shape"] != "rect":
        return np.pi * width * height / 4
    corner = float(preset.get("corner", "0%").rstrip("%")) / 100 * max(width, height)
    return width * height - (4 - np.pi) * corner**2


@pytest.mark.parametrize("name", [name for name in PLATES if name != "pendant"])
def test_the_outline_of_a_preset_has_the_area_of_its_curve(name):
    relief, _ = made(name, MOTIFS["dome"]())
    outline = relief.height.outline
    assert outline.area_mm2 == pytest.approx(area_of(name, relief.plate), rel=2e-4)


def test_a_pendant_has_a_loop_above_the_plate():
    relief, body = made("pendant", MOTIFS["star"]())
    (loop,) = relief.plate.holes
    assert loop["loop"]
    assert loop["diameter_mm"] == pytest.approx(0.09 * WIDTH_MM)
    assert body.size_mm[1] > WIDTH_MM + loop["diameter_mm"] / 2
    mesh = body.to_mesh()
    shape = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert shape.euler_number == 0  # one hole through the body


def test_a_box_lid_is_hollow():
    _, lid = made("box-lid", MOTIFS["dome"]())
    preset = RELIEF_PRESETS["box-lid"]
    full = nm.solid(made("box-lid", MOTIFS["dome"]())[0], nm.SolidOptions(base=preset.solid["base"]))
    assert lid.volume_mm3 < 0.75 * full.volume_mm3


def test_a_tile_is_covered_and_others_hold_the_motif():
    assert made("tile", MOTIFS["dome"]())[0].plate.fill == "cover"
    for name in ("coin", "cameo", "plaque"):
        report = made(name, MOTIFS["dome"]())[0].plate
        assert report.fill == "inside"
        assert report.motif_width_mm < report.width_mm - 2 * report.frame["width_mm"]
    assert made("plaque", MOTIFS["picture"]())[0].plate.fill == "cover"


def test_a_picture_that_covers_a_cameo_has_no_walls_and_the_report_says_so():
    report = made("cameo", MOTIFS["picture"]())[0].plate
    assert report.fill == "cover"
    assert report.warnings[0].startswith("`edge='wall'` has no effect: the picture covers the plate")
    assert not any("edge" in text for text in made("cameo", MOTIFS["dome"]())[0].plate.warnings)
