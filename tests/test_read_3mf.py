"""Reading 3MF: units, items, components, several parts; and every kind of fault."""

import locale
import re
import zipfile

import lib3mf
import numpy as np
import pytest
from mesh_files import FACES, VERTICES, volume
from package_cases import components_xml, mesh_xml, model_xml, object_xml, threemf

import nmaptool as nm
from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.meshes.reader import read_mesh
from nmaptool.types.mesh import Mesh

DAMAGED = r"the 3MF file is truncated or damaged; export it again$"


@pytest.fixture
def read(tmp_path, capfd):
    """``read(data)``: the mesh in a 3MF; reading prints nothing."""

    def call(data, **options):
        (tmp_path / "a.3mf").write_bytes(data)
        mesh = read_mesh(tmp_path / "a.3mf", **options)
        assert capfd.readouterr() == ("", "")
        return mesh

    return call


@pytest.fixture
def refused(read):
    """``refused(data, pattern)``: an error of one line."""

    def call(data, pattern, error=InputError, **options):
        with pytest.raises(error, match=pattern) as caught:
            read(data, **options)
        assert "\n" not in str(caught.value)

    return call


@pytest.mark.parametrize(
    ("unit", "mm"),
    [("micron", 0.001), ("millimeter", 1), ("centimeter", 10), ("inch", 25.4), ("foot", 304.8), ("meter", 1000)],
)
def test_units_are_those_of_the_file(read, unit, mm):
    mesh = read(threemf(model_xml(unit=unit)))
    assert (mesh.mm_per_unit, mesh.unit_from, mesh.up_from) == (mm, "file", "assumed")
    assert mesh.vertices.tolist() == VERTICES.tolist()
    assert mesh.faces.tolist() == FACES.tolist()
    assert mesh.notes == ()
    assert read(threemf(model_xml(unit=unit)), unit="cm").mm_per_unit == 10


def test_items_and_components_are_placed_by_their_transforms(read):
    # matrices of rows: the first three rows turn, the last one moves
    quarter = "0 1 0 -1 0 0 0 0 1 10 0 0"
    objects = object_xml(1) + object_xml(
        2, components_xml('objectid="1"', 'objectid="1" transform="1 0 0 0 1 0 0 0 -2 0 0 0"')
    )
    items = f'<item objectid="2" transform="{quarter}"/><item objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 7"/>'
    mesh = read(threemf(model_xml(objects, items)))
    x, y, z = VERTICES.T
    first, second, third = mesh.vertices.reshape(3, 4, 3)
    assert np.allclose(first, np.stack([10 - y, x, z], 1))
    assert np.allclose(second, np.stack([10 - y, x, -2 * z], 1))
    assert np.allclose(third, np.stack([x, y, z + 7], 1))
    assert volume(mesh) == pytest.approx(1 + 2 + 1)  # the mirrored one is not inside out


def test_several_parts_as_slicers_write_them(read):
    other = model_xml(object_xml(1) + object_xml(2, mesh_xml(VERTICES * 2)), "")
    use = 'p:path="/3D/Objects/object_1.model" objectid="2" transform="1 0 0 0 1 0 0 0 1 0 0 9"'
    root = model_xml(object_xml(1, components_xml(use)))
    data = threemf(root, root="root.model", **{"Objects/object_1.model": other})
    assert read(data).vertices.tolist() == (VERTICES * 2 + np.float32([0, 0, 9])).tolist()


@pytest.mark.parametrize("relations", ["", "<Relationships/>"])
def test_without_relations_the_usual_name_or_any_model_is_read(read, relations):
    assert len(read(threemf(_rels=relations)).faces) == 4
    assert len(read(threemf(root="other.model", _rels=relations)).faces) == 4


def test_what_is_left_out_is_said(read):
    lattice = mesh_xml().replace("</mesh>", "<b:beamlattice radius='1'/></mesh>")
    objects = object_xml(1, lattice) + object_xml(2, kind="support") + object_xml(3)
    mesh = read(threemf(model_xml(objects, '<item objectid="1"/><item objectid="2"/>')))
    assert len(mesh.faces) == 4
    assert mesh.notes == (
        "ignored 1 support",
        "ignored 1 object outside the build",
        "ignored 1 beam lattice",
    )


CUBES = mesh_xml(np.concatenate([VERTICES, VERTICES * 3, VERTICES * 9]), np.concatenate([FACES, FACES + 4, FACES + 8]))


def volumes_xml(*kinds: str) -> str:
    """The list of the volumes of an object, each of four triangles, as PrusaSlicer writes it."""
    volumes = "".join(
        f'<volume firstid="{4 * k}" lastid="{4 * k + 3}"><metadata type="volume" key="name" value="x"/>'
        f'<metadata type="volume" key="{kind.partition("=")[0]}" value="{kind.partition("=")[2]}"/></volume>'
        for k, kind in enumerate(kinds)
    )
    return f'<?xml version="1.0"?><config><object id="1" instances_count="1">{volumes}</object></config>'


@pytest.mark.parametrize("name", ["Slic3r_PE_model.config", "Super_Slicer_model.config"])
@pytest.mark.parametrize("kind", ["ParameterModifier", "NegativeVolume", "SupportBlocker", "SupportEnforcer"])
def test_volumes_of_prusaslicer_that_are_no_parts_are_left_out(read, name, kind):
    volumes = volumes_xml("volume_type=ModelPart", f"volume_type={kind}", "modifier=1")
    mesh = read(threemf(model_xml(object_xml(1, CUBES)), **{f"Metadata/{name}": volumes}))
    assert mesh.faces.tolist() == FACES.tolist()
    assert mesh.notes == ("ignored 2 volumes that only modify others in a slicer",)
    parts = volumes_xml("volume_type=ModelPart", "extruder=2")
    all_parts = read(threemf(model_xml(object_xml(1, CUBES)), **{f"Metadata/{name}": parts}))
    assert (len(all_parts.faces), all_parts.notes) == (12, ())


@pytest.mark.parametrize("volumes", ["<config", volumes_xml("volume_type=ModelPart").replace('"0"', '"x"')])
def test_a_damaged_list_of_volumes_is_said(read, volumes):
    mesh = read(threemf(model_xml(object_xml(1, CUBES)), **{"Metadata/Slic3r_PE_model.config": volumes}))
    assert len(mesh.faces) == 12
    assert mesh.notes == (
        "did not read Metadata/Slic3r_PE_model.config, which tells modifiers from parts: the mesh may hold both",
    )


def test_modifiers_of_bambu_studio_are_left_out(read):
    other = model_xml(object_xml(1) + object_xml(2, mesh_xml(VERTICES * 2), kind="other"), "")
    uses = [f'p:path="/3D/Objects/object_1.model" objectid="{k}"' for k in (1, 2)]
    mesh = read(threemf(model_xml(object_xml(1, components_xml(*uses))), **{"Objects/object_1.model": other}))
    assert mesh.vertices.tolist() == VERTICES.tolist()
    assert mesh.notes == ("ignored 1 volume that only modifies others in a slicer",)
    alone = read(threemf(model_xml(object_xml(1, kind="other"))))
    assert (len(alone.faces), alone.notes) == (4, ())


def test_a_model_without_a_build_gives_its_objects(read):
    objects = object_xml(1) + object_xml(2, components_xml('objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 7"'))
    mesh = read(threemf(model_xml(objects, "")))
    assert mesh.vertices.tolist() == (VERTICES + np.float32([0, 0, 7])).tolist()


def test_written_meshes_and_solids_are_read_back(tmp_path, read):
    nm.write_mesh(Mesh(VERTICES.astype(float), FACES), tmp_path / "b.3mf")
    mesh = read_mesh(tmp_path / "b.3mf")
    assert (mesh.mm_per_unit, mesh.unit_from) == (1, "file")
    assert volume(mesh) == pytest.approx(1)
    cap = np.zeros((40, 60, 3))
    cap[..., 2] = 1
    y, x = np.mgrid[-1:1:40j, -1.5:1.5:60j]
    covered = (np.hypot(x - 0.8, y) < 0.6) | (np.hypot(x + 0.8, y) < 0.5)
    cap[covered] = np.stack([x * 0.3, y * 0.3, x * 0 + 1], -1)[covered]
    relief = nm.relief(nm.NormalMap.from_array(cap, covered, 0.5), options=nm.ReliefOptions(background="cut"))
    solid = nm.solid(relief, nm.SolidOptions(base=nm.length("2mm")))
    nm.write_relief(relief, tmp_path / "c.3mf", solid=solid)
    mesh = read_mesh(tmp_path / "c.3mf")  # two objects
    assert volume(mesh) == pytest.approx(solid.volume_mm3, rel=1e-5)
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx(solid.size_mm, abs=1e-3)


def test_files_of_lib3mf_are_read(tmp_path):
    model = lib3mf.get_wrapper().CreateModel()
    model.SetUnit(lib3mf.ModelUnit.Inch)
    thing = model.AddMeshObject()
    thing.SetGeometry([_position(v) for v in VERTICES], [_triangle(f) for f in FACES])
    whole = model.AddComponentsObject()
    whole.AddComponent(thing, _transform(2, (1, 2, 3)))
    model.AddBuildItem(whole, _transform(1, (0, 0, 10)))
    before = locale.setlocale(locale.LC_ALL)
    model.QueryWriter("3mf").WriteToFile(str(tmp_path / "a.3mf"))
    locale.setlocale(locale.LC_ALL, before)  # lib3mf sets that of the whole process
    mesh = read_mesh(tmp_path / "a.3mf")
    assert mesh.mm_per_unit == 25.4
    assert np.allclose(mesh.vertices, VERTICES * 2 + np.float32([1, 2, 13]))


def _position(vertex):
    position = lib3mf.Position()
    for k in range(3):
        position.Coordinates[k] = vertex[k]
    return position


def _triangle(face):
    triangle = lib3mf.Triangle()
    for k in range(3):
        triangle.Indices[k] = int(face[k])
    return triangle


def _transform(scale, move):
    transform = lib3mf.Transform()
    for k in range(3):
        transform.Fields[k][k] = scale
        transform.Fields[3][k] = move[k]
    return transform


def test_faults_are_named(refused):
    refused(threemf(model_xml(items='<item objectid="9"/>')), r"lacks its object '9'; export it again$")
    path = 'p:path="/3D/gone.model" objectid="1"'
    data = threemf(model_xml(object_xml(1, components_xml(path))))
    refused(data, r"lacks its part '3D/gone\.model'; export or download it again$")
    refused(threemf(model_xml(unit="parsec")), r"has the unknown unit 'parsec'; export it again in millimetres$")
    refused(threemf(model_xml(object_xml(1, mesh_xml(VERTICES[:3])))), r"refers to vertex 3, which is missing \(vert")
    refused(threemf(model_xml(object_xml(1, mesh_xml(VERTICES, [])))), r"holds 4 points and no faces; make a mesh from")
    refused(threemf(model_xml(object_xml(1, components_xml()))), r"holds no faces; export it again as a surface$")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('x="1"', 'x="1,5"'),
        ('x="1"', 'x="one"'),
        ('x="1" ', ""),
        ('v1="0"', 'v1="0.5"'),
        ('v1="0"', f'v1="{"9" * 30}"'),
        ('id="1" type', "type"),
        ('<item objectid="1"/>', '<item objectid="1" transform="1 2 3"/>'),
        ('<item objectid="1"/>', '<item objectid="1" transform="nan 0 0 0 1 0 0 0 1 0 0 0"/>'),
        ("</build>", ""),
        ("<build>", "<build>&unknown;"),
        ("<model", '<!DOCTYPE m [<!ENTITY a "aaaa">]><model'),
    ],
)
def test_invalid_models_are_refused_with_their_line(refused, old, new):
    data = threemf(model_xml().replace(old, new, 1))
    refused(data, r"a\.3mf: line \d+ of 3D/3dmodel\.model is not valid: " + DAMAGED)


def test_objects_that_contain_themselves_are_refused(refused):
    for uses in ('objectid="1"', 'objectid="2"'):
        objects = object_xml(1, components_xml(uses)) + object_xml(2, components_xml('objectid="1"'))
        refused(threemf(model_xml(objects)), r"its object '[12]' contains itself; export it again$")


def test_objects_that_double_at_every_level_are_counted_not_made(refused):
    double = [object_xml(k, components_xml(*[f'objectid="{k + 1}"'] * 2)) for k in range(1, 200)]
    data = threemf(model_xml("".join(double) + object_xml(200)))
    refused(data, rf"{4 * 2**199} faces, more than the limit of 20000000; decimate it", LimitError)
    data = threemf(model_xml("".join(double) + object_xml(200, mesh_xml(VERTICES, []))))
    refused(data, r"no faces; ")


def test_the_limits_hold_before_anything_is_made(refused, read, tmp_path):
    data = threemf()
    refused(data, r"4 faces, more than the limit of 3; decimate it, or raise `max_faces`$", LimitError, max_faces=3)
    assert len(read(data, max_faces=4).faces) == 4
    items = '<item objectid="1"/>' * 3
    refused(threemf(model_xml(items=items)), r"12 faces, more than the limit of 11", LimitError, max_faces=11)
    many = object_xml(1, mesh_xml(np.zeros((100, 3))))
    refused(threemf(model_xml(many)), r"more than 12 vertices for 4 faces; decimate it", LimitError, max_faces=4)
    bomb = threemf(model_xml().replace("<build>", "<build>" + " " * 20_000_000))
    assert len(bomb) < 100_000
    refused(bomb, r"3D/3dmodel\.model is 20 MB of XML, too much for 4 faces; decimate it", LimitError, max_faces=4)
    comment = threemf(model_xml().replace("<build>", "<build><!--" + "x" * 40_000_000 + "-->"))
    refused(comment, DAMAGED)


def test_archives_without_a_model_or_cut_short_are_refused(tmp_path, refused, trials):
    data = threemf()
    for length in range(1, len(data), len(data) // trials(len(data))):
        refused(data[:length], "export|download|unpack")
    with zipfile.ZipFile(tmp_path / "b.3mf", "w") as archive:
        archive.writestr("readme.txt", "x")
    with pytest.raises(InputError, match=r"is a ZIP archive; unpack it and use the mesh in it$"):
        read_mesh(tmp_path / "b.3mf")


def test_damaged_archives_give_a_mesh_or_an_error(tmp_path, read):
    data, rng = threemf(), np.random.default_rng(5)
    outcomes = set()
    for _ in range(150):
        damaged = bytearray(data)
        for _ in range(rng.integers(1, 4)):
            damaged[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
        try:
            outcomes.add(len(read(bytes(damaged), max_faces=50).faces))
        except (InputError, LimitError) as error:
            assert re.fullmatch(r"[^\n]+a\.3mf: [^\n]+", str(error))
            outcomes.add("error")
    assert outcomes == {4, "error"}
