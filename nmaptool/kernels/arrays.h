/* Arrays of Python as C pointers, through the buffer protocol: works with the stable ABI and without NumPy's headers. */

#ifndef NMAPTOOL_ARRAYS_H
#define NMAPTOOL_ARRAYS_H

#define Py_LIMITED_API 0x030B0000
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <stdint.h>
#include <string.h>

/* KERNEL: a loop that becomes vector instructions; the loader picks the version for the processor.
   SUMMING: likewise, with its sums added in any order, fixed for a build. Elsewhere, a fused or reordered operation would
   give the two ends of a coupling different values, and the sum of a residual would drift. */
#pragma STDC FP_CONTRACT OFF
/* "arch=haswell" would only be chosen on processors of that name; GCC 12 is the first that knows levels */
#if defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 12 && defined(__x86_64__) && defined(__GLIBC__)
#define PER_PROCESSOR , target_clones("arch=x86-64-v3", "default")
#else
#define PER_PROCESSOR
#endif
#if defined(_MSC_VER)
#define restrict __restrict
#define KERNEL static
#define SUMMING static
#define ANY_ORDER
#elif defined(__clang__)
#define KERNEL static
#define SUMMING static
#define ANY_ORDER _Pragma("clang fp reassociate(on)")
#else
#define KERNEL __attribute__((optimize("O3", "fp-contract=off") PER_PROCESSOR)) static
#define SUMMING                                                                                                                \
    __attribute__((optimize("O3", "associative-math", "no-signed-zeros", "no-trapping-math", "no-math-errno") PER_PROCESSOR)) \
        static
#define ANY_ORDER
#endif
#if defined(__GNUC__) && !defined(__clang__)
#define INLINE __attribute__((always_inline)) static inline
#else
#define INLINE static inline
#endif

typedef Py_buffer Array;

#define FLOATS(array) ((float *)(array).buf)
#define DOUBLES(array) ((double *)(array).buf)
#define WHOLE(array) ((int64_t *)(array).buf)
#define LENGTH(array) ((array).len / (array).itemsize)

static void release(Array *arrays, int count) {
    for (int i = 0; i < count; i++) PyBuffer_Release(&arrays[i]);
}

/* Whether the items of an array are of this kind: 'f' float32, 'd' float64, 'q' int64, '?' bool. */
static int is_of(const Array *array, char kind) {
    const char *format = array->format ? array->format : "B";
    while (*format == '<' || *format == '=' || *format == '@') format++;
    if (kind == 'q') return (*format == 'q' || *format == 'l') && array->itemsize == 8;
    return *format == kind && array->itemsize == (kind == '?' ? 1 : kind == 'f' ? 4 : 8);
}

/* Takes contiguous arrays of these kinds, the last `written` of them to write to; 0 and a Python error if one is not. */
static int take_arrays(PyObject **objects, Array *arrays, const char *kinds, int count, int written) {
    for (int i = 0; i < count; i++) {
        int flags = PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | (i >= count - written ? PyBUF_WRITABLE : 0);
        if (PyObject_GetBuffer(objects[i], &arrays[i], flags) != 0) {
            release(arrays, i);
            return 0;
        }
        if (!is_of(&arrays[i], kinds[i])) {
            PyErr_Format(PyExc_TypeError, "array %d: expected numbers of kind '%c'", i, kinds[i]);
            release(arrays, i + 1);
            return 0;
        }
    }
    return 1;
}

/* The same for the arrays of some tuples, whose lengths are known; those of the last tuple are written to. */
static int take_tuples(PyObject **tuples, const int *lengths, int tuple_count, Array *arrays, const char *kinds) {
    PyObject *objects[32];
    int count = 0;
    for (int k = 0; k < tuple_count; k++) {
        if (PyTuple_Size(tuples[k]) != lengths[k]) {
            PyErr_SetString(PyExc_ValueError, "the number of arrays does not match");
            return 0;
        }
        for (int i = 0; i < lengths[k]; i++) objects[count++] = PyTuple_GetItem(tuples[k], i);
    }
    return take_arrays(objects, arrays, kinds, count, lengths[tuple_count - 1]);
}

KERNEL int all_below(const int64_t *values, Py_ssize_t count, int64_t limit) {
    int inside = 1;
    for (Py_ssize_t i = 0; i < count; i++) inside &= values[i] >= 0 && values[i] < limit;
    return inside;
}

/* Releases the arrays; a float, or NULL and a Python error. */
static PyObject *finished_with(Array *arrays, int count, int fits, int has_memory, double value) {
    release(arrays, count);
    if (!fits) PyErr_SetString(PyExc_ValueError, "the sizes of the arrays do not match");
    else if (!has_memory) PyErr_NoMemory();
    return fits && has_memory ? PyFloat_FromDouble(value) : NULL;
}

#endif
