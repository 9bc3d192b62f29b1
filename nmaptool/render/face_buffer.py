"""What a camera sees at each pixel, from one rendering: the face, its distance, any field of normals on the mesh."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.vectors import unit
from nmaptool.render.camera import Camera
from nmaptool.render.numpy_raster import Draw
from nmaptool.types.mesh import Faces, Mesh

# pixels processed at a time
_PIXELS_AT_ONCE = 2_000_000
# largest slope with which depth is extrapolated beside a face
_STEEPEST = 3.0


@dataclass(frozen=True, eq=False)
class FaceBuffer:
    """A rendering of a mesh: the face at each sample.

    Attributes
    ----------
    camera : Camera
        The camera of the picture, not of its samples.
    supersample : int
        Samples across a pixel.
    sampled_faces : (H * s, W * s) int32
        Face at each sample, -1 where nothing is seen.
    vertices : (N, 3) float64
        Vertices in eye space.
    faces : (M, 3) int32
    normals : (M, 3) float64
        Geometric normals of the faces in eye space.
    """

    camera: Camera
    supersample: int
    sampled_faces: NDArray[np.int32]
    vertices: Float64
    faces: Faces
    normals: Float64

    def pixel_faces(self) -> NDArray[np.int32]:
        """(H, W) int32: the face at the sample next to each pixel's centre, else at any of its samples, else -1."""
        s = self.supersample
        middle = s // 2
        out = self.sampled_faces[middle::s, middle::s].copy()
        for row in range(s):
            for col in range(s):
                other = self.sampled_faces[row::s, col::s]
                out = np.where(out < 0, other, out)
        return out

    def depth(self, pixel_faces: NDArray[np.int32]) -> Float32:
        """Distance along the camera's axis at pixel centres.

        Parameters
        ----------
        pixel_faces : (H, W) int32
            From `pixel_faces`.

        Returns
        -------
        (H, W) float32
            In units of the mesh; 0 where nothing is seen. It is measured from the eye of a perspective camera, or from
            the nearest point of the mesh for an orthographic one.
        """
        row, col = np.nonzero(pixel_faces >= 0)
        face = pixel_faces[row, col]
        z = self._hit(face, col.astype(np.float64) + 0.5, row.astype(np.float64) + 0.5)[..., 2]
        height = np.ascontiguousarray(self.vertices[:, 2])
        a, b, c = (height.take(self.faces[:, k].take(face)) for k in range(3))
        low, high = (two(two(a, b), c) for two in (np.minimum, np.maximum))
        # a pixel's centre may lie beside the face that its samples see; limit the depth of grazing faces there
        nx, ny, nz = np.abs(self.normals.take(face, axis=0)).T
        beside = 0.5 * self.camera.unit_per_px * np.minimum((nx + ny) / np.maximum(nz, 1e-12), _STEEPEST)
        z = z.clip(low - beside, high + beside).clip(height.min(), height.max())
        start = self.camera.distance if self.camera.distance is not None else float(self.vertices[:, 2].max())
        out = np.zeros(pixel_faces.shape, np.float32)
        out[row, col] = start - z
        return out

    def _hit(self, face: NDArray[np.int32], col: Float64, row: Float64) -> Float64:
        """Points in eye space where the planes of faces are seen at picture positions."""
        start = self.camera.plane_points(col, row)
        ray = self.camera.rays(col, row)
        anchor, normal = self.vertices.take(self.faces[:, 0].take(face), axis=0), self.normals.take(face, axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            along = np.einsum("ij,ij->i", normal, anchor - start) / np.einsum("ij,ij->i", normal, ray)
        along[~np.isfinite(along)] = 0
        return np.asarray(start + along[:, None] * ray)

    def normal_layer(self, directions: Float64) -> tuple[Float32, Float32]:
        """Render a field of normals, with each normal turned towards the viewer.

        Parameters
        ----------
        directions : (M, 3) or (M, 3, 3) float64
            Directions in the mesh's space, one per face or one per corner (interpolated across the face).

        Returns
        -------
        normals : (H, W, 3) float32
            Unit normals; (0, 0, 1) where nothing is seen. For a perspective camera, their slopes are measured in
            the picture: they integrate to distance * ln(depth), so that the map is that of a height field.
        coverage : (H, W) float32
            Share of the samples that see the mesh.
        """
        s = self.supersample
        rows, cols = self.camera.rows, self.camera.cols
        turned = (directions @ self.camera.rotation.T).astype(np.float32)
        plain = turned.ndim == 2 and self.camera.distance is None  # one vector per face
        if plain:  # a last row for index -1
            turned = np.vstack([self._toward(turned, self.normals[:, 2]), np.zeros((1, 3), np.float32)])
        normals = np.empty((rows, cols, 3), np.float32)
        coverage = np.zeros((rows, cols), np.float32)
        band = max(1, _PIXELS_AT_ONCE // cols)
        for top in range(0, rows, band):
            part = slice(top, min(top + band, rows))
            total = np.zeros((part.stop - top, cols, 3), np.float32)
            for down in range(s):
                for right in range(s):
                    shown = self.sampled_faces[top * s + down : part.stop * s : s, right::s]
                    coverage[part] += shown >= 0
                    if plain:
                        total += turned.take(shown, axis=0)
                    else:
                        seen = shown >= 0
                        row, col = (place.astype(np.float64) for place in np.nonzero(seen))
                        x, y = col + (right + 0.5) / s, row + (top + (down + 0.5) / s)
                        total[seen] += self._at(turned, shown[seen], x, y)
            normals[part] = unit(total)
        coverage /= s * s
        return normals, coverage

    def _at(self, turned: Float32, face: NDArray[np.int32], x: Float64, y: Float64) -> Float32:
        """(K, 3) float32 unit normals of faces at picture positions."""
        ray = self.camera.rays(x, y)
        out = unit(turned.take(face, axis=0) if turned.ndim == 2 else self._interpolated(turned, face, x, y))
        out = self._toward(out, np.einsum("ij,ij->i", self.normals.take(face, axis=0), ray))
        if self.camera.distance is not None:
            out[:, 2] = np.einsum("ij,ij->i", out, ray)
            out = unit(out)
        return out

    @staticmethod
    def _toward(vectors: Float32, facing: Float64) -> Float32:
        return np.where(facing[:, None] < 0, -vectors, vectors)

    def _interpolated(self, turned: Float32, face: NDArray[np.int32], x: Float64, y: Float64) -> Float32:
        point = self._hit(face, x, y)
        a, b, c = (self.vertices.take(self.faces[:, k].take(face), axis=0) for k in range(3))
        ab, ac, ap = b - a, c - a, point - a
        bb, bc, cc = (np.einsum("ij,ij->i", u, v) for u, v in ((ab, ab), (ab, ac), (ac, ac)))
        pb, pc = (np.einsum("ij,ij->i", ap, v) for v in (ab, ac))
        area = bb * cc - bc * bc
        second = ((cc * pb - bc * pc) / area).clip(0, 1)
        third = ((bb * pc - bc * pb) / area).clip(0, 1 - second)
        weights = np.stack([1 - second - third, second, third], axis=-1).astype(np.float32)
        return np.asarray(np.einsum("ij,ijk->ik", weights, turned.take(face, axis=0)))


def supersampled_camera(camera: Camera, factor: int) -> Camera:
    """The camera for the samples of a picture."""
    return replace(
        camera, unit_per_px=camera.unit_per_px / factor, rows=camera.rows * factor, cols=camera.cols * factor
    )


def draw_face_buffer(mesh: Mesh, camera: Camera, draw: Draw, supersample: int) -> FaceBuffer:
    """Render a mesh once.

    Parameters
    ----------
    mesh : Mesh
        Cleaned.
    camera : Camera
    draw : callable
        `nmaptool.render.numpy_raster.visible_faces`, or ``draw`` of `nmaptool.render.gl.drawing`.
    supersample : int
        Samples across a pixel.
    """
    samples = supersampled_camera(camera, supersample)
    shown = draw(samples.project(mesh.vertices), mesh.faces, samples.rows, samples.cols)
    normals = mesh.geometry.normals @ camera.rotation.T
    return FaceBuffer(camera, supersample, shown, camera.to_eye(mesh.vertices), mesh.faces, normals)
