"""Detail finer than the machine: lost grooves and ridges count, steep slopes do not; the values of machines."""

from __future__ import annotations

import numpy as np
import pytest
from plate_cases import ball, design, made

import nmaptool as nm
from nmaptool.plates.fineness import away_from_edge, lost_detail

PITCH, SIZE = 0.1, 240


def surface(z, domain=None):
    """Heights of a function of x and y in mm, from the middle."""
    y, x = (np.mgrid[0 : SIZE + 1, 0 : SIZE + 1] - SIZE / 2) * PITCH
    domain = np.ones((SIZE, SIZE), bool) if domain is None else domain
    return nm.Height(np.asarray(z(x, y), np.float64), domain, nm.Frame(SIZE, SIZE, pitch_mm=PITCH))


def along(x, y, turn=0.3):
    return x * np.cos(turn) + y * np.sin(turn)


def share(z, finest, *, is_ball=False):
    height = surface(z)
    inner = away_from_edge(height.domain, finest / 2 / PITCH)
    return float(lost_detail(height, finest, is_ball=is_ball)[inner].mean())


SMOOTH = {
    "dome": lambda x, y: 4 - (x**2 + y**2) / 30,
    "half ball": lambda x, y: np.sqrt(np.maximum(0, 11**2 - x**2 - y**2)),
    "plane": lambda x, y: 2.5 * along(x, y),
    "wave": lambda x, y: 0.1 * np.sin(along(x, y) * 2 * np.pi / 8),
}


@pytest.mark.parametrize("finest", [0.3, 0.4, 1.0])
@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_surfaces_lose_nothing_however_steep(name, finest):
    assert share(SMOOTH[name], finest) < 2e-3
    if name != "half ball":  # which meets the plane around it in a sharp groove
        assert share(SMOOTH[name], finest, is_ball=True) < 2e-3


@pytest.mark.parametrize("turn", [0.0, 0.2, 0.7, np.pi / 4])
def test_steps_are_no_fine_detail_but_a_ball_leaves_a_fillet(turn):
    def step(x, y):
        return np.clip(along(x, y, turn) / PITCH, 0, 1)

    for finest in (0.4, 1.0, 3.0):
        assert share(step, finest) < 5e-3
    # as wide as the ball's radius, where the ball is higher than what may be lost and the blur of the pixels
    lost = lost_detail(surface(step), 3.0, is_ball=True)
    y, x = (np.mgrid[0:SIZE, 0:SIZE] + 0.5 - SIZE / 2) * PITCH
    place = along(x, y, turn)
    assert 0.005 < lost.mean() < 0.07
    assert place[lost].min() > -1.5
    assert place[lost].max() < 6 * PITCH  # on the step, where its blurred slope begins


@pytest.mark.parametrize("period", [0.3, 0.5, 0.7])
def test_grooves_finer_than_the_machine_are_lost_and_coarse_ones_are_not(period):
    def grooves(x, y):
        return 0.1 * np.sin(along(x, y) * 2 * np.pi / period)

    assert share(grooves, 0.8) > 0.97
    assert share(grooves, 1.2, is_ball=True) > 0.97
    assert share(lambda x, y: grooves(x / 30, y / 30), 0.8) == 0
    assert share(lambda x, y: grooves(x / 30, y / 30), 0.8, is_ball=True) == 0


def test_the_share_is_that_of_the_part_with_fine_detail():
    def half(x, y):
        return np.where(x < 0, 0.1 * np.sin(y * 2 * np.pi / 0.5), 0.0)

    assert share(half, 0.8) == pytest.approx(0.5, abs=0.02)


def test_a_thin_ridge_is_lost_to_a_nozzle_but_not_to_a_ball():
    def ridge(x, y):
        return np.where(np.abs(along(x, y)) < 0.35, 0.5, 0.0)

    assert share(ridge, 1.2) > 0.7 / 24 * 0.8
    assert share(ridge, 0.4) < 1e-3
    assert share(lambda x, y: -ridge(x, y), 0.8, is_ball=True) > 0.7 / 24 * 0.8


def test_the_edge_of_a_plate_is_no_detail():
    y, x = (np.mgrid[0:SIZE, 0:SIZE] + 0.5 - SIZE / 2) * PITCH
    domain = np.hypot(x, y) < 10
    height = surface(lambda x, y: 2.0 + 0 * x, domain)
    for is_ball in (False, True):
        assert not lost_detail(height, 1.0, is_ball=is_ball).any()


def test_detail_finer_than_a_pixel_of_the_relief_is_not_there():
    assert share(lambda x, y: np.sin(x * 30), 0.09) == 0


def rippled(period_px):
    """A map of grooves, as wide as its motif."""
    y, x = np.mgrid[0:120, 0:120]
    normals = np.dstack([0.7 * np.cos(2 * np.pi * x / period_px), 0.0 * y, np.ones(x.shape)])
    return normals, np.hypot(x - 59.5, y - 59.5) < 50


def test_plates_report_detail_finer_than_their_machine():
    fine = made(design("round", finest="1.5mm"), rippled(4.0), height=None)
    assert fine.plate.finer_share > 0.5
    (warning,) = fine.plate.warnings
    assert warning == (
        f"{fine.plate.finer_share:.0%} of the surface has detail finer than the 1.5 mm that the machine can make; it "
        "will be rounded off. Make the plate wider, or the detail softer with a smaller `mu`"
    )
    coarse = made(design("round", finest="0.8mm"), ball(120, 120))
    assert coarse.plate.finer_share < 0.01
    assert coarse.plate.warnings == ()
    assert made(design("round"), ball()).plate.finer_share is None


def test_machines_set_values_that_are_valid_options():
    for name, machine in nm.MACHINES.items():
        for options in (nm.MachineOptions, nm.SolidOptions):
            values = nm.MachineOptions.values_of(name, options)
            assert options(**{key: nm.length(value) for key, value in values.items()})
        assert set(machine.values) == {"pitch", "base", "max_error", "finest"}
    assert nm.MachineOptions.values_of(None, nm.SolidOptions) == {}
    assert nm.MachineOptions.values_of("fdm-0.4", nm.SolidOptions) == {"base": "2mm", "max_error": "0.02mm"}
    assert [name for name, machine in nm.MACHINES.items() if machine.is_ball] == ["cnc-3mm"]


def test_pitches_resample_the_map_or_are_refused():
    coarse, fine = (made(design("round", pitch=pitch), ball(80, 80)) for pitch in ("1mm", "0.2mm"))
    assert coarse.pitch_mm == pytest.approx(1, rel=0.03)
    assert fine.pitch_mm == pytest.approx(0.2, rel=0.03)
    assert fine.plate.resampled == pytest.approx(fine.plate.picture_width_mm / fine.pitch_mm / 80, rel=1e-3)
    assert coarse.height.range_mm[1] == pytest.approx(1)
    with pytest.raises(
        nm.LimitError, match=r"`pitch='0.001mm'`: would make a picture of \d+ x \d+ px; at most 270 mega"
    ):
        made(design("round", pitch="0.001mm"), ball(80, 80))
    height = nm.Height(np.zeros((81, 81)), np.ones((80, 80), bool), nm.Frame(80, 80, pitch_mm=0.5))
    with pytest.raises(nm.UsageError, match="`surface`: heights of a curved background keep their size"):
        nm.plate(
            ball(80, 80)[0],
            options=nm.ReliefOptions(background="surface"),
            design=design("round", pitch="0.1mm"),
            surface=height,
        )
