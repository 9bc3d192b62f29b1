"""Changes to a layer as a whole, and the findings about them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

_TURN_WORDS = {
    "flip-h": ("was mirrored left to right", "`flip_h`"),
    "flip-v": ("was mirrored top to bottom", "`flip_v`"),
    "90": ("was rotated by 90 degrees counter-clockwise", "`rotate=90`"),
    "180": ("was rotated by 180 degrees", "`rotate=180`"),
    "270": ("was rotated by 90 degrees clockwise", "`rotate=-90`"),
    "transpose": ("was rotated by 90 degrees clockwise and mirrored left to right", "`rotate=-90` `flip_h`"),
    "antitranspose": ("was rotated by 90 degrees counter-clockwise and mirrored left to right", "`rotate=90` `flip_h`"),
}


@dataclass(frozen=True)
class Pose:
    """How a layer as a whole was changed.

    Parameters
    ----------
    turn : str
        ``none``, ``flip-h``, ``flip-v``, ``90``, ``180``, ``270`` (counter-clockwise), ``transpose`` or
        ``antitranspose`` (mirrored along a diagonal).
    vectors_turned : bool
        Whether the vectors were changed like the picture, so that nothing is wrong.
    angle_deg : float or None
        Rotation by any angle, counter-clockwise, without the vectors.
    moved : (dx, dy) or None
        Move in pixels, y down, of a layer that is otherwise unchanged.
    stretched : (sx, sy) or None
        Uneven scale, without adjusted slopes.
    curl, curl_if_turned : float
        Mean |curl| now, and after rotating the vectors by ``angle_deg``.
    """

    turn: str = "none"
    vectors_turned: bool = False
    angle_deg: float | None = None
    moved: tuple[int, int] | None = None
    stretched: tuple[float, float] | None = None
    curl: float = 0.0
    curl_if_turned: float = 0.0

    @property
    def is_in_place(self) -> bool:
        """Whether the layer was at most moved."""
        return self == replace(Pose(), moved=self.moved, curl=self.curl)

    def findings(self) -> Iterator[tuple[str, str, str]]:
        """Yield the code, message and remedy of each finding."""
        if self.turn != "none" and not self.vectors_turned:
            did, flags = _TURN_WORDS[self.turn]
            yield (
                "turned",
                f"{did}, but its vectors were not: bumps look lit from the wrong side",
                f"change its vectors too: transform the map with {flags} `vectors_only`",
            )
        if self.angle_deg is not None:
            way = "counter-clockwise" if self.angle_deg > 0 else "clockwise"
            words = f"looks rotated by {abs(self.angle_deg):.0f} degrees {way}, but its vectors were not"
            proof = f"rotating them changes the mean |curl| from {self.curl:.4f} to {self.curl_if_turned:.4f}"
            remedy = f"transform the map with `rotate={self.angle_deg:.1f}` `vectors_only`"
            yield ("turned-freely", f"{words}: {proof}", f"{remedy} (add 180 degrees if bumps then look like dents)")
        if self.stretched is not None:
            sx, sy = self.stretched
            yield (
                "stretched",
                f"was scaled by {sx:.2f} across and {sy:.2f} down, but its slopes were not adjusted",
                "undo that and scale the map with transform or paste, which adjust the slopes",
            )
        if self.moved is not None:
            dx, dy = self.moved
            yield (
                "moved",
                f"was moved by {dx:+d} px across and {dy:+d} px down; its vectors are still correct",
                "nothing to do: the recipe has its new position",
            )
