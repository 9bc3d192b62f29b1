"""Private names of pyrender and psd-tools that nmaptool relies on; after an update, this shows which are gone."""

import ast
import importlib
import inspect
import warnings
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("psd_tools", "pyrender")
OFFSCREEN = "nmaptool/render/offscreen.py"
READER, WRITER = "nmaptool/io/workspaces/psd_reader.py", "nmaptool/io/workspaces/psd_writer.py"
DOCUMENT = "nmaptool/io/workspaces/psd_document.py"
SIDES = "top left bottom right"

# attributes that a class sets in its code and offscreen.py reads or replaces
ATTRIBUTES = {
    "pyrender.offscreen.OffscreenRenderer": "_renderer _platform",
    "pyrender.renderer.Renderer": "_program_cache dpscale",
    "pyrender.platforms.egl.EGLPlatform": "_egl_display _egl_context",
}
# for each file of nmaptool, the functions and classes it calls, with the parameters it passes
CALLS = {
    OFFSCREEN: {
        "pyrender.renderer": {"Renderer._update_context": "scene flags", "Renderer.delete": ""},
        "pyrender.shader_program": {"ShaderProgramCache": "shader_dir"},
        "pyrender.platforms.base": {"Platform.make_current": "", "Platform.supports_framebuffers": ""},
    },
    DOCUMENT: {
        "psd_tools": {"ParseLimits": "max_total_bytes max_objects"},
        "psd_tools.psd": {"PSD.read": "parse_limits"},
        "psd_tools.psd.layer_and_mask": {
            "LayerAndMaskInformation": "layer_info global_layer_mask_info tagged_blocks",
            "LayerInfo": "layer_count layer_records channel_image_data",
        },
    },
    WRITER: {
        "psd_tools.psd": {"PSD": "header image_resources layer_and_mask_information image_data", "PSD.write": ""},
        "psd_tools.psd.header": {"FileHeader": "version channels height width depth color_mode"},
        "psd_tools.psd.image_data": {"ImageData": "compression", "ImageData.set_data": "data header"},
        "psd_tools.psd.image_resources": {"ImageResource": "key data", "ImageResources.new": ""},
        "psd_tools.psd.layer_and_mask": {
            "ChannelData": "compression",
            "ChannelData.set_data": "data width height depth version",
            "ChannelInfo": "id",
            "LayerFlags": "visible pixel_data_irrelevant",
            "MaskData": f"{SIDES} background_color flags",
        },
        "psd_tools.psd.tagged_blocks": {"TaggedBlocks.set_data": "key args kwargs"},
    },
    READER: {
        "psd_tools.psd.image_data": {"ImageData.get_data": "header split max_output_bytes"},
        "psd_tools.psd.image_resources": {"ImageResources.get_data": "key"},
        "psd_tools.psd.layer_and_mask": {
            "ChannelData.get_data": "width height depth version max_output_bytes",
            "LayerRecord": f"{SIDES} name blend_mode opacity flags channel_info clipping mask_data tagged_blocks",
            "MaskFlags": "mask_disabled pos_relative_to_layer",
        },
        "psd_tools.psd.tagged_blocks": {"TaggedBlocks.get_data": "key default"},
    },
}


def found(module, name, user):
    """The named object of a package; if it is gone, the test fails and names it and the file that uses it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            value = importlib.import_module(module)
            for part in name.split("."):
                value = getattr(value, part)
        except (ImportError, AttributeError) as error:
            pytest.fail(f"{user} uses {module}.{name}, which is gone: {error}")
    return value


def sets(owner, attribute):
    """Whether the code of a class assigns ``self.attribute``."""
    nodes = ast.walk(ast.parse(inspect.getsource(owner)))
    return any(isinstance(n, ast.Attribute) and n.attr == attribute and isinstance(n.ctx, ast.Store) for n in nodes)


@pytest.mark.parametrize(
    ("owner", "attribute"), [(owner, name) for owner, names in ATTRIBUTES.items() for name in names.split()]
)
def test_attributes_that_are_read_or_replaced(owner, attribute, user=OFFSCREEN):
    module, _, name = owner.rpartition(".")
    assert sets(found(module, name, user), attribute), f"{user} uses {owner}.{attribute}, which is gone"


@pytest.mark.parametrize(
    ("module", "name", "parameters", "user"),
    [
        (module, name, parameters, user)
        for user, modules in CALLS.items()
        for module, calls in modules.items()
        for name, parameters in calls.items()
    ],
)
def test_calls_and_their_parameters(module, name, parameters, user):
    known = inspect.signature(found(module, name, user)).parameters
    gone = [parameter for parameter in parameters.split() if parameter not in known]
    assert not gone, f"{user} calls {module}.{name} with {', '.join(gone)}, which it no longer takes"


def private_names(path):
    """Names with one leading underscore that a file reads from or sets on objects other than its own."""
    return {
        node.attr
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute)
        and node.attr.startswith("_")
        and not node.attr.startswith("__")
        and not (isinstance(node.value, ast.Name) and node.value.id in ("self", "cls"))
    }


def test_every_private_name_is_in_the_table_and_used_in_one_file():
    called = [name.rpartition(".")[2] for calls in CALLS[OFFSCREEN].values() for name in calls]
    listed = {*called, *" ".join(ATTRIBUTES.values()).split()}
    users = [
        path
        for path in sorted((ROOT / "nmaptool").rglob("*.py"))
        if any(
            f"{verb} {package}" in path.read_text(encoding="utf-8")
            for verb in ("from", "import")
            for package in PACKAGES
        )
    ]
    assert [path.relative_to(ROOT).as_posix() for path in users] == [DOCUMENT, READER, WRITER, OFFSCREEN]
    assert {path.name: private_names(path) for path in users} == {
        "psd_document.py": set(),
        "psd_reader.py": set(),
        "psd_writer.py": set(),
        "offscreen.py": {name for name in listed if name.startswith("_")},
    }


@pytest.mark.parametrize("check", ["attribute", "call", "parameter"])
def test_a_missing_name_is_reported_with_the_file_that_uses_it(check):
    tests = {
        "attribute": lambda: test_attributes_that_are_read_or_replaced("pyrender.renderer.Renderer", "_gone", "a.py"),
        "call": lambda: test_calls_and_their_parameters("pyrender.renderer", "Renderer._gone", "", "a.py"),
        "parameter": lambda: test_calls_and_their_parameters("pyrender.renderer", "Renderer.delete", "gone", "a.py"),
    }
    with pytest.raises((AssertionError, pytest.fail.Exception), match=r"^a\.py .*pyrender\.renderer\.Renderer.*gone"):
        tests[check]()
