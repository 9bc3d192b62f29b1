/* The coarse levels of the multigrid solver: smoothing and residuals, on flat float32 fields.

Fields with margins hold `edge` = cols + 1 more numbers before the first and after the last vertex. */

#ifndef NMAPTOOL_GRID_H
#define NMAPTOOL_GRID_H

#include "arrays.h"
#include <stdlib.h>

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
