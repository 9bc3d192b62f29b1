"""How long work tells how far it is."""

from collections.abc import Callable

# called with a word for the stage and the share done, 0 to 1
Progress = Callable[[str, float], None]
