/* Triangles of files: packed into records of STL, and summed to check what was written. */

#ifndef NMAPTOOL_TRIANGLES_H
#define NMAPTOOL_TRIANGLES_H

#include <float.h>
#include <math.h>

#include "arrays.h"

/* triangles at once: their nine coordinates stay in the first cache; ABREAST of their coordinates are compared at once */
enum { BLOCK = 256, ABREAST = 8, STL_RECORD = 50, COORDINATES = 9 };

/* The unit normals of a block of triangles, in the order of operations of NumPy. */
KERNEL void unit_normals(float (*restrict c)[BLOCK], float (*restrict n)[BLOCK]) {
    for (int j = 0; j < BLOCK; j++) {
        float ux = c[3][j] - c[0][j], uy = c[4][j] - c[1][j], uz = c[5][j] - c[2][j];
        float vx = c[6][j] - c[0][j], vy = c[7][j] - c[1][j], vz = c[8][j] - c[2][j];
        float x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
        float length = sqrtf(x * x + y * y + z * z);
        length = length < FLT_MIN ? FLT_MIN : length;
        n[0][j] = x / length;
        n[1][j] = y / length;
        n[2][j] = z / length;
    }
}

/* Packs up to BLOCK triangles; all corners exist. */
static void pack_records(const double *xyz, const int32_t *faces, Py_ssize_t count, unsigned char *out) {
    float c[COORDINATES][BLOCK] = {{0}}, n[3][BLOCK];
    for (Py_ssize_t j = 0; j < count; j++)
        for (int k = 0; k < 3; k++) {
            const double *corner = xyz + 3 * (Py_ssize_t)faces[3 * j + k];
            for (int axis = 0; axis < 3; axis++) c[3 * k + axis][j] = (float)corner[axis];
        }
    unit_normals(c, n);
    for (Py_ssize_t j = 0; j < count; j++) {
        float record[3 + COORDINATES];
        for (int i = 0; i < 3; i++) record[i] = n[i][j];
        for (int i = 0; i < COORDINATES; i++) record[3 + i] = c[i][j];
        memcpy(out + j * STL_RECORD, record, sizeof record);
        memset(out + j * STL_RECORD + sizeof record, 0, STL_RECORD - sizeof record);
    }
}

static int faces_fit(const int32_t *faces, Py_ssize_t count, Py_ssize_t points) {
    int inside = 1;
    for (Py_ssize_t i = 0; i < count; i++) inside &= faces[i] >= 0 && faces[i] < points;
    return inside;
}

/* stl_records(xyz, faces, out) */
static PyObject *stl_records(PyObject *self, PyObject *args) {
    PyObject *objects[3];
    Array arrays[3];
    (void)self;
    if (!PyArg_ParseTuple(args, "OOO", &objects[0], &objects[1], &objects[2])) return NULL;
    if (!take_arrays(objects, arrays, "diB", 3, 1)) return NULL;
    const int32_t *faces = INTS(arrays[1]);
    Py_ssize_t count = LENGTH(arrays[1]) / 3;
    int fits = LENGTH(arrays[2]) == count * STL_RECORD && faces_fit(faces, 3 * count, LENGTH(arrays[0]) / 3);
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        for (Py_ssize_t at = 0; at < count; at += BLOCK)
            pack_records(DOUBLES(arrays[0]), faces + 3 * at, count - at < BLOCK ? count - at : BLOCK,
                         BYTES(arrays[2]) + at * STL_RECORD);
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 3, fits, 1, 0);
}

/* mark_corners(faces, marked): the vertices that faces use */
static PyObject *mark_corners(PyObject *self, PyObject *args) {
    PyObject *objects[2];
    Array arrays[2];
    (void)self;
    if (!PyArg_ParseTuple(args, "OO", &objects[0], &objects[1])) return NULL;
    if (!take_arrays(objects, arrays, "i?", 2, 1)) return NULL;
    const int32_t *faces = INTS(arrays[0]);
    Py_ssize_t count = LENGTH(arrays[0]);
    unsigned char *marked = BYTES(arrays[1]);
    int fits = faces_fit(faces, count, LENGTH(arrays[1]));
    for (Py_ssize_t i = 0; fits && i < count; i++) marked[faces[i]] = 1;
    return finished_with(arrays, 2, fits, 1, 0);
}

/* What was found in some triangles; the lanes are put together at the end. */
typedef struct {
    double low[3][ABREAST], high[3][ABREAST], volume;
    int64_t infinite[ABREAST], collapsed;
    uint64_t edge_sum;
} Found;

/* Least and greatest of a number of values, a multiple of ABREAST, and how many are not finite. */
KERNEL void widen(const double *restrict values, int count, double *restrict low, double *restrict high,
                  int64_t *restrict infinite) {
    for (int at = 0; at < count; at += ABREAST)
        for (int j = 0; j < ABREAST; j++) {
            double value = values[at + j];
            low[j] = value < low[j] ? value : low[j];
            high[j] = value > high[j] ? value : high[j];
            infinite[j] += !(fabs(value) <= DBL_MAX);
        }
}

/* Six times the sum of the signed volumes between triangles and a point. */
SUMMING double volume_of(double (*restrict c)[BLOCK], int count, const double *restrict middle) {
    ANY_ORDER
    double sum = 0, x = middle[0], y = middle[1], z = middle[2];
    for (int j = 0; j < count; j++) {
        double ax = c[0][j] - x, ay = c[1][j] - y, az = c[2][j] - z;
        double bx = c[3][j] - x, by = c[4][j] - y, bz = c[5][j] - z;
        double cx = c[6][j] - x, cy = c[7][j] - y, cz = c[8][j] - z;
        sum += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
    }
    return sum;
}

/* How many triangles have two corners that are equal in single precision. */
KERNEL int64_t collapsed_of(double (*restrict c)[BLOCK], int count) {
    int64_t sum = 0;
    for (int j = 0; j < count; j++) {
        int same[3] = {1, 1, 1};
        for (int axis = 0; axis < 3; axis++) {
            float p = (float)c[axis][j], q = (float)c[3 + axis][j], r = (float)c[6 + axis][j];
            same[0] &= p == q;
            same[1] &= q == r;
            same[2] &= r == p;
        }
        sum += same[0] | same[1] | same[2];
    }
    return sum;
}

static const uint64_t MIX[3] = {0x9E3779B97F4A7C15u, 0xC2B2AE3D27D4EB4Fu, 0x165667B19E3779F9u}, MIX_AGAIN = 0xD6E8FEB86659FD93u;

/* Two numbers for each corner, equal where corners are equal in single precision. */
KERNEL void hash_corners(double (*restrict c)[BLOCK], int count, uint64_t *restrict first, uint64_t *restrict second) {
    for (int j = 0; j < count; j++) {
        uint64_t mixed = MIX_AGAIN;
        for (int axis = 0; axis < 3; axis++) {
            float value = (float)c[axis][j];
            uint32_t bits;
            memcpy(&bits, &value, sizeof bits);
            mixed += (bits == 0x80000000u ? 0 : bits) * MIX[axis]; /* -0 equals 0 */
        }
        mixed ^= mixed >> 29;
        mixed *= MIX[1];
        mixed ^= mixed >> 32;
        mixed *= MIX[0];
        first[j] = mixed;
        mixed = (mixed ^ (mixed >> 31)) * MIX_AGAIN;
        second[j] = mixed ^ (mixed >> 30);
    }
}

/* The sum over directed edges; `edges`, if any, gets three numbers for each triangle, one for each edge without direction. */
static uint64_t edge_sum_of(double (*restrict c)[BLOCK], int count, int64_t *edges) {
    uint64_t first[3][BLOCK], second[3][BLOCK], sum = 0;
    for (int k = 0; k < 3; k++) hash_corners(c + 3 * k, count, first[k], second[k]);
    for (int k = 0; k < 3; k++) {
        const uint64_t *f = first[k], *g = second[k], *next_f = first[(k + 1) % 3], *next_g = second[(k + 1) % 3];
        for (int j = 0; j < count; j++) sum += f[j] * next_g[j] - next_f[j] * g[j];
        if (edges)
            for (int j = 0; j < count; j++) edges[3 * j + k] = (int64_t)(f[j] * next_f[j]);
    }
    return sum;
}

/* Adds up to BLOCK triangles; the last one is repeated up to whole lanes, which does not change the bounds. */
static void add_block(double (*c)[BLOCK], int count, const double *middle, int is_closed, int64_t *edges, Found *found) {
    int padded = (count + ABREAST - 1) / ABREAST * ABREAST;
    for (int i = 0; i < COORDINATES; i++) {
        for (int j = count; j < padded; j++) c[i][j] = c[i][count - 1];
        widen(c[i], padded, found->low[i % 3], found->high[i % 3], found->infinite);
    }
    found->collapsed += collapsed_of(c, count);
    if (is_closed) {
        found->volume += volume_of(c, count, middle) / 6;
        found->edge_sum += edge_sum_of(c, count, edges);
    }
}

/* Adds what was found to sums (least and greatest x, y, z, volume) and counts (collapsed triangles, sum over edges). */
static void put_together(const Found *found, double *sums, int64_t *counts) {
    int64_t infinite = 0;
    for (int j = 0; j < ABREAST; j++) infinite += found->infinite[j];
    for (int axis = 0; axis < 3; axis++)
        for (int j = 0; j < ABREAST; j++) {
            double low = found->low[axis][j], high = found->high[axis][j];
            sums[axis] = infinite ? NAN : low < sums[axis] ? low : sums[axis];
            sums[3 + axis] = infinite ? NAN : high > sums[3 + axis] ? high : sums[3 + axis];
        }
    sums[6] += found->volume;
    counts[0] += found->collapsed;
    counts[1] = (int64_t)((uint64_t)counts[1] + found->edge_sum);
}

static void begin_with(Found *found) {
    memset(found, 0, sizeof *found);
    for (int axis = 0; axis < 3; axis++)
        for (int j = 0; j < ABREAST; j++) found->low[axis][j] = INFINITY, found->high[axis][j] = -INFINITY;
}

/* The corners of triangles in a file: rows of `points`, float32 if `size` is 4, or without points, in the records themselves. */
typedef struct {
    const unsigned char *points, *records;
    Py_ssize_t size, point_count, stride;
} Corners;

/* Reads one triangle; 0 if a corner does not exist. */
INLINE int read_triangle(const Corners *from, Py_ssize_t number, double (*restrict c)[BLOCK], int j) {
    const unsigned char *record = from->records + number * from->stride;
    float place[COORDINATES];
    int32_t corner[3];
    if (!from->points) {
        memcpy(place, record, sizeof place);
        for (int i = 0; i < COORDINATES; i++) c[i][j] = place[i];
        return 1;
    }
    memcpy(corner, record, sizeof corner);
    for (int k = 0; k < 3; k++) {
        if (corner[k] < 0 || corner[k] >= from->point_count) return 0;
        const unsigned char *at = from->points + 3 * from->size * corner[k];
        if (from->size == sizeof(double)) {
            for (int axis = 0; axis < 3; axis++) c[3 * k + axis][j] = ((const double *)at)[axis];
        } else {
            for (int axis = 0; axis < 3; axis++) c[3 * k + axis][j] = ((const float *)at)[axis];
        }
    }
    return 1;
}

/* Adds all triangles; the number of those whose corners do not all exist, which are left out. */
static Py_ssize_t add_triangles(const Corners *from, Py_ssize_t count, const double *middle, int is_closed, int64_t *edges,
                                Found *found) {
    double c[COORDINATES][BLOCK] = {{0}};
    Py_ssize_t lost = 0;
    for (Py_ssize_t at = 0; at < count; at += BLOCK) {
        Py_ssize_t all = count - at < BLOCK ? count - at : BLOCK;
        int kept = 0;
        for (Py_ssize_t j = 0; j < all; j++) kept += read_triangle(from, at + j, c, kept);
        if (kept) add_block(c, kept, middle, is_closed, edges ? edges + 3 * (at - lost) : NULL, found);
        lost += all - kept;
    }
    return lost;
}

/* triangle_sums(points, records, stride, offset, middle, is_closed, edges, sums, counts): how many lack a corner */
static PyObject *triangle_sums(PyObject *self, PyObject *args) {
    PyObject *objects[6];
    Py_ssize_t stride, offset, lost = 0;
    int is_closed;
    Array arrays[6];
    Found found;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOnnOpOOO", &objects[0], &objects[1], &stride, &offset, &objects[2], &is_closed, &objects[3],
                          &objects[4], &objects[5]))
        return NULL;
    if (!take_arrays(objects, arrays, "rBdqdq", 6, 3)) return NULL;
    Py_ssize_t points = LENGTH(arrays[0]) / 3, width = points ? 3 * 4 : COORDINATES * 4;
    int fits = offset >= 0 && stride >= offset + width && LENGTH(arrays[1]) % stride == 0 && LENGTH(arrays[2]) == 3 &&
               LENGTH(arrays[4]) == 7 && LENGTH(arrays[5]) == 2;
    Py_ssize_t count = fits ? LENGTH(arrays[1]) / stride : 0, edges = LENGTH(arrays[3]);
    fits = fits && (edges == 0 || edges == 3 * count);
    if (fits) {
        Corners from = {points ? BYTES(arrays[0]) : NULL, BYTES(arrays[1]) + offset, arrays[0].itemsize, points, stride};
        Py_BEGIN_ALLOW_THREADS
        begin_with(&found);
        lost = add_triangles(&from, count, DOUBLES(arrays[2]), is_closed, edges ? WHOLE(arrays[3]) : NULL, &found);
        put_together(&found, DOUBLES(arrays[4]), WHOLE(arrays[5]));
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 6, fits, 1, (double)lost);
}

#endif
