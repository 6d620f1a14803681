/* A component in C: counts, and goes wrong as its first argument says. */
#include "asmotion.h"

static int64_t count = 0;
static const char *how = "";

static void schema(asmotion_writer *to) {
    asmotion_write_text(to, "schema");
    asmotion_write_map(to);
    asmotion_write_entry(to, "name", "acme/Number");
    asmotion_write_text(to, "shape");
    asmotion_write_map(to);
    asmotion_write_text(to, "record");
    asmotion_write_list(to);
    asmotion_write_map(to);
    asmotion_write_entry(to, "name", "n");
    asmotion_write_text(to, "schema");
    asmotion_write_map(to);
    asmotion_write_entry(to, "shape", "i64");
    asmotion_write_end(to);
    asmotion_write_end(to);
    asmotion_write_end(to);
    asmotion_write_end(to);
    asmotion_write_end(to);
}

static void port(asmotion_writer *to, const char *list, const char *name) {
    asmotion_write_text(to, list);
    asmotion_write_list(to);
    asmotion_write_map(to);
    asmotion_write_entry(to, "name", name);
    schema(to);
    asmotion_write_end(to);
    asmotion_write_end(to);
}

static void cycle(asmotion_value request, asmotion_writer *to) {
    asmotion_value step = asmotion_get(asmotion_get(request, "inputs"), "step");
    asmotion_iterator samples = asmotion_iterate(asmotion_get(step, "samples"));
    asmotion_value sample;
    int64_t added = 0;
    bool is_third = ++count == 3;
    while (asmotion_next(&samples, NULL, &sample)) {
        if (asmotion_read_int(asmotion_get(sample, "n"), &added)) count += added;
    }
    asmotion_write_text(to, "outputs");
    asmotion_write_list(to);
    asmotion_write_list(to);
    asmotion_write_text(to, is_third && strcmp(how, "port") == 0 ? "elsewhere" : "count");
    asmotion_write_map(to);
    asmotion_write_text(to, "n");
    if (is_third && strcmp(how, "type") == 0) asmotion_write_text(to, "three");
    else asmotion_write_int(to, count);
    asmotion_write_end(to);
    asmotion_write_end(to);
    asmotion_write_end(to);
}

static const char *answer(void *component, const char *type, asmotion_value request, asmotion_writer *to) {
    asmotion_bytes state;
    (void)component;
    if (strcmp(type, "hello") == 0) {
        port(to, "inputs", "step");
        port(to, "outputs", "count");
    } else if (strcmp(type, "cycle") == 0) {
        if (count == 2 && strcmp(how, "fault") == 0) return asmotion_fault(to, "JAMMED", "the counter is stuck");
        cycle(request, to);
    } else if (strcmp(type, "freeze") == 0) {
        asmotion_write_text(to, "state");
        asmotion_write_bytes(to, &count, sizeof count);
        return "frozen";
    } else if (strcmp(type, "thaw") == 0) {
        if (!asmotion_read_bytes(asmotion_get(request, "state"), &state) || state.size != sizeof count) {
            return asmotion_fault(to, "", "no state of a counter");
        }
        memcpy(&count, state.data, sizeof count);
        return "ok";
    }
    return NULL;
}

int main(int count_of_arguments, char **arguments) {
    if (count_of_arguments > 1) how = arguments[1];
    return asmotion_run(answer, NULL);
}
