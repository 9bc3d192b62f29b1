/* Transfer between a level of the multigrid solver and the next coarser one, and the steps of conjugate gradients. */

#ifndef NMAPTOOL_TRANSFER_H
#define NMAPTOOL_TRANSFER_H

#include "arrays.h"
#include "grid.h"
#include <stdlib.h>

/* weights of a coarse vertex at its fine neighbours, in the layout of the coarse grid */
enum { B_W, B_E, U_N, U_S, D_NW, D_NE, D_SW, D_SE, WAYS };

/* One coarse row of the residual: `on`, `over` and `under` are the fine row at the vertices, above and below. Each loop takes
   the fine columns in pairs, so that loads become vectors; `carry` (cols + 1) holds what a pair gives to the next vertex. */
KERNEL void restrict_row(const float *restrict on, const float *restrict over, const float *restrict under,
                         const float *const *w, Py_ssize_t cols, Py_ssize_t fine, float *restrict carry, float *restrict out) {
    const float *b_w = w[B_W], *b_e = w[B_E], *u_n = w[U_N], *d_nw = w[D_NW], *d_ne = w[D_NE];
    const float *u_s = w[U_S] - cols, *d_sw = w[D_SW] - cols, *d_se = w[D_SE] - cols;
    Py_ssize_t pairs = fine / 2, last = cols - 1;
    for (Py_ssize_t j = 0; j < pairs; j++) {
        float beside = on[2 * j + 1], below = under[2 * j + 1], above = over[2 * j + 1];
        out[j] = on[2 * j] + b_w[j] * beside + u_n[j] * under[2 * j] + d_nw[j] * below + u_s[j] * over[2 * j] + d_sw[j] * above;
        carry[j + 1] = b_e[j] * beside + d_ne[j] * below + d_se[j] * above;
    }
    if (pairs < cols) out[last] = on[2 * last] + u_n[last] * under[2 * last] + u_s[last] * over[2 * last];
    carry[0] = 0;
    for (Py_ssize_t j = 0; j < cols; j++) out[j] += carry[j];
}

/* Adds the interpolation of one coarse row to the fine row at its vertices and the row below; NULL if there is none. */
KERNEL void prolong_row(const float *restrict x, const float *const *w, Py_ssize_t cols, Py_ssize_t fine, float *restrict on,
                        float *restrict under) {
    const float *b_w = w[B_W], *b_e = w[B_E], *u_n = w[U_N], *u_s = w[U_S], *next = x + cols;
    const float *d_nw = w[D_NW], *d_ne = w[D_NE], *d_sw = w[D_SW], *d_se = w[D_SE];
    Py_ssize_t pairs = fine / 2, last = cols - 1;
    for (Py_ssize_t j = 0; j < pairs; j++) {
        on[2 * j] += x[j];
        on[2 * j + 1] += b_w[j] * x[j] + b_e[j] * x[j + 1];
    }
    if (pairs < cols) on[2 * last] += x[last];
    if (!under) return;
    for (Py_ssize_t j = 0; j < pairs; j++) {
        under[2 * j] += u_n[j] * x[j] + u_s[j] * next[j];
        under[2 * j + 1] += (d_nw[j] * x[j] + d_ne[j] * x[j + 1]) + (d_sw[j] * next[j] + d_se[j] * next[j + 1]);
    }
    if (pairs < cols) under[2 * last] += u_n[last] * x[last] + u_s[last] * next[last];
}

static void at_row(const Array *arrays, Py_ssize_t cols, Py_ssize_t row, const float **w) {
    for (int k = 0; k < WAYS; k++) w[k] = FLOATS(arrays[k]) + (cols + 1) + row * cols;
}

static int weights_fit(const Array *arrays, Py_ssize_t rows, Py_ssize_t cols) {
    int fits = rows >= 0 && cols > 0;
    for (int k = 0; k < WAYS; k++) fits &= LENGTH(arrays[k]) >= rows * cols + 2 * (cols + 1);
    return fits;
}

/* restrict(b_w, b_e, u_n, u_s, d_nw, d_ne, d_sw, d_se, fine, out, fine_cols, cols, top, first, last) -> 0.0 */
static PyObject *restrict_rows(PyObject *self, PyObject *args) {
    PyObject *o[WAYS + 2];
    Array arrays[WAYS + 2];
    Py_ssize_t fine_cols, cols, top, first, last;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOOOOOOnnnnn", &o[0], &o[1], &o[2], &o[3], &o[4], &o[5], &o[6], &o[7], &o[8], &o[9],
                          &fine_cols, &cols, &top, &first, &last) ||
        !take_arrays(o, arrays, "ffffffffff", WAYS + 2, 1))
        return NULL;
    Py_ssize_t rows = fine_cols > 0 ? LENGTH(arrays[WAYS]) / fine_cols : 0; /* from fine row 2 * first + top */
    int fits = weights_fit(arrays, last, cols) && 0 <= first && first <= last && (top == 0 || top == -1) &&
               cols == (fine_cols + 1) / 2 && rows >= 2 * (last - first) - 1 - top && LENGTH(arrays[WAYS + 1]) >= last * cols;
    /* a row of zeros, for the rows outside, and what pairs carry on */
    float *room = fits ? calloc(fine_cols + cols + 1, sizeof(float)) : NULL;
    if (room) {
        Py_BEGIN_ALLOW_THREADS
        const float *fine = FLOATS(arrays[WAYS]);
        for (Py_ssize_t i = first; i < last; i++) {
            const float *w[WAYS];
            Py_ssize_t at = 2 * (i - first) - top;
            at_row(arrays, cols, i, w);
            restrict_row(fine + at * fine_cols, at > 0 ? fine + (at - 1) * fine_cols : room,
                         at + 1 < rows ? fine + (at + 1) * fine_cols : room, w, cols, fine_cols, room + fine_cols,
                         FLOATS(arrays[WAYS + 1]) + i * cols);
        }
        Py_END_ALLOW_THREADS
        free(room);
    }
    return finished_with(arrays, WAYS + 2, fits, room != NULL, 0);
}

/* prolong(b_w, b_e, u_n, u_s, d_nw, d_ne, d_sw, d_se, coarse, fine, fine_cols, cols, fine_rows, first, last) -> 0.0 */
static PyObject *prolong_rows(PyObject *self, PyObject *args) {
    PyObject *o[WAYS + 2];
    Array arrays[WAYS + 2];
    Py_ssize_t fine_cols, cols, fine_rows, first, last;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOOOOOOnnnnn", &o[0], &o[1], &o[2], &o[3], &o[4], &o[5], &o[6], &o[7], &o[8], &o[9],
                          &fine_cols, &cols, &fine_rows, &first, &last) ||
        !take_arrays(o, arrays, "ffffffffff", WAYS + 2, 1))
        return NULL;
    int fits = weights_fit(arrays, last, cols) && 0 <= first && first <= last && cols == (fine_cols + 1) / 2 &&
               2 * last <= fine_rows + 1 && LENGTH(arrays[WAYS]) >= last * cols + 2 * (cols + 1) &&
               LENGTH(arrays[WAYS + 1]) >= fine_rows * fine_cols + 2 * (fine_cols + 1);
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        float *fine = FLOATS(arrays[WAYS + 1]) + fine_cols + 1;
        for (Py_ssize_t i = first; i < last; i++) {
            const float *w[WAYS];
            float *on = fine + 2 * i * fine_cols;
            at_row(arrays, cols, i, w);
            prolong_row(FLOATS(arrays[WAYS]) + cols + 1 + i * cols, w, cols, fine_cols, on,
                        2 * i + 1 < fine_rows ? on + fine_cols : NULL);
        }
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, WAYS + 2, fits, 1, 0);
}

KERNEL void move_by(double *restrict z, float *restrict left, const float *restrict direction, const float *restrict product,
                    double length, double size, Py_ssize_t count) {
    double far = length * size;
    float near = (float)length;
    for (Py_ssize_t i = 0; i < count; i++) {
        z[i] += far * direction[i];
        left[i] -= near * product[i];
    }
}

/* move(direction, product, z, left, length, size, start, stop, margin) -> float: the squared norm of the new residual */
static PyObject *move(PyObject *self, PyObject *args) {
    PyObject *o[4];
    Array arrays[4];
    double length, size, total = 0;
    Py_ssize_t start, stop, margin;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOddnnn", &o[0], &o[1], &o[2], &o[3], &length, &size, &start, &stop, &margin) ||
        !take_arrays(o, arrays, "ffdf", 4, 2))
        return NULL;
    int fits = 0 <= start && start <= stop && margin >= 0 && LENGTH(arrays[0]) >= stop + margin;
    for (int i = 1; i < 4; i++) fits &= LENGTH(arrays[i]) >= stop;
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        float *left = FLOATS(arrays[3]) + start;
        move_by(DOUBLES(arrays[2]) + start, left, FLOATS(arrays[0]) + margin + start, FLOATS(arrays[1]) + start, length, size,
                stop - start);
        total = dot(left, left, stop - start);
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 4, fits, 1, total);
}

#endif
