"""Write recipes."""

from __future__ import annotations

from pathlib import Path

from nmaptool.composition.recipe_toml import relief_to_toml, to_toml
from nmaptool.io.output.writing import write_together
from nmaptool.types.recipe import Recipe, RecipeRelief


def write_recipe(recipe: Recipe, path: str | Path, *, overwrite: bool = False) -> None:
    """Write a recipe as a TOML file.

    Parameters
    ----------
    recipe : Recipe
        Its file names should be relative to the folder of ``path``.
    path : str or Path
    overwrite : bool
        Whether to replace a file that exists.

    Raises
    ------
    OutputError
        If the file exists and ``overwrite`` is False, or cannot be written.
    InputError
        If a file name in the recipe is not valid UTF-8.

    Examples
    --------
    >>> recipe = nm.parse_recipe({"layer": [{"file": "plate.png"}], "relief": {"mu": 0.5}})
    >>> nm.write_recipe(recipe, "scene.toml")
    >>> nm.read_recipe("scene.toml") == recipe
    True
    """
    text = to_toml(recipe)
    write_together([(Path(path), lambda file: file.write_text(text, encoding="utf-8"))], overwrite)


def write_relief_table(relief: RecipeRelief, path: Path, *, overwrite: bool = False) -> None:
    """Write the table ``[relief]`` of a recipe alone, such as a preset; errors as for `write_recipe`."""
    text = relief_to_toml(relief)
    write_together([(path, lambda file: file.write_text(text, encoding="utf-8"))], overwrite)
