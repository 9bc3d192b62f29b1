"""What happened to a layer as a whole, and what is to be said of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

_TURN_WORDS = {
    "flip-h": ("was mirrored left to right", "`flip_h`"),
    "flip-v": ("was mirrored top to bottom", "`flip_v`"),
    "90": ("was turned by 90 degrees counter-clockwise", "`rotate=90`"),
    "180": ("was turned by 180 degrees", "`rotate=180`"),
    "270": ("was turned by 90 degrees clockwise", "`rotate=-90`"),
    "transpose": ("was turned by 90 degrees clockwise and mirrored left to right", "`rotate=-90` `flip_h`"),
    "antitranspose": ("was turned by 90 degrees counter-clockwise and mirrored left to right", "`rotate=90` `flip_h`"),
}


@dataclass(frozen=True)
class Pose:
    """What happened to a layer as a whole.

    Parameters
    ----------
    turn : str
        ``none``, ``flip-h``, ``flip-v``, ``90``, ``180``, ``270`` (counter-clockwise), ``transpose`` or
        ``antitranspose`` (mirrored along a diagonal).
    vectors_turned : bool
        The vectors went with the picture, so that nothing is wrong.
    angle_deg : float or None
        A free turn, counter-clockwise, whose vectors stayed.
    moved : (dx, dy) or None
        Pixels, y down, of a layer that is otherwise as it was.
    stretched : (sx, sy) or None
        Uneven scale, whose slopes stayed.
    curl, curl_if_turned : float
        Mean |curl| now, and were the vectors turned by ``angle_deg``.
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
        """Whether the layer was moved at the most."""
        return self == replace(Pose(), moved=self.moved, curl=self.curl)

    def findings(self) -> Iterator[tuple[str, str, str]]:
        """Code, message and remedy of each thing to be said of it."""
        if self.turn != "none" and not self.vectors_turned:
            did, flags = _TURN_WORDS[self.turn]
            yield (
                "turned",
                f"{did} without its vectors: bumps are lit from the wrong side",
                f"turn its vectors, too: transform the map with {flags} `vectors_only`",
            )
        if self.angle_deg is not None:
            way = "counter-clockwise" if self.angle_deg > 0 else "clockwise"
            words = f"looks turned by {abs(self.angle_deg):.0f} degrees {way} without its vectors"
            proof = f"turning them takes mean |curl| from {self.curl:.4f} to {self.curl_if_turned:.4f}"
            remedy = f"transform the map with `rotate={self.angle_deg:.1f}` `vectors_only`"
            yield ("turned-freely", f"{words}: {proof}", f"{remedy} (half a turn more if it stands on its head)")
        if self.stretched is not None:
            sx, sy = self.stretched
            yield (
                "stretched",
                f"was scaled unevenly, {sx:.2f} times across and {sy:.2f} times down, without its slopes",
                "scale it by transform or paste, which divide the slopes",
            )
        if self.moved is not None:
            dx, dy = self.moved
            yield (
                "moved",
                f"was moved by {dx:+d} px across and {dy:+d} px down; its vectors stay right",
                "nothing to do: the recipe has its new place",
            )
