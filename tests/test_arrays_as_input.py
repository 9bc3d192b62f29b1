"""Plain arrays of any type are accepted like the package's own types, and their faults are named in one line."""

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.core.errors import InputError, UsageError
from nmaptool.types.inputs import as_height, as_normal_map, as_raster
from nmaptool.types.plain_arrays import as_mask


@pytest.fixture
def dome_array(dome):
    """Normals (32, 32, 3) float64 and the mask of the dome; garbage outside it."""
    d = dome(32, 32)
    normals = d.normals * 1.7
    normals[~d.inside] = np.nan
    normals[0, 0] = 0
    return normals, d.inside


def whole(rows=8, cols=8, vector=(0.0, 0.6, 0.8), dtype=np.float64):
    normals = np.zeros((rows, cols, 3), dtype)
    normals[...] = vector
    return normals


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64, np.longdouble])
@pytest.mark.parametrize("scale", [1, 100])
def test_vectors_of_any_float_type_become_unit_length(dtype, scale):
    normals = whole(dtype=dtype) * dtype(scale)
    made = nm.NormalMap.from_array(normals).normals
    assert made.dtype == np.float32
    np.testing.assert_allclose(made, whole(), atol=1e-3 if dtype == np.float16 else 1e-7)
    np.testing.assert_allclose(np.linalg.norm(made.astype(np.float64), axis=2), 1, atol=2e-7)


@pytest.mark.parametrize("scale", [1e-300, 1e-30, 1e30, 1e300])
def test_very_long_and_very_short_vectors_keep_their_direction(scale):
    np.testing.assert_allclose(nm.NormalMap.from_array(whole() * scale).normals, whole(), atol=1e-7)


def test_float32_normals_of_unit_length_keep_their_bits(clean_map):
    read = nm.read_normal_map(clean_map)
    made = nm.NormalMap.from_array(read.normals, read.coverage)
    assert made.normals.tobytes() == read.normals.tobytes()
    np.testing.assert_array_equal(made.coverage, read.coverage)
    given = read.normals.copy()
    nm.NormalMap.from_array(given * 2)
    np.testing.assert_array_equal(given, read.normals)


def test_normals_outside_the_mask_are_flat(dome_array):
    normals, inside = dome_array
    for mask in (inside, inside.astype(np.float16), inside.astype(int), inside.tolist()):
        made = nm.NormalMap.from_array(normals, mask, pitch_mm=0.5)
        assert (made.normals[~inside] == (0, 0, 1)).all()
        np.testing.assert_array_equal(made.coverage, inside.astype(np.float32))
        assert made.frame == nm.Frame(32, 32, 0.5)
    half = np.full((32, 32), 0.25)
    assert (nm.NormalMap.from_array(whole(32, 32), half).coverage == np.float32(0.25)).all()


def hollow():
    normals = whole()
    normals[2, 3] = 0
    normals[4, 5] = np.nan
    normals[6, 7] = np.inf
    return normals


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (
            (hollow(),),
            InputError,
            r"^normals: normals without a direction .*: 3 of 64, .* row 2, column 3; exclude them with a mask$",
        ),
        (
            (hollow(), np.arange(64).reshape(8, 8) > 32),
            InputError,
            "normals without a direction .*: 2 of 31, the first at row 4, column 5",
        ),
        ((whole()[..., :2],), InputError, r"^normals: found shape \(8, 8, 2\), expected \(H, W, 3\)$"),
        ((np.moveaxis(whole(), -1, 0),), InputError, r"components last, with numpy.moveaxis\(normals, 0, -1\)"),
        (
            (whole().astype(np.uint8),),
            InputError,
            "normals: found uint8, expected floats from -1 to 1; convert codes",
        ),
        ((np.zeros((0, 4, 3)),), InputError, "a picture of 4 x 0 pixels is empty"),
        (
            (whole(), np.ones((4, 8))),
            InputError,
            "normals is 8 x 8 pixels but the mask is 8 x 4; make them",
        ),
        ((whole(), np.full((8, 8), 255)), InputError, r"the mask must hold values from 0 to 1 \(divide 8-bit codes"),
        ((whole(), np.full((8, 8), np.nan)), InputError, "the mask must hold values from 0 to 1"),
        (("map.png",), UsageError, "^normals must be an array of numbers, found str"),
        (([[1, 2], [3]],), UsageError, "must be an array of numbers, found list"),
        ((whole() + 0j,), UsageError, "must be an array of numbers, found ndarray"),
    ],
)
def test_arrays_that_are_not_normals_are_refused(arguments, error, message):
    with pytest.raises(error, match=message):
        nm.NormalMap.from_array(*arguments)


def test_integrate_returns_the_heights_of_the_masked_part(dome_array):
    normals, inside = dome_array
    heights = nm.integrate(normals, inside)
    assert heights.shape == (33, 33)
    assert heights.dtype == np.float64
    assert heights.min() == 0
    np.testing.assert_array_equal(heights, nm.integrate(nm.NormalMap.from_array(normals, inside)))
    np.testing.assert_array_equal(heights, nm.integrate(normals.astype(np.float64), inside.astype(np.float32)))
    part = inside & (np.arange(32) < 16)
    np.testing.assert_array_equal(
        nm.integrate(nm.NormalMap.from_array(normals, inside), part), nm.integrate(normals, part)
    )


def test_integrate_names_what_is_wrong(dome_array):
    normals, inside = dome_array
    whole_map = nm.NormalMap.from_array(normals, inside)
    with pytest.raises(InputError, match=r"the mask selects no part of the surface: set it to 0\.5 or more there"):
        nm.integrate(whole_map, ~inside)
    with pytest.raises(InputError, match="normals is 32 x 32 pixels but the mask is 4 x 4"):
        nm.integrate(whole_map, np.ones((4, 4)))
    with pytest.raises(UsageError, match="`slope_cap=0`: must be greater than zero"):
        nm.integrate(normals, inside, slope_cap=0)
    with pytest.raises(UsageError, match="the normals must be a NormalMap, found str; read one with"):
        nm.integrate("map.png")


def test_a_relief_of_arrays_equals_that_of_maps(dome_array):
    normals, inside = dome_array
    options = nm.ReliefOptions(background="free")
    original = nm.NormalMap.from_array(normals, inside)
    expected = nm.relief(original, original, options, mask=inside).z_mm
    found = nm.relief(normals, normals, options, mask=inside)
    np.testing.assert_array_equal(found.z_mm, expected)
    session = nm.ReliefSession(normals, normals.astype(np.longdouble), mask=inside.tolist())
    np.testing.assert_array_equal(session.solve(options).z_mm, expected)
    curved = nm.ReliefOptions(background="surface")
    surface = whole(32, 32)
    np.testing.assert_array_equal(
        nm.relief(normals, options=curved, mask=inside, surface=surface).z_mm,
        nm.relief(original, options=curved, mask=inside, surface=nm.NormalMap.from_array(surface)).z_mm,
    )


def test_a_soft_mask_is_applied_once():
    soft = np.clip(np.hypot(*np.mgrid[-16:16, -16:16]) / -4 + 3, 0, 1)
    original = nm.NormalMap.from_array(whole(32, 32), soft > 0)
    np.testing.assert_array_equal(
        nm.relief(whole(32, 32), mask=soft).z_mm, nm.relief(original, mask=soft.astype(np.float32)).z_mm
    )


def test_edits_of_arrays_equal_those_of_maps(dome):
    array = dome(32, 32).normals
    own = nm.NormalMap.from_array(array)
    half = np.arange(32 * 32).reshape(32, 32) % 2 == 0
    float_half = half.astype(np.float32)
    for of_arrays, of_maps in (
        (nm.blend(array, array, mask=half), nm.blend(own, own, mask=float_half)),
        (nm.transform(array, nm.TransformOptions(rotate=30)), nm.transform(own, nm.TransformOptions(rotate=30))),
        (nm.paste(array, [array[:8, :8]]), nm.paste(own, [nm.Layer(nm.NormalMap.from_array(array[:8, :8]))])),
        (
            nm.compose([array, nm.Layer(array, mask=half)]),
            nm.compose([own, nm.Layer(own, mask=float_half)]),
        ),
    ):
        np.testing.assert_array_equal(of_arrays.normal_map.normals, of_maps.normal_map.normals)
    np.testing.assert_array_equal(nm.split(array).base.normals, nm.split(own).base.normals)
    np.testing.assert_array_equal(nm.curl_picture(array), nm.curl_picture(own))
    assert nm.diagnose(array) == nm.diagnose(own)
    group = nm.LayerGroup([array])
    assert isinstance(group.layers[0], nm.Layer)


def test_images_may_be_arrays(dome, codes, clean_map):
    image = nm.read_raster(clean_map)
    seen, expected = nm.inspect_map(image.pixels), nm.inspect_map(image)
    assert (seen.mean_abs_curl, seen.bits, seen.channels) == (expected.mean_abs_curl, 16, expected.channels)
    np.testing.assert_array_equal(nm.decode_normal_map(image.pixels).normals, nm.decode_normal_map(image).normals)
    heights = np.hypot(*np.mgrid[-8:8, -8:8])
    mask = heights < 7
    expected = nm.depth_to_normals(
        nm.RasterImage(np.float32(heights)[..., None], ("Y",), bits=32), mask=np.float32(mask)
    )
    for given in (heights, heights.astype(np.longdouble), heights[..., None]):
        found = nm.depth_to_normals(given, mask=mask)
        np.testing.assert_array_equal(found.normal_map.normals, expected.normal_map.normals)
    assert as_raster(heights.astype(np.float16)).bits == 16


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (
            lambda: as_raster(np.ones((4, 4), int)),
            InputError,
            "the picture is int64; expected floats, or codes",
        ),
        (
            lambda: as_raster(np.ones(4)),
            InputError,
            r"the picture is \(4,\); expected \(H, W\) or",
        ),
        (lambda: as_raster("map.png"), UsageError, "found str; read one with read_raster, or give an array"),
        (
            lambda: as_normal_map(None),
            UsageError,
            r"the map must be a NormalMap, found NoneType; .*\(H, W, 3\)",
        ),
        (
            lambda: nm.blend("a", "b"),
            UsageError,
            "the base must be a NormalMap, found str; read one",
        ),
        (lambda: nm.split("a"), UsageError, "the map must be a NormalMap, found str"),
        (lambda: nm.Layer("a"), UsageError, "the layer must be a NormalMap, found str"),
        (
            lambda: nm.Layer(whole(), mask="a"),
            UsageError,
            "the mask of layer must be an array",
        ),
        (lambda: nm.compose(nm.Layer(whole())), UsageError, "the layers must be a list of Layer objects, found Layer"),
        (lambda: nm.paste(whole(), 3), UsageError, "the layers must be a list of Layer objects, found int"),
        (lambda: nm.relief(whole(), mu_map="a"), UsageError, "`mu_map`: has no effect without a detail map"),
        (
            lambda: nm.relief(whole(), beta_map="a"),
            UsageError,
            "the beta map must be an array of numbers",
        ),
        (lambda: as_mask("a"), UsageError, "the mask must be an array of numbers, found str"),
        (
            lambda: as_height(whole()),
            UsageError,
            "must be a Height or a Relief, found ndarray; read one",
        ),
        (lambda: nm.unpack("a.psd"), UsageError, "the workspace must be a Workspace, found str; read one with"),
    ],
)
def test_wrong_types_are_named_with_a_remedy(call, error, message):
    with pytest.raises(error, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)
