/* Rows of three numbers read from text, as text.h writes them. */

#ifndef NMAPTOOL_TEXT_ROWS_H
#define NMAPTOOL_TEXT_ROWS_H

#include "text.h"

/* Reads digits, no more than fit; NULL if there are none. */
INLINE const char *read_digits(const char *at, const char *end, uint64_t *value, int *count) {
    int found = 0;
    while (at < end && *at >= '0' && *at <= '9') {
        if (*value > (UINT64_MAX - 9) / 10) return NULL;
        *value = *value * 10 + (uint64_t)(*at++ - '0');
        found++;
    }
    *count = found;
    return found ? at : NULL;
}

/* Reads -12.5e-3 and the like, to a few units in the last place; NULL if it is something else or has too many digits. */
static const char *read_decimal(const char *at, const char *end, double *out) {
    int is_negative = at < end && *at == '-', count = 0, decimals = 0;
    uint64_t digits = 0, power = 0;
    at = read_digits(at + is_negative, end, &digits, &count);
    if (at && at < end && *at == '.') at = read_digits(at + 1, end, &digits, &decimals);
    if (!at) return NULL;
    if (at < end && *at == 'e') {
        int goes_down = ++at < end && *at == '-';
        if (at < end && (*at == '-' || *at == '+')) at++;
        at = read_digits(at, end, &power, &count);
        if (!at || power > DIVISORS) return NULL;
        decimals += goes_down ? (int)power : -(int)power;
    }
    if (decimals > 2 * (DIVISORS - 1) || decimals <= -DIVISORS) return NULL;
    double value = (double)digits;
    if (decimals < 0) value *= DIVISOR[-decimals];
    else if (decimals < DIVISORS) value /= DIVISOR[decimals];
    else value = value / DIVISOR[DIVISORS - 1] / DIVISOR[decimals - DIVISORS + 1];
    *out = is_negative ? -value : value;
    return at;
}

/* Reads a whole number and subtracts `first`; NULL if the result is not an int32. */
static const char *read_whole(const char *at, const char *end, int64_t first, int32_t *out) {
    int is_negative = at < end && *at == '-', count;
    uint64_t digits = 0;
    at = read_digits(at + is_negative, end, &digits, &count);
    if (!at || digits > (uint64_t)1 << 41) return NULL;
    int64_t value = (is_negative ? -(int64_t)digits : (int64_t)digits) - first;
    if (value < INT32_MIN || value > INT32_MAX) return NULL;
    *out = (int32_t)value;
    return at;
}

INLINE const char *read_word(const char *at, const char *end, const Words *words, int i) {
    size_t size = words->size[i];
    return (size_t)(end - at) >= size && memcmp(at, words->word[i], size) == 0 ? at + size : NULL;
}

/* Reads a row; NULL if it has another form. */
static const char *read_row(const char *at, const char *end, const Words *words, int64_t first, double *decimals,
                            int32_t *wholes) {
    for (int i = 0; i < ROW_NUMBERS; i++) {
        at = read_word(at, end, words, i);
        if (at) at = decimals ? read_decimal(at, end, decimals + i) : read_whole(at, end, first, wholes + i);
        if (!at) return NULL;
    }
    return read_word(at, end, words, ROW_NUMBERS);
}

/* Reads rows from state[0] on until one has another form; state gets the place after them and their number. */
static void read_all(const Array *text, const Words *words, int64_t first, double *decimals, int32_t *wholes, Py_ssize_t most,
                     int64_t *state) {
    const char *begin = (const char *)text->buf, *end = begin + text->len, *at = begin + state[0];
    Py_ssize_t row = 0;
    while (row < most) {
        const char *next = read_row(at, end, words, first, decimals ? decimals + ROW_NUMBERS * row : NULL,
                                    wholes ? wholes + ROW_NUMBERS * row : NULL);
        if (!next) break;
        at = next;
        row++;
    }
    state[0] = at - begin;
    state[1] = row;
}

static PyObject *read_rows(PyObject *args, int is_whole) {
    PyObject *objects[4];
    Array arrays[4];
    Words words;
    long long first;
    if (!PyArg_ParseTuple(args, "OOLOO", &objects[0], &objects[1], &first, &objects[2], &objects[3])) return NULL;
    if (!take_arrays(objects, arrays, is_whole ? "BBiq" : "BBdq", 4, 2)) return NULL;
    int64_t *state = WHOLE(arrays[3]);
    int fits = take_words(&arrays[1], &words) && LENGTH(arrays[3]) == 2 && state[0] >= 0 && state[0] <= arrays[0].len &&
               first > -((int64_t)1 << 40) && first < (int64_t)1 << 40;
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        read_all(&arrays[0], &words, first, is_whole ? NULL : DOUBLES(arrays[2]), is_whole ? INTS(arrays[2]) : NULL,
                 LENGTH(arrays[2]) / ROW_NUMBERS, state);
        Py_END_ALLOW_THREADS
    }
    return finished_with(arrays, 4, fits, 1, 0);
}

/* read_decimal_rows(text, words, 0, out, state) */
static PyObject *read_decimal_rows(PyObject *self, PyObject *args) {
    (void)self;
    return read_rows(args, 0);
}

/* read_whole_rows(text, words, first, out, state) */
static PyObject *read_whole_rows(PyObject *self, PyObject *args) {
    (void)self;
    return read_rows(args, 1);
}

#endif
