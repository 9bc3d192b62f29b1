"""Networks with one hidden layer from a face's descriptor to its normal, in the descriptor's frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.arrays import Float32, Float64, read_only
from nmaptool.errors import InputError

# faces that are worked on at a time: their hidden layer stays in the cache
_AT_ONCE = 4096
# a shorter output has no direction
_NO_DIRECTION = 1e-12


@dataclass(frozen=True, eq=False)
class Network:
    """n = unit(W2 tanh(W1 x + b1) + b2).

    Parameters
    ----------
    w1 : (H, D) float32
    b1 : (H,) float32
    w2 : (3, H) float32
    b2 : (3,) float32

    Raises
    ------
    InputError
        If the shapes do not fit each other, or a weight is not finite.
    """

    w1: Float32
    b1: Float32
    w2: Float32
    b2: Float32

    def __post_init__(self) -> None:
        hidden, inputs = self.w1.shape if self.w1.ndim == 2 else (0, 0)
        shapes = {"w1": (hidden, inputs), "b1": (hidden,), "w2": (3, hidden), "b2": (3,)}
        for name, shape in shapes.items():
            array = getattr(self, name)
            if array.shape != shape or 0 in shape or array.dtype != np.float32:
                raise InputError(f"weights {name} are {array.dtype} {array.shape}, expected float32 {shape}")
            if not np.isfinite(array).all():
                raise InputError(f"weights {name} are not all finite")
            object.__setattr__(self, name, read_only(array))

    def __call__(self, inputs: Float32) -> Float32:
        """(M, 3) float32 unit normals of (M, D) float32 inputs."""
        out = np.empty((len(inputs), 3), np.float32)
        for first in range(0, len(inputs), _AT_ONCE):
            part = inputs[first : first + _AT_ONCE]
            raw = np.tanh(part @ self.w1.T + self.b1) @ self.w2.T + self.b2
            length = np.sqrt(np.einsum("ij,ij->i", raw, raw))[:, None]
            out[first : first + _AT_ONCE] = raw / np.maximum(length, _NO_DIRECTION)
        return out


def count_parameters(inputs: int, hidden: int) -> int:
    """Weights of one network."""
    return hidden * (inputs + 4) + 3


def split_parameters(flat: Float64, inputs: int, hidden: int) -> tuple[Float64, Float64, Float64, Float64]:
    """W1, b1, W2, b2 as views of one vector."""
    ends = np.cumsum([hidden * inputs, hidden, 3 * hidden])
    w1, b1, w2, b2 = np.split(flat, ends)
    return w1.reshape(hidden, inputs), b1, w2.reshape(3, hidden), b2


def loss_and_gradient(
    flat: Float64, inputs: Float32, targets: Float32, hidden: int, weight_decay: float
) -> tuple[float, Float64]:
    """Mean squared distance of the *normalised* outputs from the targets, plus the decay, and its gradient.

    Normalising first leaves the network free in the length of what it puts out, which nobody uses.

    Parameters
    ----------
    flat : (P,) float64
        Weights, see `split_parameters`.
    inputs : (N, D) float32
    targets : (N, 3) float32
        Unit vectors.
    hidden : int
    weight_decay : float
        Times the sum of squares of W1 and W2.
    """
    width = inputs.shape[1]
    w1, b1, w2, b2 = (part.astype(np.float32) for part in split_parameters(flat, width, hidden))
    total = 0.0
    slope = np.zeros_like(flat)
    d1, db1, d2, db2 = split_parameters(slope, width, hidden)
    for first in range(0, len(inputs), _AT_ONCE):
        x, t = inputs[first : first + _AT_ONCE], targets[first : first + _AT_ONCE]
        middle = np.tanh(x @ w1.T + b1)
        raw = middle @ w2.T + b2
        length = np.maximum(np.sqrt(np.einsum("ij,ij->i", raw, raw)), _NO_DIRECTION)[:, None]
        raw /= length
        # |n - t|^2 = 2 - 2 n.t, whose gradient is what of -2 t is across n, over the length
        agree = np.einsum("ij,ij->i", raw, t)[:, None]
        total += float((2 - 2 * agree).sum(dtype=np.float64))
        across = (raw * agree - t) * (2 / length)
        d2 += across.T @ middle
        db2 += across.sum(axis=0)
        back = (across @ w2) * (1 - middle * middle)
        d1 += back.T @ x
        db1 += back.sum(axis=0)
    slope /= len(inputs)
    d1 += 2 * weight_decay * w1
    d2 += 2 * weight_decay * w2
    decay = weight_decay * float((w1 * w1).sum(dtype=np.float64) + (w2 * w2).sum(dtype=np.float64))
    return total / len(inputs) + decay, slope
