"""Frames that repeat a motif along their line: a twisted rope, a row of beads."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.plates.board import Board
from nmaptool.plates.distance import Curves
from nmaptool.plates.polygons import offset, outer_rings
from nmaptool.plates.profiles import Cross, averaged, half_round
from nmaptool.types.contours import Contours

# share of the width that is a level rim along the edge
_RIM = 0.2
# part of the rim that a rope does not lie under, so that the groove between them is shallow
_BESIDE = 0.4
# radius by which the line of a rope turns corners, by its width; smaller ones where it would break the line
_TURNS = (0.75, 0.4, 0.2, 0.0)
# rope: length of a strand along it by its width, how far it winds across, how deep the grooves are, samples of a strand
_STRAND = 0.62
_WIND = 0.55
_GROOVE = 0.42
_SAMPLES = 4096
# beads: diameter by the width of their row, least distance by diameter, and that below which two become one
_BEAD = 0.94
_BEAD_SPACING = 1.02
_MERGED = 0.98
# turn of a line in degrees that is a corner, which gets a bead
_CORNER_DEG = 20.0


def rope(cross: Cross, depth_mm: Float64, board: Board, outline: Contours) -> Float64:
    """A level rim, and inside it a twisted rope, whose strands repeat a whole number of times around it.

    Parameters
    ----------
    cross : Cross
    depth_mm : (rows, cols) float64
        Distance of the vertices from the outline, positive inside.
    board : Board
    outline : Contours
        On the grid of the board.
    """
    rim, _ = _rim_of(cross)
    width = cross.width_mm - _BESIDE * rim
    line = _centre_line(outline, cross.width_mm - width / 2, width)
    field = board.field(line, width / 2 + 2 * board.pitch_mm)
    lengths = np.array(Curves(line, board.pitch_mm).lengths_mm)
    counts = np.maximum(3, np.round(lengths / (_STRAND * width)))
    # no ring is nearest beyond the reach, where the body is 0 as well
    strand_mm = field.spread((lengths / counts)[field.near.ring], 1.0)
    from_line = np.clip(field.depth_mm(), -width, width)
    across = np.clip(2 * from_line / width, -0.995, 0.995)
    turn = field.spread(field.near.along_mm, 0.0) / strand_mm + _WIND * np.arcsin(across) / (np.pi / 2)
    # strands for each mm along and across: a groove is averaged over two pixels, at most over half a strand
    over = np.hypot(1 / strand_mm, 4 * _WIND / (np.pi * width * np.sqrt(1 - across**2)))
    groove = _groove(turn, np.minimum(2 * board.pitch_mm * over, 0.5))
    body = averaged(lambda away: half_round(2 * away / width), from_line, width / 2, board.pitch_mm)
    out: Float64 = np.maximum(_rim_profile(cross, rim, depth_mm), body * (1 - _GROOVE * groove))
    return out


def _groove(turn: Float64, over: Float64) -> Float64:
    """Depth of the groove between strands, which are round, averaged over a part of a strand; 0 on their crests."""
    places = np.linspace(0.0, 1.0, _SAMPLES + 1)
    middle = (places[1:] + places[:-1]) / 2
    depth = 1 - np.sqrt(1 - 0.96 * (2 * middle - 1) ** 2)
    total = np.concatenate([[0.0], np.cumsum(depth)]) / _SAMPLES

    def up_to(place: Float64) -> Float64:
        whole = np.floor(place)
        out: Float64 = whole * total[-1] + np.interp(place - whole, places, total)
        return out

    out: Float64 = (up_to(turn + over / 2) - up_to(turn - over / 2)) / over
    return out


def beads(cross: Cross, depth_mm: Float64, board: Board, outline: Contours) -> Float64:
    """A level rim, and inside it a row of half spheres at equal distances, one in each corner.

    Parameters
    ----------
    cross, depth_mm, board, outline
        As for `rope`.
    """
    from scipy.spatial import cKDTree  # takes long to load

    rim, width = _rim_of(cross)
    radius = _BEAD * width / 2
    line = outer_rings(offset(outline, -(rim + width / 2)))
    centres = bead_centres(line, 2 * radius * _BEAD_SPACING)
    points = np.stack(np.meshgrid(board.x_mm, board.y_mm), axis=-1).reshape(-1, 2)
    reach = radius + 2 * board.pitch_mm
    distance, _ = cKDTree(centres).query(points, distance_upper_bound=reach, workers=-1)
    away = np.minimum(distance, reach).reshape(board.shape)
    bead = averaged(lambda from_middle: half_round(from_middle / radius), away, radius, board.pitch_mm)
    out: Float64 = np.maximum(_rim_profile(cross, rim, depth_mm), bead)
    return out


def bead_centres(line: Contours, spacing_mm: float) -> Float64:
    """(n, 2) middles of beads on lines, at distances of at least ``spacing_mm`` along them, one in each corner."""
    from scipy.spatial import cKDTree  # takes long to load

    centres = np.concatenate([_evenly(ring, spacing_mm) for ring in line.rings])
    # in sharp corners, where two lines run beside each other, pairs of beads become one between them
    while pairs := cKDTree(centres).query_pairs(_MERGED * spacing_mm):
        partner = {}
        for one, other in sorted(pairs, key=lambda pair: float(np.hypot(*(centres[pair[0]] - centres[pair[1]])))):
            if one not in partner and other not in partner:
                partner[one], partner[other] = other, one
        merged = [(centres[one] + centres[other]) / 2 for one, other in partner.items() if one < other]
        centres = np.array([each for at, each in enumerate(centres) if at not in partner] + merged)
    return centres


def _evenly(ring: Float64, spacing_mm: float) -> Float64:
    """Points at equal distances between the corners of a ring, at least ``spacing_mm`` apart; else from the top on."""
    way = np.roll(ring, -1, axis=0) - ring
    before = np.roll(way, 1, axis=0)
    turn = np.arctan2(before[:, 0] * way[:, 1] - before[:, 1] * way[:, 0], (before * way).sum(axis=1))
    corners = np.flatnonzero(np.abs(turn) > np.radians(_CORNER_DEG))
    starts = corners if len(corners) else np.array([ring[:, 1].argmax()])
    out = []
    for first, last in zip(starts, np.roll(starts, -1), strict=True):
        count = (last - first - 1) % len(ring) + 2
        part = ring[(first + np.arange(count)) % len(ring)]
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(part, axis=0).T))])
        beads_here = max(1 if len(corners) else 3, int(along[-1] / spacing_mm))
        place = np.arange(beads_here) * along[-1] / beads_here
        out.append(np.column_stack([np.interp(place, along, each) for each in part.T]))
    return np.concatenate(out)


def _centre_line(outline: Contours, inset_mm: float, width_mm: float) -> Contours:
    """The line of a rope: at a distance from the edge, with corners turned round."""
    sharp = outer_rings(offset(outline, -inset_mm))
    for turn in _TURNS:
        found = outer_rings(offset(offset(outline, -inset_mm - turn * width_mm), turn * width_mm))
        if len(found.rings) == len(sharp.rings):
            break
    return found


def _rim_of(cross: Cross) -> tuple[float, float]:
    """Width of the level rim along the edge, and of what lies inside it."""
    rim = _RIM * cross.width_mm
    return rim, cross.width_mm - rim


def _rim_profile(cross: Cross, rim: float, depth_mm: Float64) -> Float64:
    ramp = min(cross.slope_mm, rim / 2)
    return averaged(lambda depth: np.clip((rim - depth) / ramp, 0, 1), depth_mm, rim, cross.pitch_mm)
