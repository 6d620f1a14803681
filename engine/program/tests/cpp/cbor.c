/* Reads CBOR items in hexadecimal, one a line, and writes each again, or `refused`. Each is also damaged in many ways. */
#include "asmotion.h"

static uint8_t bytes[1 << 16];

/* Copied to the heap, where the address sanitizer sees every access outside. */
static bool again(const uint8_t *from, size_t size, bool is_shown) {
    uint8_t *copy = (uint8_t *)malloc(size == 0 ? 1 : size);
    uint8_t memory[64] = {0};
    asmotion_document document = {copy, copy + size, memory, sizeof memory};
    asmotion_writer writer;
    memset(&writer, 0, sizeof writer);
    memcpy(copy, from, size);
    bool is_accepted = asmotion_check(&document);
    if (is_accepted) {
        asmotion_write_value(&writer, asmotion_root(&document));
        (void)asmotion_count(asmotion_root(&document));
        asmotion_document written = {writer.bytes, writer.bytes + writer.size, NULL, 0};
        if (!asmotion_check(&written)) abort();
    }
    for (size_t index = 0; is_shown && is_accepted && index < writer.size; index++) printf("%02x", writer.bytes[index]);
    if (is_shown) printf("%s\n", is_accepted ? "" : "refused");
    asmotion_free(&writer);
    free(copy);
    return is_accepted;
}

int main(void) {
    static const uint8_t bad[] = {0x00, 0x1B, 0x1F, 0x3B, 0x5B, 0x5F, 0x7F, 0x82, 0x9B, 0x9F, 0xBB, 0xBF, 0xDA, 0xDB, 0xF9, 0xFF};
    static char line[2 * sizeof bytes + 2];
    while (fgets(line, sizeof line, stdin) != NULL) {
        size_t size = 0;
        unsigned byte = 0;
        while (sscanf(line + 2 * size, "%2x", &byte) == 1) bytes[size++] = (uint8_t)byte;
        again(bytes, size, true);
        for (size_t at = 0; at < size; at++) {
            uint8_t kept = bytes[at];
            again(bytes, at, false);
            for (size_t index = 0; index < sizeof bad; index++) {
                bytes[at] = bad[index];
                again(bytes, size, false);
            }
            bytes[at] = kept;
        }
    }
    return 0;
}
