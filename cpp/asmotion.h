/*
 * asmotion: the program protocol in C (docs/program-protocol.md): CBOR, the connection to the engine, and shared memory.
 *
 * C99 and C++, Linux, header-only, without dependencies. Strict C99 compilers need -D_GNU_SOURCE or -std=gnu99.
 * `asmotion.hpp` builds components in C++ on this header.
 */
#ifndef ASMOTION_H
#define ASMOTION_H

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/un.h>
#include <unistd.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Longest frame in bytes. */
#define ASMOTION_FRAME_LIMIT ((size_t)64 << 20)
/** Levels of lists and maps that may be nested. */
#define ASMOTION_DEPTH 64
/** Tag of a reference to shared memory: `[offset, length]` in place of a byte string. */
#define ASMOTION_SHARED_TAG 6386541
/** Length in bytes from which a byte string is passed in shared memory. */
#define ASMOTION_SHARED_FROM 4096

/* ---- Reading ---------------------------------------------------------------------------------------------------- */

/** Bytes that have been checked to be one CBOR item, and the shared memory that they refer to. */
typedef struct asmotion_document {
    const uint8_t *begin;
    const uint8_t *end;
    /** Memory of the engine's large byte strings; NULL without. */
    const uint8_t *shared;
    size_t shared_size;
} asmotion_document;

/** An item of a document. One that is absent has `at == NULL`; it is NULL, and has no entries. */
typedef struct asmotion_value {
    const uint8_t *at;
    const asmotion_document *in;
} asmotion_value;

typedef enum asmotion_kind {
    ASMOTION_NULL,
    ASMOTION_BOOL,
    ASMOTION_INT,
    ASMOTION_FLOAT,
    ASMOTION_TEXT,
    ASMOTION_BYTES,
    /** A typed array of RFC 8746. */
    ASMOTION_NUMBERS,
    ASMOTION_LIST,
    ASMOTION_MAP
} asmotion_kind;

/** Element types of typed arrays; the values are the tags of their little-endian forms. */
typedef enum asmotion_element {
    ASMOTION_U8 = 64,
    ASMOTION_U16 = 69,
    ASMOTION_U32 = 70,
    ASMOTION_U64 = 71,
    ASMOTION_I8 = 72,
    ASMOTION_I16 = 77,
    ASMOTION_I32 = 78,
    ASMOTION_I64 = 79,
    ASMOTION_F32 = 85,
    ASMOTION_F64 = 86
} asmotion_element;

/** Bytes in the memory of a document. Not terminated by zero. */
typedef struct asmotion_bytes {
    const uint8_t *data;
    size_t size;
} asmotion_bytes;

/** Packed numbers, little-endian and without alignment. */
typedef struct asmotion_numbers {
    asmotion_element element;
    const uint8_t *data;
    size_t count;
} asmotion_numbers;

/** Walks through the elements of a list, or the keys and values of a map. */
typedef struct asmotion_iterator {
    asmotion_value next;
    /** Items left; SIZE_MAX if the end is marked in the data. */
    size_t left;
    bool is_map;
} asmotion_iterator;

typedef struct asmotion__head {
    int major;
    /** The lower five bits of the first byte. */
    int more;
    uint64_t argument;
    /** First byte after the head. */
    const uint8_t *content;
} asmotion__head;

static inline bool asmotion__read_head(const uint8_t *at, const uint8_t *end, asmotion__head *head) {
    if (at == NULL || at >= end) return false;
    head->major = *at >> 5;
    head->more = *at & 31;
    head->content = at + 1;
    head->argument = (uint64_t)head->more;
    if (head->more >= 24 && head->more <= 27) {
        size_t size = (size_t)1 << (head->more - 24);
        if ((size_t)(end - head->content) < size) return false;
        head->argument = 0;
        for (size_t index = 0; index < size; index++) head->argument = head->argument << 8 | head->content[index];
        head->content += size;
    }
    return head->more < 28 || head->more == 31;
}

/** Size of an element of a typed array in bytes; 0 for other tags. */
static inline size_t asmotion_element_size(uint64_t tag) {
    switch (tag) {
    case ASMOTION_U8: case ASMOTION_I8: return 1;
    case ASMOTION_U16: case ASMOTION_I16: return 2;
    case ASMOTION_U32: case ASMOTION_I32: case ASMOTION_F32: return 4;
    case ASMOTION_U64: case ASMOTION_I64: case ASMOTION_F64: return 8;
    default: return 0;
    }
}

/**
 * Returns whether the content of a tag has another meaning without it: large integers, fractions, arrays of several dimensions,
 * and typed arrays of other byte orders and widths.
 */
static inline bool asmotion__is_refused(uint64_t tag) {
    bool is_typed_array = tag >= 64 && tag <= 87;
    bool is_number = (tag >= 2 && tag <= 5) || tag == 30;
    return is_number || tag == 40 || tag == 1040 || (is_typed_array && asmotion_element_size(tag) == 0);
}

static inline bool asmotion__is_utf8(const uint8_t *at, size_t size) {
    const uint8_t *end = at + size;
    while (at < end) {
        uint8_t first = *at++;
        int more = first < 0x80 ? 0 : first >= 0xC2 && first < 0xE0 ? 1 : first >= 0xE0 && first < 0xF0 ? 2
                 : first >= 0xF0 && first < 0xF5 ? 3 : -1;
        if (more < 0 || end - at < more) return false;
        if ((first == 0xE0 && *at < 0xA0) || (first == 0xED && *at > 0x9F)) return false;
        if ((first == 0xF0 && *at < 0x90) || (first == 0xF4 && *at > 0x8F)) return false;
        for (; more > 0; more--, at++) {
            if ((*at & 0xC0) != 0x80) return false;
        }
    }
    return true;
}

/** Reads the content of a reference to shared memory. */
static inline bool asmotion__shared(const asmotion_document *in, const uint8_t *at, asmotion_bytes *bytes,
                                    const uint8_t **behind) {
    asmotion__head list, offset, length;
    if (!asmotion__read_head(at, in->end, &list) || list.major != 4 || list.argument != 2 || list.more == 31) return false;
    if (!asmotion__read_head(list.content, in->end, &offset) || offset.major != 0 || offset.more == 31) return false;
    if (!asmotion__read_head(offset.content, in->end, &length) || length.major != 0 || length.more == 31) return false;
    if (in->shared == NULL || offset.argument > in->shared_size) return false;
    if (length.argument > in->shared_size - offset.argument) return false;
    bytes->data = in->shared + offset.argument;
    bytes->size = (size_t)length.argument;
    *behind = length.content;
    return true;
}

/** Reads a byte string that stands there or in shared memory. */
static inline bool asmotion__string(const asmotion_document *in, const uint8_t *at, asmotion_bytes *bytes,
                                    const uint8_t **behind) {
    asmotion__head head;
    if (!asmotion__read_head(at, in->end, &head)) return false;
    if (head.major == 6 && head.argument == ASMOTION_SHARED_TAG) return asmotion__shared(in, head.content, bytes, behind);
    if (head.major != 2 || head.more == 31 || head.argument > (uint64_t)(in->end - head.content)) return false;
    bytes->data = head.content;
    bytes->size = (size_t)head.argument;
    *behind = head.content + bytes->size;
    return true;
}

/** Returns the position behind an item; NULL if it is none, or one of a kind that no message has. */
static inline const uint8_t *asmotion__behind(const asmotion_document *in, const uint8_t *at, int depth) {
    asmotion__head head;
    asmotion_bytes bytes;
    const uint8_t *behind = NULL;
    if (depth == 0 || !asmotion__read_head(at, in->end, &head)) return NULL;
    bool is_open = head.more == 31;
    switch (head.major) {
    case 0:
    case 1: return is_open || head.argument > INT64_MAX ? NULL : head.content;
    case 2: return asmotion__string(in, at, &bytes, &behind) ? behind : NULL;
    case 3:
        if (is_open || head.argument > (uint64_t)(in->end - head.content)) return NULL;
        if (!asmotion__is_utf8(head.content, (size_t)head.argument)) return NULL;
        return head.content + head.argument;
    case 4:
    case 5: {
        bool is_map = head.major == 5;
        const uint8_t *part = head.content;
        if (!is_open && head.argument > (uint64_t)(in->end - part)) return NULL;
        for (uint64_t index = 0; is_open || index < head.argument; index++) {
            if (is_open && part < in->end && *part == 0xFF) return part + 1;
            if (is_map) {
                if (part >= in->end || *part >> 5 != 3) return NULL;
                part = asmotion__behind(in, part, 1);
                if (part == NULL) return NULL;
            }
            part = asmotion__behind(in, part, depth - 1);
            if (part == NULL) return NULL;
        }
        return part;
    }
    case 6: {
        size_t size = asmotion_element_size(head.argument);
        if (is_open || asmotion__is_refused(head.argument)) return NULL;
        if (head.argument == ASMOTION_SHARED_TAG) {
            return asmotion__shared(in, head.content, &bytes, &behind) ? behind : NULL;
        }
        if (size > 0) {
            if (!asmotion__string(in, head.content, &bytes, &behind) || bytes.size % size != 0) return NULL;
            for (size_t last = 7; head.argument == ASMOTION_U64 && last < bytes.size; last += 8) {
                if (bytes.data[last] > 0x7F) return NULL;
            }
            return behind;
        }
        return asmotion__behind(in, head.content, depth - 1);
    }
    default:
        if (head.more >= 20 && head.more <= 23) return head.content;
        return head.more >= 25 && head.more <= 27 ? head.content : NULL;
    }
}

/**
 * Checks that the bytes of a document are exactly one item. All other functions expect a document that has been checked.
 * Integers of more than 64 bits with sign, texts and byte strings in pieces, and typed arrays of other byte orders and widths
 * are refused: the engine does not send them.
 */
static inline bool asmotion_check(const asmotion_document *document) {
    return asmotion__behind(document, document->begin, ASMOTION_DEPTH) == document->end;
}

/** The item of a document. */
static inline asmotion_value asmotion_root(const asmotion_document *document) {
    asmotion_value value = {document->begin, document};
    return value;
}

/** Skips tags without a meaning for messages. */
static inline bool asmotion__item(asmotion_value value, asmotion__head *head, const uint8_t **at) {
    const uint8_t *here = value.at;
    while (here != NULL && asmotion__read_head(here, value.in->end, head)) {
        bool has_meaning = asmotion_element_size(head->argument) > 0 || head->argument == ASMOTION_SHARED_TAG;
        if (head->major != 6 || has_meaning) {
            *at = here;
            return true;
        }
        here = head->content;
    }
    return false;
}

static inline asmotion_kind asmotion_kind_of(asmotion_value value) {
    asmotion__head head;
    const uint8_t *at = NULL;
    if (!asmotion__item(value, &head, &at)) return ASMOTION_NULL;
    switch (head.major) {
    case 0:
    case 1: return ASMOTION_INT;
    case 2: return ASMOTION_BYTES;
    case 3: return ASMOTION_TEXT;
    case 4: return ASMOTION_LIST;
    case 5: return ASMOTION_MAP;
    case 6: return head.argument == ASMOTION_SHARED_TAG ? ASMOTION_BYTES : ASMOTION_NUMBERS;
    default:
        if (head.more == 20 || head.more == 21) return ASMOTION_BOOL;
        return head.more < 24 ? ASMOTION_NULL : ASMOTION_FLOAT;
    }
}

static inline bool asmotion_is_absent(asmotion_value value) { return value.at == NULL; }

/** Reads a Boolean. Like all functions of this kind, returns false and changes nothing if the value is of another kind. */
static inline bool asmotion_read_bool(asmotion_value value, bool *to) {
    asmotion__head head;
    const uint8_t *at = NULL;
    if (asmotion_kind_of(value) != ASMOTION_BOOL || !asmotion__item(value, &head, &at)) return false;
    *to = head.more == 21;
    return true;
}

static inline bool asmotion_read_int(asmotion_value value, int64_t *to) {
    asmotion__head head;
    const uint8_t *at = NULL;
    if (asmotion_kind_of(value) != ASMOTION_INT || !asmotion__item(value, &head, &at)) return false;
    *to = head.major == 0 ? (int64_t)head.argument : -1 - (int64_t)head.argument;
    return true;
}

static inline double asmotion__half(uint64_t bits) {
    int exponent = (int)(bits >> 10 & 31);
    double value = (double)(bits & 1023);
    double scale = 1.0 / 16777216.0;
    if (exponent == 31) {
        uint64_t wide = (bits & 1023) != 0 ? UINT64_C(0x7FF8000000000000) : UINT64_C(0x7FF0000000000000);
        memcpy(&value, &wide, sizeof value);
    } else {
        if (exponent > 0) value += 1024;
        for (int power = 1; power < exponent; power++) scale *= 2;
        value *= scale;
    }
    return bits >> 15 != 0 ? -value : value;
}

/** Reads a float, or an integer as a float. */
static inline bool asmotion_read_float(asmotion_value value, double *to) {
    asmotion__head head;
    const uint8_t *at = NULL;
    int64_t integer = 0;
    if (asmotion_read_int(value, &integer)) {
        *to = (double)integer;
        return true;
    }
    if (asmotion_kind_of(value) != ASMOTION_FLOAT || !asmotion__item(value, &head, &at)) return false;
    if (head.more == 25) {
        *to = asmotion__half(head.argument);
    } else if (head.more == 26) {
        uint32_t bits = (uint32_t)head.argument;
        float single = 0;
        memcpy(&single, &bits, sizeof single);
        *to = (double)single;
    } else {
        memcpy(to, &head.argument, sizeof *to);
    }
    return true;
}

static inline bool asmotion_read_text(asmotion_value value, asmotion_bytes *to) {
    asmotion__head head;
    const uint8_t *at = NULL;
    if (asmotion_kind_of(value) != ASMOTION_TEXT || !asmotion__item(value, &head, &at)) return false;
    to->data = head.content;
    to->size = (size_t)head.argument;
    return true;
}

/** Returns whether a value is this text. */
static inline bool asmotion_is_text(asmotion_value value, const char *text) {
    asmotion_bytes found;
    return asmotion_read_text(value, &found) && found.size == strlen(text) && memcmp(found.data, text, found.size) == 0;
}

/** Reads a byte string. One in shared memory is valid until the reply is sent. */
static inline bool asmotion_read_bytes(asmotion_value value, asmotion_bytes *to) {
    asmotion__head head;
    const uint8_t *at = NULL, *behind = NULL;
    if (asmotion_kind_of(value) != ASMOTION_BYTES || !asmotion__item(value, &head, &at)) return false;
    return asmotion__string(value.in, at, to, &behind);
}

/** Reads a typed array, or a byte string as one of `u8`. */
static inline bool asmotion_read_numbers(asmotion_value value, asmotion_numbers *to) {
    asmotion__head head;
    asmotion_bytes bytes;
    const uint8_t *at = NULL, *behind = NULL;
    if (asmotion_read_bytes(value, &bytes)) {
        to->element = ASMOTION_U8;
        to->data = bytes.data;
        to->count = bytes.size;
        return true;
    }
    if (asmotion_kind_of(value) != ASMOTION_NUMBERS || !asmotion__item(value, &head, &at)) return false;
    if (!asmotion__string(value.in, head.content, &bytes, &behind)) return false;
    to->element = (asmotion_element)head.argument;
    to->data = bytes.data;
    to->count = bytes.size / asmotion_element_size(head.argument);
    return true;
}

/** One of some numbers: an integer or, with the return value true, a float. `index` must be less than the count. */
static inline bool asmotion_number_at(asmotion_numbers numbers, size_t index, int64_t *integer, double *real) {
    size_t size = asmotion_element_size(numbers.element);
    const uint8_t *at = numbers.data + index * size;
    uint64_t bits = 0;
    float single = 0;
    uint32_t word = 0;
    for (size_t byte = 0; byte < size; byte++) bits |= (uint64_t)at[byte] << (8 * byte);
    switch (numbers.element) {
    case ASMOTION_F64: memcpy(real, &bits, sizeof *real); return true;
    case ASMOTION_F32:
        word = (uint32_t)bits;
        memcpy(&single, &word, sizeof single);
        *real = (double)single;
        return true;
    case ASMOTION_I8: *integer = (int8_t)bits; return false;
    case ASMOTION_I16: *integer = (int16_t)bits; return false;
    case ASMOTION_I32: *integer = (int32_t)bits; return false;
    case ASMOTION_I64: case ASMOTION_U64: *integer = (int64_t)bits; return false;
    case ASMOTION_U8: case ASMOTION_U16: case ASMOTION_U32: default: *integer = (int64_t)bits; return false;
    }
}

/** Begins a walk through a list or a map; one through any other value has no steps. */
static inline asmotion_iterator asmotion_iterate(asmotion_value value) {
    asmotion__head head;
    const uint8_t *at = NULL;
    asmotion_iterator iterator = {{NULL, value.in}, 0, false};
    if (asmotion__item(value, &head, &at) && (head.major == 4 || head.major == 5)) {
        iterator.next.at = head.content;
        iterator.left = head.more == 31 ? SIZE_MAX : (size_t)head.argument;
        iterator.is_map = head.major == 5;
    }
    return iterator;
}

/** Goes to the next element, or to the next key and value. `key` may be NULL. */
static inline bool asmotion_next(asmotion_iterator *iterator, asmotion_value *key, asmotion_value *value) {
    asmotion_value here = iterator->next;
    if (iterator->left == 0 || here.at == NULL || here.at >= here.in->end) return false;
    if (iterator->left == SIZE_MAX) {
        if (*here.at == 0xFF) return false;
    } else {
        iterator->left--;
    }
    if (iterator->is_map) {
        if (key != NULL) *key = here;
        here.at = asmotion__behind(here.in, here.at, ASMOTION_DEPTH);
        if (here.at == NULL) return false;
    }
    *value = here;
    iterator->next.at = asmotion__behind(here.in, here.at, ASMOTION_DEPTH);
    return true;
}

/** The value of a key of a map; absent if there is none. */
static inline asmotion_value asmotion_get(asmotion_value map, const char *key) {
    asmotion_iterator entries = asmotion_iterate(map);
    asmotion_value name = {NULL, map.in}, value = {NULL, map.in}, none = {NULL, map.in};
    while (entries.is_map && asmotion_next(&entries, &name, &value)) {
        if (asmotion_is_text(name, key)) return value;
    }
    return none;
}

/** Number of elements of a list, numbers or bytes, or of entries of a map. */
static inline size_t asmotion_count(asmotion_value value) {
    asmotion_numbers numbers;
    asmotion_value part;
    size_t count = 0;
    if (asmotion_read_numbers(value, &numbers)) return numbers.count;
    asmotion_iterator parts = asmotion_iterate(value);
    while (asmotion_next(&parts, NULL, &part)) count++;
    return count;
}

/* ---- Writing ---------------------------------------------------------------------------------------------------- */

/** Writes CBOR into memory that grows. `is_failed` is set once there is no memory left. */
typedef struct asmotion_writer {
    uint8_t *bytes;
    size_t size;
    size_t capacity;
    /** Memory for large byte strings; NULL without. */
    uint8_t *shared;
    size_t shared_size;
    size_t shared_used;
    bool is_failed;
} asmotion_writer;

static inline void asmotion_free(asmotion_writer *writer) {
    free(writer->bytes);
    writer->bytes = NULL;
    writer->size = writer->capacity = 0;
}

/** Returns a place for `size` bytes, or NULL. */
static inline uint8_t *asmotion__grow(asmotion_writer *writer, size_t size) {
    if (size > SIZE_MAX / 2 - writer->size) writer->is_failed = true;
    if (writer->is_failed) return NULL;
    if (writer->size + size > writer->capacity) {
        size_t capacity = writer->capacity < 256 ? 256 : writer->capacity;
        while (capacity < writer->size + size) capacity *= 2;
        uint8_t *bytes = (uint8_t *)realloc(writer->bytes, capacity);
        if (bytes == NULL) {
            writer->is_failed = true;
            return NULL;
        }
        writer->bytes = bytes;
        writer->capacity = capacity;
    }
    uint8_t *place = writer->bytes + writer->size;
    writer->size += size;
    return place;
}

static inline void asmotion__write(asmotion_writer *writer, const void *bytes, size_t size) {
    uint8_t *place = asmotion__grow(writer, size);
    if (place != NULL && size > 0) memcpy(place, bytes, size);
}

static inline void asmotion__byte(asmotion_writer *writer, unsigned byte) {
    uint8_t one = (uint8_t)byte;
    asmotion__write(writer, &one, 1);
}

static inline void asmotion__write_head(asmotion_writer *writer, int major, uint64_t argument) {
    unsigned kind = (unsigned)major << 5;
    int size = argument < 24 ? 0 : argument <= 0xFF ? 1 : argument <= 0xFFFF ? 2 : argument <= 0xFFFFFFFF ? 4 : 8;
    int more = size == 0 ? (int)argument : size == 1 ? 24 : size == 2 ? 25 : size == 4 ? 26 : 27;
    asmotion__byte(writer, kind | (unsigned)more);
    for (int byte = size - 1; byte >= 0; byte--) asmotion__byte(writer, (unsigned)(argument >> (8 * byte) & 0xFF));
}

static inline void asmotion_write_null(asmotion_writer *writer) { asmotion__byte(writer, 0xF6); }

static inline void asmotion_write_bool(asmotion_writer *writer, bool value) { asmotion__byte(writer, value ? 0xF5 : 0xF4); }

static inline void asmotion_write_int(asmotion_writer *writer, int64_t value) {
    uint64_t argument = value < 0 ? (uint64_t)(-1 - value) : (uint64_t)value;
    asmotion__write_head(writer, value < 0 ? 1 : 0, argument);
}

static inline void asmotion_write_unsigned(asmotion_writer *writer, uint64_t value) { asmotion__write_head(writer, 0, value); }

static inline void asmotion_write_float(asmotion_writer *writer, double value) {
    uint64_t bits = 0;
    memcpy(&bits, &value, sizeof bits);
    asmotion__byte(writer, 0xFB);
    for (int byte = 7; byte >= 0; byte--) asmotion__byte(writer, (unsigned)(bits >> (8 * byte) & 0xFF));
}

/** Writes UTF-8 text of this length. */
static inline void asmotion_write_string(asmotion_writer *writer, const char *text, size_t size) {
    asmotion__write_head(writer, 3, size);
    asmotion__write(writer, text, size);
}

static inline void asmotion_write_text(asmotion_writer *writer, const char *text) {
    asmotion_write_string(writer, text, strlen(text));
}

/**
 * Writes a byte string whose content the caller fills in, before anything else is written. Returns NULL without memory.
 * A large one is in shared memory if there is any, so the engine's copy is the only one.
 */
static inline uint8_t *asmotion_write_space(asmotion_writer *writer, size_t size) {
    size_t from = (writer->shared_used + 63) & ~(size_t)63;
    bool is_shared = writer->shared != NULL && size >= ASMOTION_SHARED_FROM && from <= writer->shared_size;
    if (is_shared && size <= writer->shared_size - from) {
        asmotion__write_head(writer, 6, ASMOTION_SHARED_TAG);
        asmotion__write_head(writer, 4, 2);
        asmotion__write_head(writer, 0, from);
        asmotion__write_head(writer, 0, size);
        writer->shared_used = from + size;
        return writer->shared + from;
    }
    asmotion__write_head(writer, 2, size);
    return asmotion__grow(writer, size);
}

static inline void asmotion_write_bytes(asmotion_writer *writer, const void *bytes, size_t size) {
    uint8_t *space = asmotion_write_space(writer, size);
    if (space != NULL && size > 0) memcpy(space, bytes, size);
}

/** Writes numbers in the byte order of this machine as a typed array. */
static inline void asmotion_write_numbers(asmotion_writer *writer, asmotion_element element, const void *numbers,
                                          size_t count) {
    size_t size = asmotion_element_size(element);
    if (element != ASMOTION_U8) asmotion__write_head(writer, 6, element);
    uint8_t *space = asmotion_write_space(writer, count * size);
    if (space == NULL || count == 0) return;
    memcpy(space, numbers, count * size);
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    for (size_t index = 0; index < count; index++) {
        for (size_t byte = 0; byte < size / 2; byte++) {
            uint8_t *number = space + index * size, last = number[size - 1 - byte];
            number[size - 1 - byte] = number[byte];
            number[byte] = last;
        }
    }
#endif
}

/** Begins a list; `asmotion_write_end` ends it. */
static inline void asmotion_write_list(asmotion_writer *writer) { asmotion__byte(writer, 0x9F); }

/** Begins a map of texts and values. */
static inline void asmotion_write_map(asmotion_writer *writer) { asmotion__byte(writer, 0xBF); }

static inline void asmotion_write_end(asmotion_writer *writer) { asmotion__byte(writer, 0xFF); }

/** Writes a key and a text. */
static inline void asmotion_write_entry(asmotion_writer *writer, const char *key, const char *text) {
    asmotion_write_text(writer, key);
    asmotion_write_text(writer, text);
}

/** Copies a value from a document. */
static inline void asmotion_write_value(asmotion_writer *writer, asmotion_value value) {
    asmotion_bytes bytes;
    asmotion_numbers numbers;
    asmotion_value key = {NULL, value.in}, part = {NULL, value.in};
    switch (asmotion_kind_of(value)) {
    case ASMOTION_BYTES:
        if (asmotion_read_bytes(value, &bytes)) asmotion_write_bytes(writer, bytes.data, bytes.size);
        break;
    case ASMOTION_NUMBERS:
        if (asmotion_read_numbers(value, &numbers)) {
            asmotion__write_head(writer, 6, numbers.element);
            asmotion_write_bytes(writer, numbers.data, numbers.count * asmotion_element_size(numbers.element));
        }
        break;
    case ASMOTION_LIST:
    case ASMOTION_MAP: {
        asmotion_iterator parts = asmotion_iterate(value);
        if (parts.is_map) asmotion_write_map(writer);
        else asmotion_write_list(writer);
        while (asmotion_next(&parts, &key, &part)) {
            if (parts.is_map) asmotion_write_value(writer, key);
            asmotion_write_value(writer, part);
        }
        asmotion_write_end(writer);
        break;
    }
    case ASMOTION_NULL:
        asmotion_write_null(writer);
        break;
    case ASMOTION_FLOAT: {
        double number = 0;
        if (asmotion_read_float(value, &number)) asmotion_write_float(writer, number);
        break;
    }
    case ASMOTION_BOOL: case ASMOTION_INT: case ASMOTION_TEXT: default: {
        const uint8_t *behind = asmotion__behind(value.in, value.at, ASMOTION_DEPTH);
        asmotion__write(writer, value.at, behind == NULL ? 0 : (size_t)(behind - value.at));
        break;
    }
    }
}

/* ---- The connection --------------------------------------------------------------------------------------------- */

/** The connection to the engine. */
typedef struct asmotion_connection {
    int socket;
    /** Held while a frame is sent: `wake` comes from another thread. */
    pthread_mutex_t sending;
    uint8_t *received;
    size_t received_capacity;
    /** The request that is being answered. */
    asmotion_document request;
    /** The reply; its first four bytes are the length. */
    asmotion_writer reply;
    /** File descriptors that came with `hello`: memory of requests, and of replies; -1 without. */
    int files[2];
    uint8_t *request_memory;
    uint8_t *reply_memory;
    size_t memory_size;
} asmotion_connection;

typedef enum asmotion_received {
    ASMOTION_REQUEST,
    /** The engine has closed the connection. */
    ASMOTION_END,
    /** What arrived is no message. */
    ASMOTION_GARBAGE
} asmotion_received;

/** Connects to the engine that has started this program. Returns false with `errno` set. */
static inline bool asmotion_connect(asmotion_connection *connection) {
    struct sockaddr_un address;
    const char *path = getenv("ASMOTION_SOCKET");
    memset(connection, 0, sizeof *connection);
    memset(&address, 0, sizeof address);
    connection->files[0] = connection->files[1] = connection->socket = -1;
    address.sun_family = AF_UNIX;
    if (path == NULL || strlen(path) >= sizeof address.sun_path) {
        errno = path == NULL ? ENOENT : ENAMETOOLONG;
        return false;
    }
    memcpy(address.sun_path, path, strlen(path));
    connection->socket = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (connection->socket < 0) return false;
    if (connect(connection->socket, (const struct sockaddr *)&address, sizeof address) != 0) {
        close(connection->socket);
        connection->socket = -1;
        return false;
    }
    pthread_mutex_init(&connection->sending, NULL);
    return true;
}

static inline void asmotion_close(asmotion_connection *connection) {
    for (int index = 0; index < 2; index++) {
        if (connection->files[index] >= 0) close(connection->files[index]);
    }
    if (connection->request_memory != NULL) munmap(connection->request_memory, connection->memory_size);
    if (connection->reply_memory != NULL) munmap(connection->reply_memory, connection->memory_size);
    free(connection->received);
    asmotion_free(&connection->reply);
    if (connection->socket >= 0) {
        close(connection->socket);
        pthread_mutex_destroy(&connection->sending);
    }
    memset(connection, 0, sizeof *connection);
    connection->files[0] = connection->files[1] = connection->socket = -1;
}

/** Reads bytes of the socket, and keeps file descriptors that come with them. */
static inline bool asmotion__receive(asmotion_connection *connection, uint8_t *to, size_t size) {
    while (size > 0) {
        union {
            struct cmsghdr header;
            char bytes[CMSG_SPACE(2 * sizeof(int))];
        } control;
        struct iovec part = {to, size};
        struct msghdr message;
        memset(&message, 0, sizeof message);
        message.msg_iov = &part;
        message.msg_iovlen = 1;
        message.msg_control = control.bytes;
        message.msg_controllen = sizeof control.bytes;
        ssize_t count = recvmsg(connection->socket, &message, MSG_CMSG_CLOEXEC);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return false;
        struct cmsghdr *header = message.msg_controllen > 0 ? CMSG_FIRSTHDR(&message) : NULL;
        if (header != NULL && header->cmsg_level == SOL_SOCKET && header->cmsg_type == SCM_RIGHTS) {
            size_t files = (header->cmsg_len - CMSG_LEN(0)) / sizeof(int);
            for (size_t index = 0; index < files; index++) {
                int file = -1;
                memcpy(&file, CMSG_DATA(header) + index * sizeof(int), sizeof file);
                if (files == 2 && connection->files[index] < 0) connection->files[index] = file;
                else close(file);
            }
        }
        to += count;
        size -= (size_t)count;
    }
    return true;
}

/** Waits for a request, which is valid until the next one. */
static inline asmotion_received asmotion_receive(asmotion_connection *connection, asmotion_value *request) {
    uint8_t head[4];
    if (!asmotion__receive(connection, head, sizeof head)) return ASMOTION_END;
    size_t size = (size_t)head[0] | (size_t)head[1] << 8 | (size_t)head[2] << 16 | (size_t)head[3] << 24;
    if (size > ASMOTION_FRAME_LIMIT) return ASMOTION_GARBAGE;
    for (size_t received = 0; received < size;) {
        /* memory grows with the bytes that arrive */
        size_t part = size - received < ((size_t)1 << 20) ? size - received : (size_t)1 << 20;
        if (connection->received_capacity < received + part) {
            size_t capacity = received + part < 4096 ? 4096 : 2 * (received + part);
            uint8_t *bytes = (uint8_t *)realloc(connection->received, capacity);
            if (bytes == NULL) return ASMOTION_GARBAGE;
            connection->received = bytes;
            connection->received_capacity = capacity;
        }
        if (!asmotion__receive(connection, connection->received + received, part)) return ASMOTION_END;
        received += part;
    }
    connection->request.begin = connection->received;
    connection->request.end = connection->received == NULL ? NULL : connection->received + size;
    connection->request.shared = connection->request_memory;
    connection->request.shared_size = connection->request_memory == NULL ? 0 : connection->memory_size;
    if (size == 0 || !asmotion_check(&connection->request)) return ASMOTION_GARBAGE;
    *request = asmotion_root(&connection->request);
    return asmotion_kind_of(*request) == ASMOTION_MAP ? ASMOTION_REQUEST : ASMOTION_GARBAGE;
}

/** Maps the memory that `hello` announces. Returns whether there is any; without it, all data go through the socket. */
static inline bool asmotion_share(asmotion_connection *connection, asmotion_value hello) {
    int64_t announced = 0;
    struct stat of_requests, of_replies;
#ifdef ASMOTION_SOCKET_ONLY
    return false;
#endif
    if (!asmotion_read_int(asmotion_get(hello, "shared_memory"), &announced) || announced <= 0) return false;
    if (connection->files[0] < 0 || connection->files[1] < 0 || connection->request_memory != NULL) return false;
    if (fstat(connection->files[0], &of_requests) != 0 || fstat(connection->files[1], &of_replies) != 0) return false;
    /* a page behind the end of a file must not be accessed */
    if ((int64_t)of_requests.st_size < announced || (int64_t)of_replies.st_size < announced) return false;
    size_t size = (size_t)announced;
    void *requests = mmap(NULL, size, PROT_READ, MAP_SHARED, connection->files[0], 0);
    void *replies = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, connection->files[1], 0);
    if (requests == MAP_FAILED || replies == MAP_FAILED) {
        if (requests != MAP_FAILED) munmap(requests, size);
        if (replies != MAP_FAILED) munmap(replies, size);
        return false;
    }
    connection->request_memory = (uint8_t *)requests;
    connection->reply_memory = (uint8_t *)replies;
    connection->memory_size = size;
    return true;
}

/** Begins a message in `connection->reply`. */
static inline asmotion_writer *asmotion_begin(asmotion_connection *connection) {
    asmotion_writer *reply = &connection->reply;
    reply->size = 0;
    reply->is_failed = false;
    reply->shared = connection->reply_memory;
    reply->shared_size = connection->memory_size;
    reply->shared_used = 0;
    asmotion__grow(reply, 4);
    return reply;
}

static inline bool asmotion__send(asmotion_connection *connection, const uint8_t *bytes, size_t size) {
    bool is_sent = true;
    pthread_mutex_lock(&connection->sending);
    while (is_sent && size > 0) {
        ssize_t count = send(connection->socket, bytes, size, MSG_NOSIGNAL);
        if (count > 0) {
            bytes += count;
            size -= (size_t)count;
        } else {
            is_sent = count < 0 && errno == EINTR;
        }
    }
    pthread_mutex_unlock(&connection->sending);
    return is_sent;
}

/** Returns whether the message in `connection->reply` can be sent: there was memory for it, and it is not too long. */
static inline bool asmotion_is_sendable(const asmotion_connection *connection) {
    return !connection->reply.is_failed && connection->reply.size - 4 <= ASMOTION_FRAME_LIMIT;
}

/** Sends the message in `connection->reply`, after what the program has printed. */
static inline bool asmotion_send(asmotion_connection *connection) {
    asmotion_writer *reply = &connection->reply;
    size_t size = reply->size - 4;
    if (!asmotion_is_sendable(connection)) return false;
    for (int byte = 0; byte < 4; byte++) reply->bytes[byte] = (uint8_t)(size >> (8 * byte) & 0xFF);
    fflush(stdout);
    return asmotion__send(connection, reply->bytes, reply->size);
}

/** Requests a cycle, from any thread. In virtual time it has no effect. */
static inline bool asmotion_wake(asmotion_connection *connection) {
    static const uint8_t frame[] = {11, 0, 0, 0, 0xA1, 0x64, 't', 'y', 'p', 'e', 0x64, 'w', 'a', 'k', 'e'};
    return asmotion__send(connection, frame, sizeof frame);
}

/* ---- A component ------------------------------------------------------------------------------------------------ */

/**
 * Answers a request: writes keys and values of the reply, and returns its type. NULL is the usual reply without content,
 * `unsupported` for `freeze` and `thaw`. For `hello`, it writes the declaration and returns NULL.
 */
typedef const char *(*asmotion_handler)(void *component, const char *type, asmotion_value request, asmotion_writer *reply);

/** Writes the keys of a fault. A handler returns the result. */
static inline const char *asmotion_fault(asmotion_writer *reply, const char *code, const char *text) {
    asmotion_write_entry(reply, "code", code);
    asmotion_write_entry(reply, "text", text);
    return "fault";
}

/** The type of the usual reply to a request; NULL for an unknown one. */
static inline const char *asmotion_usual_reply(const char *type) {
    static const char *const replies[][2] = {
        {"hello", "declare"}, {"configure", "ok"}, {"start", "ok"}, {"cycle", "done"}, {"recover", "done"},
        {"serve", "done"}, {"stop", "done"}, {"cleanup", "ok"}, {"exception", "ok"}, {"inspect", "inspected"},
        {"freeze", "unsupported"}, {"thaw", "unsupported"},
    };
    for (size_t index = 0; index < sizeof replies / sizeof *replies; index++) {
        if (strcmp(replies[index][0], type) == 0) return replies[index][1];
    }
    return NULL;
}

/** Writes the keys of `declare` that concern the connection. */
static inline void asmotion_write_agreement(asmotion_connection *connection, asmotion_value hello) {
    asmotion_writer *reply = &connection->reply;
    asmotion_write_text(reply, "protocol");
    asmotion_write_int(reply, 1);
    if (asmotion_share(connection, hello)) {
        asmotion_write_text(reply, "shared_memory");
        asmotion_write_bool(reply, true);
    }
}

/** Begins a reply that is a fault with this text, in place of what has been written. */
static inline void asmotion_refuse(asmotion_connection *connection, const char *code, const char *text) {
    asmotion_writer *reply = asmotion_begin(connection);
    asmotion_write_map(reply);
    asmotion_write_entry(reply, "type", asmotion_fault(reply, code, text));
    asmotion_write_end(reply);
}

/** The type of a request as a text that ends with zero; empty if it has none of up to 31 bytes. */
static inline void asmotion_type_of(asmotion_value request, char type[32]) {
    asmotion_bytes text = {NULL, 0};
    asmotion_read_text(asmotion_get(request, "type"), &text);
    size_t size = text.size < 32 ? text.size : 0;
    if (size > 0) memcpy(type, text.data, size);
    type[size] = 0;
}

/** Answers one request. */
static inline void asmotion_answer(asmotion_connection *connection, asmotion_value request, asmotion_handler handler,
                                   void *component) {
    char type[32];
    int64_t protocol = 0;
    asmotion_type_of(request, type);
    const char *usual = asmotion_usual_reply(type);
    bool is_hello = strcmp(type, "hello") == 0;
    if (usual == NULL) {
        asmotion_refuse(connection, "PROTOCOL", "unknown request");
    } else if (is_hello && (!asmotion_read_int(asmotion_get(request, "protocol"), &protocol) || protocol != 1)) {
        asmotion_refuse(connection, "PROTOCOL", "this program has version 1 of the protocol");
    } else {
        asmotion_writer *reply = asmotion_begin(connection);
        asmotion_write_map(reply);
        if (is_hello) asmotion_write_agreement(connection, request);
        const char *given = handler(component, type, request, reply);
        asmotion_write_entry(reply, "type", given != NULL ? given : usual);
        asmotion_write_end(reply);
    }
    if (!asmotion_is_sendable(connection)) asmotion_refuse(connection, "PROTOCOL", "the reply is longer than a frame");
}

/** Runs a component until the engine ends it. Returns the exit status of the program. */
static inline int asmotion_run(asmotion_handler handler, void *component) {
    asmotion_connection connection;
    asmotion_value request = {NULL, NULL};
    asmotion_received received;
    int status = 0;
    if (!asmotion_connect(&connection)) {
        fprintf(stderr, "a component, which asmotion starts: implementation = { process = [\"./PROGRAM\"] } (%s)\n",
                getenv("ASMOTION_SOCKET") == NULL ? "`ASMOTION_SOCKET` is not set" : strerror(errno));
        return 2;
    }
    while ((received = asmotion_receive(&connection, &request)) == ASMOTION_REQUEST) {
        if (asmotion_is_text(asmotion_get(request, "type"), "exit")) break;
        asmotion_answer(&connection, request, handler, component);
        if (!asmotion_send(&connection)) break;
    }
    if (received == ASMOTION_GARBAGE) {
        fprintf(stderr, "the engine sent something that is no message\n");
        status = 1;
    }
    asmotion_close(&connection);
    return status;
}

#ifdef __cplusplus
}
#endif

#endif
