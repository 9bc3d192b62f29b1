/* Sums over the cells around each pixel: rolling guidance in the picture. */

#ifndef NMAPTOOL_PIXELS_H
#define NMAPTOOL_PIXELS_H

#include "arrays.h"
#include "exponential.h"

/* pixels at once: their guide and sums stay in the first cache while the cells pass */
enum { STRIP = 512 };

/* Adds one cell of `count` pixels to their sums; planes of guide and source are `plane` floats apart, those of sums STRIP. */
SUMMING void add_cell(const float *restrict here, const float *restrict there, const float *restrict source,
                      Py_ssize_t plane, Py_ssize_t count, float log_weight, float *restrict sums) {
    ANY_ORDER
    const float *restrict other = here + plane, *restrict last = here + 2 * plane;
    for (Py_ssize_t j = 0; j < count; j++) {
        float a = there[j] - here[j], b = there[plane + j] - other[j], c = there[2 * plane + j] - last[j];
        float weight = exp_below(log_weight - (a * a + b * b + c * c));
        sums[j] += source[j] * weight;
        sums[STRIP + j] += source[plane + j] * weight;
        sums[2 * STRIP + j] += source[2 * plane + j] * weight;
    }
}

/* Whether the pixels of all cells, and their levels, exist. */
static int cells_fit(const int64_t *levels, const int64_t *shifts, Py_ssize_t cells, Py_ssize_t most_levels, Py_ssize_t start,
                     Py_ssize_t stop, Py_ssize_t plane) {
    int fits = all_below(levels, cells, most_levels);
    for (Py_ssize_t c = 0; c < cells; c++) fits &= shifts[c] >= -start && shifts[c] <= plane - stop;
    return fits;
}

/* pixel_sums(guide, sources, levels, shifts, log_weights, start, stop, out) for the pixels from start to stop */
static PyObject *pixel_sums(PyObject *self, PyObject *args) {
    PyObject *objects[6];
    Py_ssize_t start, stop;
    Array arrays[6];
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOnnO", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4], &start, &stop,
                          &objects[5]))
        return NULL;
    if (!take_arrays(objects, arrays, "ffqqff", 6, 1)) return NULL;
    const float *guide = FLOATS(arrays[0]), *sources = FLOATS(arrays[1]), *log_weights = FLOATS(arrays[4]);
    const int64_t *levels = WHOLE(arrays[2]), *shifts = WHOLE(arrays[3]);
    float *out = FLOATS(arrays[5]);
    Py_ssize_t plane = LENGTH(arrays[0]) / 3, cells = LENGTH(arrays[2]), all = stop - start;
    int fits = plane > 0 && 0 <= start && start <= stop && stop <= plane && LENGTH(arrays[3]) == cells &&
               LENGTH(arrays[4]) == cells && LENGTH(arrays[5]) == 3 * all &&
               cells_fit(levels, shifts, cells, LENGTH(arrays[1]) / (3 * plane), start, stop, plane);
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        for (Py_ssize_t at = start; at < stop; at += STRIP) {
            Py_ssize_t count = stop - at < STRIP ? stop - at : STRIP;
            float sums[3 * STRIP] = {0};
            for (Py_ssize_t c = 0; c < cells; c++)
                add_cell(guide + at, guide + at + shifts[c], sources + levels[c] * 3 * plane + at + shifts[c], plane, count,
                         log_weights[c], sums);
            for (int k = 0; k < 3; k++)
                memcpy(out + k * all + at - start, sums + k * STRIP, (size_t)count * sizeof(float));
        }
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 6, fits, 1, 0);
}

#endif
