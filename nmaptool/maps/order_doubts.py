"""Doubts about the order of a map's channels, in words."""

from __future__ import annotations

from typing import Literal, NamedTuple

from nmaptool.maps.codec import parse_swizzle
from nmaptool.maps.conventions import (
    MOST_FITS,
    better_remedy,
    better_swizzle,
    green_is_wrong,
    inside_out_swizzle,
    is_inverted,
    swizzle_in_use,
    upright_swizzle,
    with_evidence,
)
from nmaptool.maps.orders import MOST_AWAY, SURE_CURL_RATIO
from nmaptool.types.inputs import NormalsLike, as_normal_map
from nmaptool.types.normal_map import Decoding


class OrderDoubt(NamedTuple):
    """A doubt about the order of a map's channels.

    Attributes
    ----------
    code : str
        Code of the finding.
    message, remedy : str
    told : str
        How commands tell of it: as a "warning", as a "note" because the map is read in the likelier way, or not at all
        because it is certain ("inspection").
    """

    code: str
    message: str
    remedy: str
    told: Literal["warning", "note", "inspection"] = "warning"


def order_doubt(decoding: Decoding) -> OrderDoubt | None:
    """The doubt about the order of a map's channels; None if nothing looks wrong."""
    better, upright = better_swizzle(decoding), upright_swizzle(decoding)
    if green_is_wrong(decoding):
        other = "up" if decoding.green == "down" else "down"
        source = {"file": "stated", "preset": "set by the preset"}.get(decoding.green_from, "given")
        return OrderDoubt(
            "green-wrong",
            f"green is {source} as {decoding.green}, but {other} has far less curl",
            f"try `green={other!r}`",
        )
    if better is not None and better != upright:
        return _turned(decoding, better)
    if better is not None or is_inverted(decoding.outline_sign):
        return OrderDoubt(
            "inverted",
            "looks inverted: the normals along the outline point inwards, which turns bumps into dents",
            f"for an engraving use `delta=-30`; for a raised motif read it with `swizzle={upright!r}`",
        )
    return _mirrored(decoding)


def _turned(decoding: Decoding, better: str) -> OrderDoubt | None:
    """Another order fits, which is not just the inside-out of that in use."""
    own, other = swizzle_in_use(decoding), parse_swizzle(better)
    if own[2] != other[2]:
        if decoding.away_share > MOST_AWAY:  # that doubt names the order, too
            return None
        what = "its axes look like those of another camera or program: another order faces the viewer"
    elif own[0][0] == other[0][0]:
        what = f"its channels look mirrored: another sign {_reason(decoding)}"
    else:
        what = "its channels look rotated or mirrored: another order has far less curl"
    return OrderDoubt("turned", what, better_remedy(decoding, better))


def _reason(decoding: Decoding) -> str:
    """Why another sign of y fits better."""
    ratio = decoding.curl_ratio or 1.0
    return "has far less curl" if max(ratio, 1 / ratio) > SURE_CURL_RATIO else "fits the outline"


def _mirrored(decoding: Decoding) -> OrderDoubt | None:
    """Green was found to point down, or red to the left."""
    if decoding.green_from != "found":
        return None
    if decoding.swizzle_from == "found":
        return OrderDoubt(
            "red-left",
            "red points left, or green points down and the motif is sunken: both have the same curl",
            "it is read with red left, as estimators write it, so it is raised; if it is sunken, use `green='down'`",
            "note",
        )
    if decoding.green != "down":
        return None
    inside_out = inside_out_swizzle(decoding)
    if inside_out is not None:
        return OrderDoubt(
            "green-down",
            "green points down or red points left: both have the same curl, and no outline tells them apart",
            f"it is read with green down; if it comes out inside out, use `swizzle={inside_out!r}`; `green='down'` "
            "confirms",
            # a tileable texture was made for an engine; other full pictures may be those of an estimator
            "note" if decoding.repeats else "warning",
        )
    ratio = 1 / decoding.curl_ratio if decoding.curl_ratio else float("inf")
    return OrderDoubt(
        "green-down",
        f"green points down (DirectX): green up would have {ratio:.1f} times the curl",
        "it is read with green down; to be certain, set `green='up'` or `green='down'`",
        "inspection",
    )


def order_notes(decoding: Decoding, *, makes_heights: bool = True) -> tuple[str, ...]:
    """What was assumed about the order of a map's channels because nothing tells.

    Parameters
    ----------
    decoding : Decoding
    makes_heights : bool
        Whether the map becomes heights. If not, it need not be known whether a map in the usual order is raised.
    """
    doubt = order_doubt(decoding)
    if doubt is not None:
        return (f"{doubt.message}; {doubt.remedy}",) if doubt.told == "note" else ()
    stated = ("given", "preset", "file")
    if decoding.swizzle_from in stated or decoding.green_from in stated or not decoding.fits:
        return ()
    inside_out = inside_out_swizzle(decoding)
    if inside_out is not None and makes_heights:
        return (f"raised is assumed: no outline tells; if it comes out inside out, use `swizzle={inside_out!r}`",)
    if decoding.green_from == "assumed" and len(decoding.fits) > MOST_FITS:
        return ("green up is assumed: too little curl to tell; if its forms look twisted, use `green='down'`",)
    return ()


def diagnose(normal_map: NormalsLike) -> tuple[str, ...]:
    """Warn if a map looks inverted, rotated or mirrored, or like one of another camera.

    Parameters
    ----------
    normal_map : NormalMap or (H, W, 3) float of any type

    Returns
    -------
    tuple of str
        Warnings, each with a remedy; empty if nothing looks wrong.

    Raises
    ------
    InputError
        If a normal of an array has no direction.
    UsageError
        If the map is neither a NormalMap nor an array.

    Examples
    --------
    The normals of a dome that was turned into a hollow:

    >>> y, x = np.mgrid[1:-1:64j, -1:1:64j]
    >>> normals = np.dstack([-x, -y, np.ones_like(x)])
    >>> nm.diagnose(nm.NormalMap.from_array(normals, mask=np.hypot(x, y) < 0.8))
    ("looks inverted: the normals along the outline point inwards, ... read it with `swizzle='-r,-g,b'`",)
    """
    normal_map = as_normal_map(normal_map)
    if normal_map.decoding.green_from == "file":  # the file states how to read it
        return ()
    doubt = order_doubt(with_evidence(normal_map))
    return (f"{doubt.message}; {doubt.remedy}",) if doubt is not None and doubt.told == "warning" else ()
