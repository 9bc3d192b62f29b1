"""Recipes from files: broken TOML, nested recipes, and recipes in image metadata."""

import pytest
from stack_cases import SCENE, waves, write_maps

import nmaptool as nm

ONE = '[[layer]]\nfile = "plate.exr"\n'


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


def write(folder, name, text):
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def link(name, more=""):
    return f'[[layer]]\nrecipe = "{name}"\n{more}\n'


def test_a_recipe_file_is_read_like_its_text(folder):
    path = write(folder, "scene.toml", SCENE)
    recipe = nm.read_recipe(path)
    assert recipe.folder == str(folder)
    assert recipe.name == str(path)
    assert recipe.layers[1].origin == f"{path}, line 8: layer 2 (bunny)"
    crlf = folder / "crlf.toml"
    crlf.write_bytes(b"\xef\xbb\xbf" + SCENE.replace("\n", "\r\n").encode())
    assert nm.read_recipe(crlf) == recipe


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            '[[layer]]\nat = 30%,50%\nfile = "a"',
            "not valid TOML at line 2, column 8: found at = 30%,50%; check quotes",
        ),
        ('[[layer]]\nfile = "a', 'not valid TOML at line 2, column 10: found file = "a; check quotes'),
        ("[[layer]\n", "not valid TOML at line 1, column .: found .*layer"),
        ("\n\nx =", "not valid TOML at line 3, column 4: found x ="),
        ('[[layer]]\nfile = "a"\nfile = "b"', 'not valid TOML: a key or table is defined twice, at line 3: file = "b"'),
        ("[canvas]\n[canvas]\n", "not valid TOML: a key or table is defined twice"),
        (f"x = {'[' * 5000}", "lists or tables are nested too deeply for a recipe"),
        (f"x = {'9' * 5000}", "not valid TOML: a number is too long"),
        (f"{'a' * 100} b", r"found a{57}\.\.\.;"),
        ("x = \x01", "not valid TOML at line 1, column 5: found x =;"),
    ],
)
def test_broken_toml_is_refused(folder, text, message):
    path = write(folder, "scene.toml", text)
    with pytest.raises(nm.InputError, match=message) as caught:
        nm.read_recipe(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_files_that_are_not_recipes_are_refused(folder):
    latin = folder / "latin.toml"
    latin.write_bytes('# a\nname = "é"'.encode("latin-1"))
    (folder / "empty.toml").touch()
    nm.write_normal_map(waves(8, 8, 1), folder / "json.png", attributes={"recipe": '{"command": "paste"}'})
    for path, message in (
        (latin, r"latin.toml: is not UTF-8 text \(line 2\); save the recipe as UTF-8"),
        (folder / "empty.toml", "empty.toml: is empty"),
        (folder / "no.toml", "no.toml: no such file"),
        (folder, "is a folder; give a recipe, such as scene.toml"),
        (folder / "plate.exr", "plate.exr: is a picture without a recipe in its metadata; give a recipe"),
        (folder / "json.png", "json.png: was not made by nmap compose stack"),
    ):
        with pytest.raises(nm.InputError, match=message):
            nm.read_recipe(path)
    with pytest.raises(nm.LimitError, match=r"plate.exr: 80 x 60 is .*more than the limit of 0.001"):
        nm.read_recipe(folder / "plate.exr", max_megapixels=0.001)
    with pytest.raises(nm.LimitError, match=r"is 1.2 MB, more than the limit of 1 MB for a recipe"):
        nm.read_recipe(write(folder, "large.toml", ONE + "#" * 1_200_000))


def test_a_recipe_in_a_recipe_is_a_group_with_paths_from_the_outer_folder(folder):
    write(folder, "parts/leaves.toml", '[[layer]]\nfile = "../leaf.png"\nmask = "m.png"\n' + link("more/one.toml"))
    write(folder / "parts", "more/one.toml", ONE)
    path = write(folder, "scene.toml", ONE + link("parts/leaves.toml", 'name = "leaves"\nstrength = 0.5\nmask="w.png"'))
    recipe = nm.read_recipe(path)
    assert recipe.layers == (
        nm.RecipeLayer("plate.exr"),
        nm.RecipeGroup(
            (
                nm.RecipeLayer("parts/../leaf.png", mask="parts/m.png"),
                nm.RecipeGroup((nm.RecipeLayer("parts/more/plate.exr"),), nm.GroupOptions("more/one.toml")),
            ),
            nm.GroupOptions("leaves", strength=0.5),
            "w.png",
        ),
    )
    assert recipe.sources == ("parts/leaves.toml", "parts/more/one.toml")
    assert recipe.layers[1].layers[0].origin == f"{folder / 'parts/leaves.toml'}, line 1: layer 1 (leaf.png)"
    assert recipe.notes == ()


def test_absolute_paths_are_kept_and_an_inner_canvas_is_noted(folder):
    inner = write(
        folder, "sub/inner.toml", f'[canvas]\nsize = "9x9"\n[[layer]]\nfile = "{folder.as_posix()}/leaf.png"\n'
    )
    path = write(folder, "scene.toml", ONE + link(inner.as_posix()))
    recipe = nm.read_recipe(path)
    assert recipe.layers[1].layers[0].file == f"{folder.as_posix()}/leaf.png"
    assert recipe.notes == (f"{inner}: its canvas is ignored; its layers are placed on the canvas of {path}",)


def test_a_hidden_recipe_is_not_read(folder):
    path = write(folder, "scene.toml", ONE + link("missing.toml", "hidden = true"))
    assert nm.read_recipe(path).layers[1].recipe == "missing.toml"
    with pytest.raises(
        nm.InputError, match=r"scene.toml, line 3: layer 2 \(missing.toml\): .*missing.toml: no such file"
    ):
        nm.read_recipe(write(folder, "scene.toml", ONE + link("missing.toml")))
    write(folder, "broken.toml", "x")
    with pytest.raises(
        nm.InputError, match=r"scene.toml, line 3: layer 2 \(broken.toml\): .*broken.toml: is not valid TOML"
    ):
        nm.read_recipe(write(folder, "scene.toml", ONE + link("broken.toml")))


def test_recipes_that_contain_each_other_are_refused(folder, monkeypatch):
    monkeypatch.chdir(folder)
    write(folder, "b.toml", ONE + link("sub/../a.toml"))
    (folder / "sub").mkdir()
    write(folder, "a.toml", ONE + link("b.toml"))
    write(folder, "top.toml", link("a.toml"))
    for name, circle in (
        (
            "a.toml",
            (
                "b.toml, line 3: layer 2 .a.toml.: "
                "recipes include each other: a.toml -> b.toml -> sub/../a.toml; remove one of them"
            ),
        ),
        ("top.toml", "recipes include each other: a.toml -> b.toml -> sub/../a.toml; remove one of them"),
    ):
        with pytest.raises(nm.InputError, match=circle):
            nm.read_recipe(name)


def test_a_recipe_that_includes_itself_under_another_name_is_refused(folder, monkeypatch, symlink):
    monkeypatch.chdir(folder)
    write(folder, "self.toml", link("alias.toml"))
    symlink(folder / "alias.toml", "self.toml")
    with pytest.raises(nm.InputError, match=r"recipes include each other: self.toml -> alias.toml; remove one of them"):
        nm.read_recipe("self.toml")


def test_recipes_that_are_too_deep_or_too_large_are_refused(folder):
    for i in range(20):
        write(folder, f"deep{i}.toml", link(f"deep{i + 1}.toml"))
        write(folder, f"wide{i}.toml", link(f"wide{i + 1}.toml") * 10)
    with pytest.raises(nm.LimitError, match=r"deep15.toml, line 1: .*recipes and groups are nested more than 16 deep"):
        nm.read_recipe(folder / "deep0.toml")
    write(folder, "wide12.toml", ONE)
    with pytest.raises(nm.LimitError, match="there are more than 1000 layers in total; compose in steps"):
        nm.read_recipe(folder / "wide0.toml")
    write(folder, "deep15.toml", ONE)
    assert nm.read_recipe(folder / "deep0.toml").files == ("plate.exr",)


def test_messages_name_the_line(folder):
    path = write(folder, "scene.toml", ONE + "\n# a comment\n\nmode = 'x'\n")
    for start, ending in ((b"", "\n"), (b"\xef\xbb\xbf", "\r\n")):
        path.write_bytes(start + path.read_text(encoding="utf-8-sig").replace("\n", ending).encode())
        with pytest.raises(nm.InputError, match=r'^a stream, line 6: layer 1 \(plate.exr\): mode = "x": use one of'):
            nm.read_recipe(path, name="a stream")
    with pytest.raises(nm.InputError) as caught:
        nm.read_recipe(write(folder, "outer.toml", ONE + link("scene.toml")))
    assert str(caught.value).startswith(f"{path}, line 6: layer 1 (plate.exr): mode")
    one = nm.parse_recipe({"layer": [{"file": "a.png"}]}, name="scene.toml").layers[0]
    assert one.origin == "scene.toml: layer 1 (a.png)"


def test_a_recipe_in_a_picture_has_no_lines(folder):
    recipes = {"good.png": ONE, "bad.png": f"{ONE}mode = 'x'\n"}
    for name, text in recipes.items():
        nm.write_normal_map(waves(8, 8, 1), folder / name, attributes={"recipe": text})
    assert nm.read_recipe(folder / "good.png", name="good.png").layers[0].origin == "good.png: layer 1 (plate.exr)"
    with pytest.raises(nm.InputError, match=r'^bad.png: layer 1 \(plate.exr\): mode = "x": use one of'):
        nm.read_recipe(folder / "bad.png", name="bad.png")


def test_invalid_file_names_are_refused(folder):
    for name in ("a\\u0000.toml", "x" * 300):
        path = write(folder, "scene.toml", link(name))
        with pytest.raises(
            nm.InputError, match=r"scene.toml, line 1: layer 1 .*(is not a valid file name|cannot be read)"
        ):
            nm.read_recipe(path)
