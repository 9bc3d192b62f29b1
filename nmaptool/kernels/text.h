/* Rows of three numbers as text, and back: the vertices and faces of OBJ and 3MF. Words come with a zero after each. */

#ifndef NMAPTOOL_TEXT_H
#define NMAPTOOL_TEXT_H

#include <math.h>

#include "arrays.h"

/* MOST_TEXT: room for the longest number, of 309 digits and MOST_DECIMALS */
enum { ROW_NUMBERS = 3, MOST_DIGITS = 19, MOST_DECIMALS = 400, MOST_TEXT = 720, G_DIGITS = 9, LONGEST_WORD = 64, DIVISORS = 23 };

static const uint64_t TEN_TO[MOST_DIGITS + 1] = {1u, 10u, 100u, 1000u, 10000u, 100000u, 1000000u, 10000000u, 100000000u,
    1000000000u, 10000000000u, 100000000000u, 1000000000000u, 10000000000000u, 100000000000000u, 1000000000000000u,
    10000000000000000u, 100000000000000000u, 1000000000000000000u, 10000000000000000000u};
static const double DIVISOR[DIVISORS] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                         1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/* What stands before, between and after the three numbers of a row. */
typedef struct {
    const char *word[ROW_NUMBERS + 1];
    size_t size[ROW_NUMBERS + 1];
} Words;

static int take_words(const Array *array, Words *words) {
    const char *at = (const char *)array->buf, *end = at + array->len;
    for (int i = 0; i <= ROW_NUMBERS; i++) {
        const char *zero = at < end ? memchr(at, 0, (size_t)(end - at)) : NULL;
        if (!zero || zero - at > LONGEST_WORD) return 0;
        words->word[i] = at;
        words->size[i] = (size_t)(zero - at);
        at = zero + 1;
    }
    return 1;
}

/* |value| times 10^digits, rounded half to even and exactly; 0 if it does not fit. */
static int scaled(double value, int digits, uint64_t *out) {
    uint64_t bits, mantissa, power = TEN_TO[digits];
    memcpy(&bits, &value, sizeof bits);
    int shift = 1075 - (int)(bits >> 52 & 0x7FF);
    mantissa = (bits & 0xFFFFFFFFFFFFFu) | (shift < 1075 ? (uint64_t)1 << 52 : 0);
    if (shift <= 0) return 0;
    uint64_t low = (mantissa & 0xFFFFFFFFu) * (power & 0xFFFFFFFFu), middle = (mantissa >> 32) * (power & 0xFFFFFFFFu);
    uint64_t other = (mantissa & 0xFFFFFFFFu) * (power >> 32), high = (mantissa >> 32) * (power >> 32);
    uint64_t carry = (low >> 32) + (middle & 0xFFFFFFFFu) + (other & 0xFFFFFFFFu);
    low = (low & 0xFFFFFFFFu) | carry << 32;
    high += (middle >> 32) + (other >> 32) + (carry >> 32);
    /* the product has 117 bits at most */
    uint64_t whole = 0, left_high = high, left_low = low, half_high = 0, half_low = 0;
    if (shift < 64) {
        if (high >> (shift - 1)) return 0;
        whole = high << (64 - shift) | low >> shift;
        left_high = 0;
        left_low = low & (((uint64_t)1 << shift) - 1);
        half_low = (uint64_t)1 << (shift - 1);
    } else if (shift < 120) {
        whole = shift == 64 ? high : high >> (shift - 64);
        left_high = shift == 64 ? 0 : high & (((uint64_t)1 << (shift - 64)) - 1);
        if (shift == 64) half_low = (uint64_t)1 << 63;
        else half_high = (uint64_t)1 << (shift - 65);
    } else {
        left_high = left_low = 0;
    }
    int is_half = left_high == half_high && left_low == half_low && (half_high | half_low);
    int is_more = left_high > half_high || (left_high == half_high && left_low > half_low);
    whole += (is_half && (whole & 1)) || is_more;
    *out = whole;
    return 1;
}

/* Writes exactly `count` digits. */
static char *put_padded(char *to, uint64_t value, int count) {
    for (int i = count - 1; i >= 0; i--, value /= 10) to[i] = (char)('0' + value % 10);
    return to + count;
}

static char *put_whole(char *to, uint64_t value) {
    int count = 1;
    while (count <= MOST_DIGITS && value >= TEN_TO[count]) count++;
    return put_padded(to, value, count);
}

/* As Python writes it, for the rare numbers beyond `scaled`. */
static char *put_rare(char *to, double value, char kind, int digits) {
    char *text = PyOS_double_to_string(value, kind, digits, 0, NULL);
    if (!text) return NULL;
    size_t size = strlen(text);
    memcpy(to, text, size);
    PyMem_Free(text);
    return to + size;
}

/* "%.{digits}f" */
static char *put_fixed(char *to, double value, int digits) {
    uint64_t all;
    if (digits > MOST_DIGITS || !scaled(value, digits, &all)) return put_rare(to, value, 'f', digits);
    if (signbit(value)) *to++ = '-';
    to = put_whole(to, all / TEN_TO[digits]);
    if (!digits) return to;
    *to++ = '.';
    return put_padded(to, all % TEN_TO[digits], digits);
}

/* "%.9g" */
static char *put_general(char *to, double value) {
    double size = fabs(value);
    uint64_t all;
    int exponent = 0;
    if (size == 0) {
        if (signbit(value)) *to++ = '-';
        *to++ = '0';
        return to;
    }
    if (!(size >= 1e-11 && size < 999999999.0)) return put_rare(to, value, 'g', G_DIGITS);
    if (size >= 1)
        while (size >= DIVISOR[exponent + 1]) exponent++;
    else
        while (exponent > -11 && size * DIVISOR[-exponent] < 1) exponent--;
    if (!scaled(size, G_DIGITS - 1 - exponent, &all)) return put_rare(to, value, 'g', G_DIGITS);
    /* the guess may be one off just below a power of ten */
    if (all < TEN_TO[G_DIGITS - 1]) {
        exponent--;
        if (exponent < -11 || !scaled(size, G_DIGITS - 1 - exponent, &all)) return put_rare(to, value, 'g', G_DIGITS);
    }
    if (all >= TEN_TO[G_DIGITS]) {
        all /= 10;
        exponent++;
    }
    int left = G_DIGITS;
    while (left > 1 && left > exponent + 1 && all % 10 == 0) all /= 10, left--;
    if (signbit(value)) *to++ = '-';
    if (exponent < -4) {
        to = put_whole(to, all / TEN_TO[left - 1]);
        if (left > 1) {
            *to++ = '.';
            to = put_padded(to, all % TEN_TO[left - 1], left - 1);
        }
        memcpy(to, "e-", 2);
        return put_padded(to + 2, (uint64_t)-exponent, 2);
    }
    int decimals = left - 1 - exponent;
    to = put_whole(to, all / TEN_TO[decimals]);
    if (!decimals) return to;
    *to++ = '.';
    return put_padded(to, all % TEN_TO[decimals], decimals);
}

INLINE char *put_word(char *to, const Words *words, int i) {
    memcpy(to, words->word[i], words->size[i]);
    return to + words->size[i];
}

static char *put_row_end(char *to, const Words *words, char *start, int64_t *state) {
    to = put_word(to, words, ROW_NUMBERS);
    state[0] = to - start;
    state[1]++;
    return to;
}

/* decimal_rows(values, words, digits, out, state): digits < 0 for "%.9g"; state gets the bytes and rows written */
static PyObject *decimal_rows(PyObject *self, PyObject *args) {
    PyObject *objects[4];
    Array arrays[4];
    Words words;
    int digits;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOiOO", &objects[0], &objects[1], &digits, &objects[2], &objects[3])) return NULL;
    if (!take_arrays(objects, arrays, "dBBq", 4, 2)) return NULL;
    int fits = take_words(&arrays[1], &words) && LENGTH(arrays[3]) == 2 && digits <= MOST_DECIMALS, has_memory = 1;
    char *start = (char *)arrays[2].buf, *to = start;
    const char *last = start + arrays[2].len - ROW_NUMBERS * (MOST_TEXT + LONGEST_WORD) - LONGEST_WORD;
    const double *values = DOUBLES(arrays[0]);
    int64_t *state = WHOLE(arrays[3]);
    Py_ssize_t rows = LENGTH(arrays[0]) / ROW_NUMBERS;
    if (fits) state[0] = state[1] = 0;
    for (Py_ssize_t row = 0; fits && row < rows && to <= last; row++) { /* holds the lock: rare numbers are Python's */
        for (int i = 0; i < ROW_NUMBERS && to; i++) {
            to = put_word(to, &words, i);
            to = digits < 0 ? put_general(to, values[ROW_NUMBERS * row + i]) : put_fixed(to, values[ROW_NUMBERS * row + i], digits);
        }
        has_memory = to != NULL;
        if (!has_memory) break;
        to = put_row_end(to, &words, start, state);
    }
    return finished_with(arrays, 4, fits, has_memory, 0);
}

/* whole_rows(values, first, words, out, state): the same for whole numbers, with `first` added */
static PyObject *whole_rows(PyObject *self, PyObject *args) {
    PyObject *objects[4];
    Array arrays[4];
    Words words;
    long long first;
    (void)self;
    if (!PyArg_ParseTuple(args, "OLOOO", &objects[0], &first, &objects[1], &objects[2], &objects[3])) return NULL;
    if (!take_arrays(objects, arrays, "iBBq", 4, 2)) return NULL;
    int fits = take_words(&arrays[1], &words) && LENGTH(arrays[3]) == 2 && first > -((int64_t)1 << 40) && first < (int64_t)1 << 40;
    char *start = (char *)arrays[2].buf, *to = start;
    const char *last = start + arrays[2].len - ROW_NUMBERS * (MOST_TEXT + LONGEST_WORD) - LONGEST_WORD;
    const int32_t *values = INTS(arrays[0]);
    int64_t *state = WHOLE(arrays[3]);
    Py_ssize_t rows = LENGTH(arrays[0]) / ROW_NUMBERS;
    if (fits) state[0] = state[1] = 0;
    for (Py_ssize_t row = 0; fits && row < rows && to <= last; row++) {
        for (int i = 0; i < ROW_NUMBERS; i++) {
            int64_t value = values[ROW_NUMBERS * row + i] + (int64_t)first;
            to = put_word(to, &words, i);
            if (value < 0) *to++ = '-';
            to = put_whole(to, value < 0 ? (uint64_t)-value : (uint64_t)value);
        }
        to = put_row_end(to, &words, start, state);
    }
    return finished_with(arrays, 4, fits, 1, 0);
}

#endif
