"""Random designs: every plate that is made is a proven solid of the exact width, height and area."""

from __future__ import annotations

import numpy as np
import pytest
from plate_cases import ball, design, made, solid
from solid_cases import check_solid

import nmaptool as nm
from nmaptool.plates.distance import inside_points


def random_plate(seed):
    """A random design, motif and options."""
    rng = np.random.default_rng([seed, 41])
    shape = str(rng.choice(["rect", "round", "oval", "mask", "star.svg"]))
    values = {"margin": str(rng.choice(["0.001mm", "1mm", "6%", "3px"]))}
    if rng.random() < 0.7:
        values["frame"] = str(rng.choice(["1mm", "4%", "2.5mm"]))
        values["frame_profile"] = str(rng.choice(["flat", "round", "bevel", "rope", "bead"]))
        values["frame_height"] = str(rng.choice(["0.3mm", "2mm"]))
    if rng.random() < 0.4:
        values["loop"] = str(rng.choice(["1.5mm", "4mm"]))
    if rng.random() < 0.3:
        values["hole"] = f"{rng.uniform(1, 3):.2f}mm@50%,{rng.integers(30, 70)}%"
    if shape in ("rect", "oval") and rng.random() < 0.5:
        values["aspect"] = str(rng.choice(["3:1", "1:2", "1:1"]))
    if shape == "rect" and rng.random() < 0.5:
        values["corner"] = "2mm"
    values |= {"engrave": bool(rng.random() < 0.2), "draft": float(rng.choice([0.0, 12.0, 50.0])), "pitch": "0.3mm"}
    texts = ()
    if rng.random() < 0.3:
        sunk = bool(rng.random() < 0.5)
        texts = ({"text": "AVE", "text_path": "arc", "text_size": "3mm", "text_height": "0.4mm", "text_sunk": sunk},)
    rows, cols = (int(side) for side in rng.integers(20, 60, 2))
    normals, mask = ball(rows, cols, rng.uniform(0.3, 1.1))
    options = {"edge": str(rng.choice(["blend", "wall"])), "width": f"{rng.uniform(25, 50):.3f}mm"}
    return design(shape, texts, **values), (normals, mask), options


def test_random_designs_make_proven_solids(trials):
    refused = 0
    for seed in range(trials(60)):
        wanted, motif, options = random_plate(seed)
        try:
            relief = made(wanted, motif, **options)
            found = solid(relief, base="3mm")
        except nm.InputError:  # what does not fit, and walls of a motif at the very edge
            refused += 1
            continue
        report, outline = relief.plate, relief.height.outline
        assert report.width_mm == pytest.approx(nm.length(options["width"]).to_mm(1, 1), rel=1e-12), seed
        low, high = outline.bounds_mm
        if wanted.plate.loop is None:
            assert (high - low)[0] == pytest.approx(report.width_mm, abs=1e-6), seed
        check_solid(found)
        assert found.size_mm[:2] == pytest.approx(tuple(high - low), abs=1e-9), seed
        assert report.area_mm2 == pytest.approx(outline.area_mm2)
        assert relief.report.relief_range_mm == pytest.approx(1, abs=1e-9), seed
        # the motif lies inside the plate
        rows, cols = np.nonzero(relief.foreground)
        pitch = relief.pitch_mm
        middles = np.column_stack([(cols + 0.5) * pitch, (relief.height.frame.rows - rows - 0.5) * pitch])
        outer = nm.Contours(outline.rings[:1])
        assert inside_points(outer, middles).mean() > 0.99, seed
    assert refused < trials(60) / 3
