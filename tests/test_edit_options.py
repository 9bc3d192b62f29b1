"""Invalid options of layers and transforms."""

import pytest

import nmaptool as nm

LAYER, TRANSFORM = nm.LayerOptions, nm.TransformOptions


@pytest.mark.parametrize(
    ("options", "how", "message"),
    [
        (LAYER, {"mode": "screen"}, "`mode='screen'`: use one of over, rnm, pd"),
        (LAYER, {"anchor": "middle"}, "`anchor='middle'`: use one of center, top-left"),
        (LAYER, {"at": "5px"}, "`at='5px'`: expected 2 distances separated by commas, such as 30%,12mm"),
        (LAYER, {"at": "5,6"}, "`at=.*: distance '5': expected a number with a unit"),
        (LAYER, {"strength": 1.5}, '`strength=1.5`: must lie between 0 and 1 for the mode "over"'),
        (LAYER, {"strength": -1}, "`strength=-1`: must be zero or more"),
        (LAYER, {"feather": "x"}, "`feather='x'`: expected a number with a unit"),
        (
            nm.LayerOptions,
            {"scale": "big"},
            "`scale='big'`: expected one factor, two separated by a comma, or a width such as 30mm",
        ),
        (LAYER, {"feather": "-2px"}, "`feather='-2px'`: must be zero or more, such as 6px"),
        (LAYER, {"scale": 0}, "`scale='0'`: expected one or two factors"),
        (LAYER, {"rotate": 1e9}, "`rotate=1e\\+09`: must lie between"),
        (LAYER, {"clip": "maybe"}, "`clip='maybe'`: use one of auto, yes, no"),
        (LAYER, {"at": "1e9px,0"}, "`at=.*: distance 1000000000px: must be a number of at most 1e\\+06"),
        (
            nm.TransformOptions,
            {"crop": "1,2"},
            "`crop='1,2'`: expected 4 distances separated by commas, such as 10%,10%,80%,50%",
        ),
        (TRANSFORM, {"crop": "a,0,1px,1px"}, "`crop=.*: distance 'a': expected a number with a unit"),
        (TRANSFORM, {"crop": "0,0,0,5px"}, "`crop='0,0,0,5px'`: width and height must be greater than zero"),
        (TRANSFORM, {"pad": "-3px"}, "`pad='-3px'`: must be zero or more; cut with `crop`"),
        (TRANSFORM, {"pad": "1px,2px"}, "expected 1 or 4 distances"),
        (TRANSFORM, {"affine": "1,2,3"}, "`affine='1,2,3'`: expected four numbers"),
        (TRANSFORM, {"affine": "1,2,2,4"}, "`affine='1,2,2,4'`: is singular"),
        (TRANSFORM, {"affine": "0,0,0,0"}, "is singular"),
        (TRANSFORM, {"affine": "nan,0,0,1"}, "must be numbers of at most 1e\\+06"),
        (TRANSFORM, {"scale": "0"}, "`scale='0'`: expected one or two factors between 0.001 and 1000"),
        (TRANSFORM, {"scale": "1,2,3"}, "`scale='1,2,3'`: expected one or two factors"),
        (TRANSFORM, {"scale": "x,2"}, "`scale='x,2'`: expected one factor, two separated by a comma, or a width"),
        (TRANSFORM, {"resize": "10"}, "`resize='10'`: expected columns x rows"),
        (TRANSFORM, {"resize": "9x9", "scale": 2}, "`resize` and `scale` both set the size of the result"),
        (TRANSFORM, {"rotate": float("nan")}, "`rotate=nan`: must lie between"),
        (TRANSFORM, {"ground": "stone"}, "`ground='stone'`: use one of auto, clear, flat"),
        (TRANSFORM, {"vectors_only": True, "pad": "1px"}, "`vectors_only` does not move pixels"),
        (TRANSFORM, {"width": "3px"}, "`width='3px'`: .* give it in mm"),
        (TRANSFORM, {"height_factor": 1e9}, "`height_factor=1e\\+09`: must lie between"),
    ],
)
def test_invalid_options_are_refused(options, how, message):
    with pytest.raises(nm.UsageError, match=message):
        options(**how)
