/* A camera in C that refers to shared memory rightly or wrongly, as its argument says. */
#include "asmotion.h"

#include <errno.h>

static const char *how = "";
static asmotion_connection connection;

static bool is(const char *name) { return strcmp(how, name) == 0; }

static void port(asmotion_writer *to, const char *list, const char *name) {
    asmotion_write_text(to, list);
    asmotion_write_list(to);
    asmotion_write_map(to);
    asmotion_write_entry(to, "name", name);
    asmotion_write_text(to, "schema");
    asmotion_write_map(to);
    asmotion_write_entry(to, "name", "acme/Bytes");
    asmotion_write_text(to, "shape");
    asmotion_write_map(to);
    asmotion_write_text(to, "list");
    asmotion_write_map(to);
    asmotion_write_entry(to, "shape", "u8");
    asmotion_write_end(to);
    asmotion_write_end(to);
    asmotion_write_end(to);
    asmotion_write_end(to);
    asmotion_write_end(to);
}

/* Writes a sample that is a reference. */
static void refer(asmotion_writer *to, uint64_t offset, uint64_t length) {
    asmotion_write_list(to);
    asmotion_write_text(to, "out");
    asmotion__write_head(to, 6, ASMOTION_SHARED_TAG);
    asmotion__write_head(to, 4, 2);
    asmotion__write_head(to, 0, offset);
    if (is("negative")) asmotion_write_int(to, -1);
    else asmotion_write_unsigned(to, length);
    asmotion_write_end(to);
}

static void write_samples(asmotion_writer *to) {
    uint64_t size = connection.memory_size;
    asmotion_write_text(to, "outputs");
    asmotion_write_list(to);
    if (is("outside")) {
        refer(to, size - 5, 10);
    } else if (is("absurd")) {
        refer(to, INT64_MAX, INT64_MAX);
    } else if (is("often")) {
        for (int index = 0; index < 3; index++) refer(to, 0, size / 2);
    } else if (is("negative") || is("unagreed")) {
        refer(to, 0, 10);
    } else {
        memcpy(connection.reply_memory, "overlapping", 11);
        refer(to, 0, 8);
        refer(to, 4, 7);
        refer(to, size, 0);
    }
    asmotion_write_end(to);
}

/* Reports whether the samples are in shared memory, and whether it can be made shorter. */
static void write_reports(asmotion_value request, asmotion_writer *to) {
    asmotion_value port = asmotion_get(asmotion_get(request, "inputs"), "in"), sample;
    asmotion_iterator samples = asmotion_iterate(asmotion_get(port, "samples"));
    asmotion_write_text(to, "reports");
    asmotion_write_list(to);
    while (asmotion_next(&samples, NULL, &sample)) {
        asmotion_bytes bytes = {NULL, 0};
        uint64_t sum = 0;
        asmotion_read_bytes(sample, &bytes);
        for (size_t index = 0; index < bytes.size; index++) sum += bytes.data[index];
        bool is_shared = bytes.data >= connection.request_memory && bytes.data < connection.request_memory + connection.memory_size;
        asmotion_write_list(to);
        asmotion_write_text(to, is_shared ? "shared" : "sent");
        asmotion_write_unsigned(to, sum);
        asmotion_write_end(to);
    }
    for (int index = 0; index < 2; index++) {
        if (ftruncate(connection.files[index], 10) != 0 && errno == EPERM) continue;
        asmotion_write_list(to);
        asmotion_write_text(to, "shortened");
        asmotion_write_bool(to, true);
        asmotion_write_end(to);
    }
    asmotion_write_end(to);
}

static const char *answer(void *component, const char *type, asmotion_value request, asmotion_writer *to) {
    (void)component;
    if (strcmp(type, "hello") == 0) {
        port(to, "inputs", "in");
        port(to, "outputs", "out");
    } else if (strcmp(type, "cycle") == 0) {
        if (!is("reads")) write_samples(to);
        if (is("reads")) write_reports(request, to);
    }
    return NULL;
}

int main(int count, char **arguments) {
    asmotion_value request;
    if (count > 1) how = arguments[1];
    if (!asmotion_connect(&connection)) return 2;
    while (asmotion_receive(&connection, &request) == ASMOTION_REQUEST) {
        if (asmotion_is_text(asmotion_get(request, "type"), "exit")) break;
        if (is("unagreed") && connection.files[0] >= 0) {
            close(connection.files[0]);
            connection.files[0] = -1;
        }
        asmotion_answer(&connection, request, answer, NULL);
        if (!asmotion_send(&connection)) break;
    }
    asmotion_close(&connection);
    return 0;
}
