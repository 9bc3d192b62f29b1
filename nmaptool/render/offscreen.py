"""pyrender's offscreen renderer with our own shaders: the only module that calls pyrender.

pyrender has no public way to render with other shaders, to free the buffers of a rendering, or to close one OpenGL
context without the others. Only this module uses these private names; pyproject.toml pins the versions that have them,
and tests/test_private_names.py reports any that is missing:

- ``OffscreenRenderer._renderer`` and ``._platform``
- ``Renderer._program_cache``, ``._update_context``, ``.dpscale`` and ``.delete``
- ``ShaderProgramCache`` with its ``shader_dir``
- ``EGLPlatform._egl_display`` and ``._egl_context``
- ``Platform.make_current`` and ``.supports_framebuffers``
"""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.types.mesh import Faces

PLATFORM_VARIABLE = "PYOPENGL_PLATFORM"
_SHADERS = Path(__file__).parent / "shaders"


class Offscreen:
    """An OpenGL context that renders face numbers."""

    def __init__(self, platform: str) -> None:
        self.platform = platform
        self._offscreen = self._opened(1, 1)

    def _opened(self, rows: int, cols: int) -> Any:
        before = os.environ.get(PLATFORM_VARIABLE)
        if self.platform == "window":
            os.environ.pop(PLATFORM_VARIABLE, None)
        else:
            os.environ[PLATFORM_VARIABLE] = self.platform
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # about the packages themselves
                from pyrender import OffscreenRenderer
                from pyrender.shader_program import ShaderProgramCache

                offscreen = OffscreenRenderer(cols, rows)
            offscreen._renderer.dpscale = 1  # otherwise a Mac renders at twice the size and blends face numbers
            offscreen._renderer._program_cache = ShaderProgramCache(shader_dir=str(_SHADERS))
            return offscreen
        finally:
            if before is None:
                os.environ.pop(PLATFORM_VARIABLE, None)
            else:
                os.environ[PLATFORM_VARIABLE] = before

    def _sized(self, rows: int, cols: int) -> Any:
        """The renderer, resized for pictures of this size."""
        offscreen = self._offscreen
        if (offscreen.viewport_height, offscreen.viewport_width) != (rows, cols):
            if offscreen._platform.supports_framebuffers():
                offscreen.viewport_width, offscreen.viewport_height = cols, rows
            else:  # pyrender would open a new one with its own shaders
                self.close()
                self._offscreen = self._opened(rows, cols)
        return self._offscreen

    def draw(self, positions: NDArray[np.float32], faces: Faces, rows: int, cols: int) -> NDArray[np.uint8]:
        """Render faces with the shaders.

        Parameters
        ----------
        positions : (V, 3) float32
            Positions in clip space, which the shader uses unchanged.
        faces : (F, 3) int32
        rows, cols : int

        Returns
        -------
        (rows, cols, 3 or 4) uint8
            What the shader wrote.
        """
        from pyrender import Mesh, Node, OrthographicCamera, Primitive, RenderFlags, Scene

        scene = Scene()
        scene.add(OrthographicCamera(1.0, 1.0))  # required by pyrender, not used
        node = Node(mesh=Mesh([Primitive(positions=positions, indices=faces.astype(np.uint32))]))
        scene.add_node(node)
        offscreen = self._sized(rows, cols)
        flags = RenderFlags.SEG | RenderFlags.RGBA
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            color: NDArray[np.uint8] = offscreen.render(scene, flags=flags, seg_node_map={node: (0, 0, 0)})[0]
            offscreen._renderer._update_context(Scene(), flags)  # frees the buffers of this rendering
        return color

    def close(self) -> None:
        """Free all resources; pyrender would end the whole display connection, even if other contexts use it."""
        offscreen = self._offscreen
        platform = offscreen._platform
        display = getattr(platform, "_egl_display", None)
        if display is None:
            offscreen.delete()
            return
        from OpenGL import EGL

        platform.make_current()
        offscreen._renderer.delete()
        EGL.eglMakeCurrent(display, EGL.EGL_NO_SURFACE, EGL.EGL_NO_SURFACE, EGL.EGL_NO_CONTEXT)
        EGL.eglDestroyContext(display, platform._egl_context)
        platform._egl_display = platform._egl_context = None
        offscreen._renderer = offscreen._platform = None
