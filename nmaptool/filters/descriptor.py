"""The input of a learned filter: normals of each face, filtered by rolling guidance with several widths and ranges."""

from __future__ import annotations

import itertools

import numpy as np

from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.parallel import map_parallel
from nmaptool.core.progress import Progress
from nmaptool.filters.rolling import Gather, mean_normals
from nmaptool.filters.surface import Neighborhood, Roughness
from nmaptool.options import DescriptorOptions
from nmaptool.types.mesh import Mesh

# approximate sums are enough for the networks, which are trained on them: 0.3 degrees off on average, in a third of the
# time
_ROUGH = Roughness(alike=1.0, pairs_per_face=400.0)


class Describer:
    """Filtered normals of one mesh (the descriptor of paper, Sec. 3.2), with any guide.

    Parameters
    ----------
    mesh : Mesh
        Clean and welded; its normals are filtered.
    options : DescriptorOptions
    """

    def __init__(self, mesh: Mesh, options: DescriptorOptions) -> None:
        self.options = options
        self._normals = mesh.geometry.normals
        sizes = [size * mesh.mean_edge for size in options.sigma_s]
        self._surroundings = map_parallel(sizes, lambda size: Neighborhood(mesh, size))

    def __call__(self, guide: Float64 | None = None, progress: Progress | None = None) -> Float32:
        """Return the descriptors.

        Parameters
        ----------
        guide : (M, 3) float64, optional
            Unit normals, such as the result of the previous stage: the range weights are computed from them, in one
            pass. Default: no guide, as in the first pass of rolling guidance, and ``options.passes`` passes.
        progress : callable, optional

        Returns
        -------
        (M, K, 4) float32
            Unit normals and the agreement of the normals around the face, 0 to 1: all ranges of the first width, then
            all of the second, and so on.
        """
        options = self.options
        widths, ranges = range(len(options.sigma_s)), range(len(options.sigma_r))
        out = np.empty((len(self._normals), options.size, 4), np.float32)
        # the first pass without a guide is the same for all ranges
        blurred = None if guide is not None else map_parallel(widths, lambda width: self._gather(width, 0)(None))
        passes = options.passes if guide is None else 1
        done = itertools.count(1)  # shared by all threads

        def describe(task: tuple[int, int]) -> None:
            width, place = task
            gather = self._gather(width, place)
            sums = gather(guide) if blurred is None else blurred[width]
            for step in range(passes):
                found, agreement = mean_normals(self._normals, sums)
                if step < passes - 1:
                    sums = gather(found)
            here = out[:, width * len(ranges) + place]
            here[:, :3], here[:, 3] = found, agreement
            if progress is not None:
                progress("describing", next(done) / options.size)

        # narrow widths take longest; starting with them keeps all threads busy until the end
        map_parallel([(width, place) for width in widths for place in ranges], describe)
        return out

    def _gather(self, width: int, place: int) -> Gather:
        return self._surroundings[width].gather(self._normals, self.options.sigma_r[place], _ROUGH)
