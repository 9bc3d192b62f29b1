/* The finest level and the coarse levels of the multigrid solver: smoothing and products, on flat float32 fields.

Fields with margins hold `edge` = cols + 1 more numbers before the first and after the last vertex. A face is stored at its
upper left vertex. */

#ifndef NMAPTOOL_GRID_H
#define NMAPTOOL_GRID_H

#include "arrays.h"
#include <stdlib.h>

/* vertices at once: the buffer of the faces around them stays in the cache */
enum { CHUNK = 8192 };

/* Sum of products, in float64 every so often. */
SUMMING double dot(const float *restrict one, const float *restrict other, Py_ssize_t count) {
    ANY_ORDER
    double total = 0;
    for (Py_ssize_t first = 0; first < count; first += 512) {
        Py_ssize_t last = first + 512 < count ? first + 512 : count;
        float part = 0;
        for (Py_ssize_t i = first; i < last; i++) part += one[i] * other[i];
        total += part;
    }
    return total;
}

/* Flow between the upper and lower side of each face: quarter * (difference of the left + of the right pair). */
KERNEL void face_flow(const float *restrict x, const float *restrict quarter, Py_ssize_t cols, Py_ssize_t count,
                      float *restrict flow) {
    for (Py_ssize_t i = 0; i < count; i++)
        flow[i] = quarter[i] * ((x[i + cols] - x[i]) + (x[i + cols + 1] - x[i + 1]));
}

/* Sum of the four corners of each face, times its quarter. */
KERNEL void face_sum(const float *restrict x, const float *restrict quarter, Py_ssize_t cols, Py_ssize_t count,
                     float *restrict sum) {
    for (Py_ssize_t i = 0; i < count; i++)
        sum[i] = quarter[i] * ((x[i] + x[i + 1]) + (x[i + cols] + x[i + cols + 1]));
}

/* A x from differences; `flow` holds the faces from the upper left of the first vertex. */
KERNEL void product_of(const float *restrict x, const float *restrict quarter, const float *restrict beta,
                       const float *restrict flow, Py_ssize_t cols, Py_ssize_t count, float *restrict out) {
    for (Py_ssize_t i = 0; i < count; i++) {
        float west = (x[i] - x[i - 1]) * (quarter[i - cols - 1] + quarter[i - 1]);
        float east = (x[i + 1] - x[i]) * (quarter[i - cols] + quarter[i]);
        float above = flow[i] + flow[i + 1], below = flow[i + cols] + flow[i + cols + 1];
        out[i] = 2.0f * (west - east) + (above - below) + beta[i] * x[i];
    }
}

KERNEL void only_unknown(const uint8_t *restrict unknown, Py_ssize_t count, float *restrict out) {
    for (Py_ssize_t i = 0; i < count; i++) out[i] = unknown[i] ? out[i] : 0.0f;
}

KERNEL void left_of(const float *restrict sum, const float *restrict residual, Py_ssize_t cols, Py_ssize_t count, float share,
                    float *restrict out) {
    for (Py_ssize_t i = 0; i < count; i++)
        out[i] = (sum[i] + sum[i + 1]) + (sum[i + cols] + sum[i + cols + 1]) + share * residual[i];
}

KERNEL void finish_of(const float *restrict sum, const float *restrict residual, const float *restrict step,
                      const float *restrict z, Py_ssize_t cols, Py_ssize_t count, float share, float *restrict out) {
    for (Py_ssize_t i = 0; i < count; i++) {
        float pull = (sum[i] + sum[i + 1]) + (sum[i + cols] + sum[i + cols + 1]) + residual[i];
        out[i] = share * z[i] + step[i] * pull;
    }
}

/* Sum over the eight neighbours of coupling times x. */
#define NEIGHBOURS(i)                                                                                                          \
    (e[i] * x[(i) + 1] + e[(i)-1] * x[(i)-1] + s[i] * x[(i) + cols] + s[(i)-cols] * x[(i)-cols] + se[i] * x[(i) + cols + 1] +   \
     se[(i)-cols - 1] * x[(i)-cols - 1] + sw[i] * x[(i) + cols - 1] + sw[(i)-cols + 1] * x[(i)-cols + 1])

KERNEL void step_of(const float *restrict e, const float *restrict s, const float *restrict se, const float *restrict sw,
                    const float *restrict load, const float *restrict inverse, const float *restrict x, Py_ssize_t cols,
                    Py_ssize_t count, float length, float *restrict out) {
    for (Py_ssize_t i = 0; i < count; i++)
        out[i] = (1.0f - length) * x[i] + length * inverse[i] * (load[i] + NEIGHBOURS(i));
}

KERNEL void rest_of(const float *restrict e, const float *restrict s, const float *restrict se, const float *restrict sw,
                    const float *restrict load, const float *restrict diagonal, const float *restrict x, Py_ssize_t cols,
                    Py_ssize_t count, float *restrict out) {
    for (Py_ssize_t i = 0; i < count; i++) out[i] = load[i] - diagonal[i] * x[i] + NEIGHBOURS(i);
}

/* Whether `with` fields with margins and `plain` ones without reach up to vertex `stop`. */
static int fields_fit(const Array *with, int withs, const Array *plain, int plains, Py_ssize_t cols, Py_ssize_t start,
                      Py_ssize_t stop) {
    int fits = cols > 0 && 0 <= start && start <= stop;
    for (int i = 0; i < withs; i++) fits &= LENGTH(with[i]) >= stop + 2 * (cols + 1);
    for (int i = 0; i < plains; i++) fits &= LENGTH(plain[i]) >= stop;
    return fits;
}

/* finest_product(quarter, x, beta, unknown, out, cols, start, stop, holds) -> float */
static PyObject *finest_product(PyObject *self, PyObject *args) {
    PyObject *objects[5];
    Array arrays[5];
    Py_ssize_t cols, start, stop;
    int holds;
    double total = 0;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOnnnp", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4], &cols, &start,
                          &stop, &holds) ||
        !take_arrays(objects, arrays, "fff?f", 5, 1))
        return NULL;
    int fits = fields_fit(arrays, 2, arrays + 2, 3, cols, start, stop);
    float *room = fits ? malloc((CHUNK + cols + 2) * sizeof(float)) : NULL;
    if (room) {
        Py_BEGIN_ALLOW_THREADS
        for (Py_ssize_t at = start; at < stop; at += CHUNK) {
            Py_ssize_t count = stop - at < CHUNK ? stop - at : CHUNK, here = at + cols + 1;
            const float *quarter = FLOATS(arrays[0]) + here, *x = FLOATS(arrays[1]) + here;
            float *out = FLOATS(arrays[4]) + at;
            face_flow(x - cols - 1, quarter - cols - 1, cols, count + cols + 1, room);
            product_of(x, quarter, FLOATS(arrays[2]) + at, room, cols, count, out);
            if (holds) only_unknown((uint8_t *)arrays[3].buf + at, count, out);
            total += dot(x, out, count);
        }
        Py_END_ALLOW_THREADS
        free(room);
    }
    return finished_with(arrays, 5, fits, room != NULL, total);
}

/* finest_left(quarter, z, residual, out, cols, start, stop, share): the residual after the first step from zero */
static PyObject *finest_left(PyObject *self, PyObject *args) {
    PyObject *objects[4];
    Array arrays[4];
    Py_ssize_t cols, start, stop;
    double share;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOnnnd", &objects[0], &objects[1], &objects[2], &objects[3], &cols, &start, &stop, &share) ||
        !take_arrays(objects, arrays, "ffff", 4, 1))
        return NULL;
    int fits = fields_fit(arrays, 2, arrays + 2, 1, cols, start, stop) && LENGTH(arrays[3]) >= stop - start;
    float *room = fits ? malloc((CHUNK + cols + 2) * sizeof(float)) : NULL;
    if (room) {
        Py_BEGIN_ALLOW_THREADS
        for (Py_ssize_t at = start; at < stop; at += CHUNK) {
            Py_ssize_t count = stop - at < CHUNK ? stop - at : CHUNK, first = at;
            face_sum(FLOATS(arrays[1]) + first, FLOATS(arrays[0]) + first, cols, count + cols + 1, room);
            left_of(room, FLOATS(arrays[2]) + at, cols, count, (float)share, FLOATS(arrays[3]) + at - start);
        }
        Py_END_ALLOW_THREADS
        free(room);
    }
    return finished_with(arrays, 4, fits, room != NULL, 0);
}

/* finest_finish(quarter, z, residual, step, out, cols, start, stop, share) -> float: the last smoothing step */
static PyObject *finest_finish(PyObject *self, PyObject *args) {
    PyObject *objects[5];
    Array arrays[5];
    Py_ssize_t cols, start, stop;
    double share, total = 0;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOnnnd", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4], &cols, &start,
                          &stop, &share) ||
        !take_arrays(objects, arrays, "fffff", 5, 1))
        return NULL;
    int fits = fields_fit(arrays, 2, arrays + 2, 3, cols, start, stop);
    float *room = fits ? malloc((CHUNK + cols + 2) * sizeof(float)) : NULL;
    if (room) {
        Py_BEGIN_ALLOW_THREADS
        for (Py_ssize_t at = start; at < stop; at += CHUNK) {
            Py_ssize_t count = stop - at < CHUNK ? stop - at : CHUNK;
            const float *residual = FLOATS(arrays[2]) + at, *z = FLOATS(arrays[1]) + at;
            float *out = FLOATS(arrays[4]) + at;
            face_sum(z, FLOATS(arrays[0]) + at, cols, count + cols + 1, room);
            finish_of(room, residual, FLOATS(arrays[3]) + at, z + cols + 1, cols, count, (float)share, out);
            total += dot(out, residual, count);
        }
        Py_END_ALLOW_THREADS
        free(room);
    }
    return finished_with(arrays, 5, fits, room != NULL, total);
}

/* coarse_step(e, s, se, sw, x, out, load, inverse, cols, start, stop, length): x + length (load - A x) / diagonal */
static PyObject *coarse_step(PyObject *self, PyObject *args) {
    PyObject *objects[8];
    Array arrays[8];
    Py_ssize_t cols, start, stop;
    double length;
    (void)self;
    /* the arrays to write to come last */
    if (!PyArg_ParseTuple(args, "OOOOOOOOnnnd", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4], &objects[7],
                          &objects[5], &objects[6], &cols, &start, &stop, &length) ||
        !take_arrays(objects, arrays, "ffffffff", 8, 1))
        return NULL;
    int fits = fields_fit(arrays, 5, arrays + 5, 2, cols, start, stop) && LENGTH(arrays[7]) >= stop + 2 * (cols + 1);
    if (fits) {
        Py_ssize_t here = start + cols + 1;
        Py_BEGIN_ALLOW_THREADS
        step_of(FLOATS(arrays[0]) + here, FLOATS(arrays[1]) + here, FLOATS(arrays[2]) + here, FLOATS(arrays[3]) + here,
                FLOATS(arrays[5]) + start, FLOATS(arrays[6]) + start, FLOATS(arrays[4]) + here, cols, stop - start,
                (float)length, FLOATS(arrays[7]) + here);
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 8, fits, 1, 0);
}

/* coarse_left(e, s, se, sw, x, load, diagonal, out, cols, start, stop): load - A x */
static PyObject *coarse_left(PyObject *self, PyObject *args) {
    PyObject *objects[8];
    Array arrays[8];
    Py_ssize_t cols, start, stop;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOOOOnnn", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4], &objects[5],
                          &objects[6], &objects[7], &cols, &start, &stop) ||
        !take_arrays(objects, arrays, "ffffffff", 8, 1))
        return NULL;
    int fits = fields_fit(arrays, 5, arrays + 5, 3, cols, start, stop);
    if (fits) {
        Py_ssize_t here = start + cols + 1;
        Py_BEGIN_ALLOW_THREADS
        rest_of(FLOATS(arrays[0]) + here, FLOATS(arrays[1]) + here, FLOATS(arrays[2]) + here, FLOATS(arrays[3]) + here,
                FLOATS(arrays[5]) + start, FLOATS(arrays[6]) + start, FLOATS(arrays[4]) + here, cols, stop - start,
                FLOATS(arrays[7]) + start);
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 8, fits, 1, 0);
}

#endif
