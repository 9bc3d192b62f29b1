/* One step of conjugate gradients on the finest level: the new direction and its product with the matrix, in one sweep. */

#ifndef NMAPTOOL_DIRECTIONS_H
#define NMAPTOOL_DIRECTIONS_H

#include "arrays.h"
#include "grid.h"
#include <stdlib.h>

KERNEL void steer_row(float *restrict direction, const float *restrict other, float turn, Py_ssize_t cols) {
    for (Py_ssize_t j = 0; j < cols; j++) direction[j] = turn * direction[j] + other[j];
}

/* Flow between the upper and lower side of each face: quarter * (difference of the left + of the right pair). */
KERNEL void flow_between(const float *restrict x, const float *restrict next, const float *restrict quarter, Py_ssize_t cols,
                         float *restrict flow) {
    for (Py_ssize_t j = 0; j < cols; j++) flow[j] = quarter[j] * ((next[j] - x[j]) + (next[j + 1] - x[j + 1]));
}

/* A row of A x from differences. */
KERNEL void row_of_product(const float *restrict x, const float *restrict over, const float *restrict quarter,
                           const float *restrict beta, const float *restrict above, const float *restrict below,
                           Py_ssize_t cols, float *restrict out) {
    for (Py_ssize_t j = 0; j < cols; j++) {
        float west = (x[j] - x[j - 1]) * (over[j - 1] + quarter[j - 1]);
        float east = (x[j + 1] - x[j]) * (over[j] + quarter[j]);
        out[j] = 2.0f * (west - east) + ((above[j - 1] + above[j]) - (below[j - 1] + below[j])) + beta[j] * x[j];
    }
}

KERNEL void only_unknown(const uint8_t *restrict unknown, Py_ssize_t cols, float *restrict out) {
    for (Py_ssize_t j = 0; j < cols; j++) out[j] = unknown[j] ? out[j] : 0.0f;
}

/* What a band of rows is computed from; `above` and `below` are the new direction beside the band. */
typedef struct {
    const float *quarter, *beta, *above, *below;
    const uint8_t *unknown; /* NULL if no vertex is held */
    Py_ssize_t rows, cols;
} Band;

static double advance(const Band *b, float *direction, float *other, Py_ssize_t first, Py_ssize_t last, float turn,
                      float *room) {
    Py_ssize_t cols = b->cols;
    float *flows[2] = {room + 1, room + cols + 3};
    double total = 0;
    if (first < last) steer_row(direction + first * cols, other + first * cols, turn, cols);
    if (first > 0) flow_between(b->above, direction + first * cols, b->quarter + (first - 1) * cols, cols, flows[(first + 1) % 2]);
    for (Py_ssize_t row = first; row < last; row++) {
        float *x = direction + row * cols, *out = other + row * cols, *above = flows[(row + 1) % 2], *below = flows[row % 2];
        const float *quarter = b->quarter + row * cols, *next = row + 1 < last ? x + cols : b->below;
        if (row + 1 < last) steer_row(x + cols, out + cols, turn, cols);
        if (row + 1 < b->rows) flow_between(x, next, quarter, cols, below);
        else memset(below, 0, cols * sizeof(float));
        row_of_product(x, quarter - cols, quarter, b->beta + row * cols, above, below, cols, out);
        if (b->unknown) only_unknown(b->unknown + row * cols, cols, out);
        total += dot(x, out, cols);
    }
    return total;
}

/* finest_advance((quarter, beta, unknown, above, below), (direction, other), rows, cols, first, last, turn, holds) -> float */
static PyObject *finest_advance(PyObject *self, PyObject *args) {
    PyObject *tuples[2];
    Array arrays[7];
    Py_ssize_t rows, cols, first, last;
    double turn, total = 0;
    int holds;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!nnnndp", &PyTuple_Type, &tuples[0], &PyTuple_Type, &tuples[1], &rows, &cols, &first, &last,
                          &turn, &holds) ||
        !take_tuples(tuples, (int[]){5, 2}, 2, arrays, "ff?ffff"))
        return NULL;
    Py_ssize_t edge = cols + 1;
    int fits = rows > 0 && cols > 0 && 0 <= first && first <= last && last <= rows &&
               LENGTH(arrays[0]) >= rows * cols + 2 * edge && LENGTH(arrays[1]) >= rows * cols &&
               LENGTH(arrays[2]) >= rows * cols && LENGTH(arrays[3]) >= edge && LENGTH(arrays[4]) >= edge &&
               LENGTH(arrays[5]) >= rows * cols + 2 * edge && LENGTH(arrays[6]) >= rows * cols;
    float *room = fits ? calloc(2 * (cols + 2), sizeof(float)) : NULL;
    if (room) {
        Band band = {FLOATS(arrays[0]) + edge, FLOATS(arrays[1]), FLOATS(arrays[3]), FLOATS(arrays[4]),
                     holds ? (uint8_t *)arrays[2].buf : NULL, rows, cols};
        Py_BEGIN_ALLOW_THREADS
        total = advance(&band, FLOATS(arrays[5]) + edge, FLOATS(arrays[6]), first, last, (float)turn, room);
        Py_END_ALLOW_THREADS
        free(room);
    }
    return finished_with(arrays, 7, fits, room != NULL, total);
}

#endif
