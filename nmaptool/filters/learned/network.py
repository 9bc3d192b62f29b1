"""Networks with one hidden layer that mix a face's own normal and its filtered normals.

The output of a network is the shares of these normals in a weighted mean, which is then normalised. The result thus
lies between the filtered normals, however unusual a neighbourhood is. Networks that output the components of the normal
had larger errors, both on the training meshes and on others (docs/decisions/0017-learned-filter.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nmaptool.core.arrays import Float32, Float64, read_only
from nmaptool.core.errors import InputError

# faces per batch: their hidden layer fits in the cache
_AT_ONCE = 4096
# normals that cancel out have no mean direction
_NO_DIRECTION = 1e-12


@dataclass(frozen=True, eq=False)
class Network:
    """n = unit(sum_k s_k n_k), s = softmax(W2 tanh(W1 x + b1) + b2); x begins with the components of n_1 ... n_K.

    Parameters
    ----------
    w1 : (H, D) float32
        D at least 3 K.
    b1 : (H,) float32
    w2 : (K, H) float32
    b2 : (K,) float32

    Raises
    ------
    InputError
        If the shapes do not match, or a weight is not finite.
    """

    w1: Float32
    b1: Float32
    w2: Float32
    b2: Float32

    def __post_init__(self) -> None:
        hidden, inputs = self.w1.shape if self.w1.ndim == 2 else (0, 0)
        mixed = len(self.b2)
        shapes = {"w1": (hidden, max(inputs, 3 * mixed)), "b1": (hidden,), "w2": (mixed, hidden), "b2": (mixed,)}
        for name, shape in shapes.items():
            array = getattr(self, name)
            if array.shape != shape or 0 in shape or array.dtype != np.float32:
                raise InputError(f"the weights {name} must be float32 {shape}; found {array.dtype} {array.shape}")
            if not np.isfinite(array).all():
                raise InputError(f"the weights {name} must be finite")
            object.__setattr__(self, name, read_only(array))

    def __call__(self, inputs: Float32) -> Float32:
        """Return (M, 3) float32 unit normals for (M, D) float32 inputs."""
        out = np.empty((len(inputs), 3), np.float32)
        for first in range(0, len(inputs), _AT_ONCE):
            x = inputs[first : first + _AT_ONCE]
            shares = _softmax(np.tanh(x @ self.w1.T + self.b1) @ self.w2.T + self.b2)
            out[first : first + _AT_ONCE] = _mean(shares, _normals(x, shares.shape[1]))[0]
        return out


def _normals(inputs: Float32, mixed: int) -> Float32:
    """Return the (M, K, 3) float32 normals at the beginning of the inputs."""
    return inputs[:, : 3 * mixed].reshape(len(inputs), mixed, 3)


def _softmax(values: Float32) -> Float32:
    values -= values.max(axis=1, keepdims=True)
    np.exp(values, out=values)
    values /= values.sum(axis=1, keepdims=True)
    return values


def _mean(shares: Float32, normals: Float32) -> tuple[Float32, Float32]:
    """Return the normalised means of (M, K, 3) normals weighted by (M, K) shares, and their (M, 1) lengths before."""
    mean = np.matmul(shares[:, None], normals)[:, 0]
    length = np.maximum(np.sqrt(np.einsum("ij,ij->i", mean, mean)), _NO_DIRECTION)[:, None]
    return mean / length, length


class Shape(NamedTuple):
    """Sizes of a network: its inputs, hidden units and mixed normals."""

    inputs: int
    hidden: int
    mixed: int

    @property
    def weights(self) -> int:
        """Number of weights."""
        return self.hidden * (self.inputs + 1) + (self.hidden + 1) * self.mixed


def split_parameters(flat: Float64, shape: Shape) -> tuple[Float64, Float64, Float64, Float64]:
    """Return W1, b1, W2, b2 as views of one vector."""
    inputs, hidden, mixed = shape
    w1, b1, w2, b2 = np.split(flat, np.cumsum([hidden * inputs, hidden, mixed * hidden]))
    return w1.reshape(hidden, inputs), b1, w2.reshape(mixed, hidden), b2


@dataclass(frozen=True, eq=False)
class TrainingLoss:
    """The loss that fitting a network minimises.

    Parameters
    ----------
    inputs : (N, D) float32
        Inputs, beginning with the components of the normals to mix.
    targets : (N, 3) float32
        Unit normals.
    mean, spread : (D,) float64
        The mean is subtracted from the inputs and the result divided by the spread, before the hidden layer.
    """

    inputs: Float32
    targets: Float32
    mean: Float64
    spread: Float64

    def loss(self, flat: Float64, shape: Shape, weight_decay: float) -> tuple[float, Float64]:
        """Return the mean squared distance of the *normalised* means to the targets plus the decay, and its gradient.

        Parameters
        ----------
        flat : (P,) float64
            Weights; see `split_parameters`.
        shape : Shape
        weight_decay : float
            Factor on the sum of squares of W1 and W2.
        """
        w1, b1, w2, b2 = (part.astype(np.float32) for part in split_parameters(flat, shape))
        off, scale = self.mean.astype(np.float32), (1 / self.spread).astype(np.float32)
        total, slope = 0.0, np.zeros_like(flat)
        d1, db1, d2, db2 = split_parameters(slope, shape)
        for first in range(0, len(self.inputs), _AT_ONCE):
            x, target = self.inputs[first : first + _AT_ONCE], self.targets[first : first + _AT_ONCE]
            normals = _normals(x, shape.mixed)
            scaled = (x - off) * scale
            middle = np.tanh(scaled @ w1.T + b1)
            shares = _softmax(middle @ w2.T + b2)
            found, length = _mean(shares, normals)
            total += float(np.square(found - target).sum(dtype=np.float64))
            # |n - t|^2 = 2 - 2 n.t; its gradient is the part of -2 t perpendicular to n, divided by the length
            agree = np.einsum("ij,ij->i", found, target)[:, None]
            across = (found * agree - target) * (2 / length)
            by_share = np.matmul(normals, across[:, :, None])[:, :, 0]
            by_value = shares * (by_share - np.einsum("ij,ij->i", shares, by_share)[:, None])
            d2 += by_value.T @ middle
            db2 += by_value.sum(axis=0)
            back = (by_value @ w2) * (1 - middle * middle)
            d1 += back.T @ scaled
            db1 += back.sum(axis=0)
        slope /= len(self.inputs)
        d1 += 2 * weight_decay * w1
        d2 += 2 * weight_decay * w2
        decay = weight_decay * float((w1 * w1).sum(dtype=np.float64) + (w2 * w2).sum(dtype=np.float64))
        return total / len(self.inputs) + decay, slope
