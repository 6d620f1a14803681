/* Requests and replies of 56 bytes over ZeroMQ: `server ADDRESS`, or `client ADDRESS`, which measures on request. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <zmq.h>

enum { SIZE = 56, MOST = 10000 };

static long long now(void) {
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return at.tv_sec * 1000000000LL + at.tv_nsec;
}

static int serve(void *socket, const char *address) {
    char bytes[SIZE];
    if (zmq_bind(socket, address) != 0) return 1;
    for (;;) {
        int count = zmq_recv(socket, bytes, SIZE, 0);
        if (count < 0 || zmq_send(socket, bytes, count, 0) < 0) return 1;
    }
}

static int measure(void *socket, const char *address) {
    static long long times[MOST];
    char bytes[SIZE] = {0}, line[32];
    if (zmq_connect(socket, address) != 0) return 1;
    while (fgets(line, sizeof line, stdin)) {
        int count = atoi(line);
        if (count < 0 || count > MOST) return 1;
        for (int trip = 0; trip < count; trip++) {
            long long begin = now();
            if (zmq_send(socket, bytes, SIZE, 0) < 0 || zmq_recv(socket, bytes, SIZE, 0) < 0) return 1;
            times[trip] = now() - begin;
        }
        for (int trip = 0; trip < count; trip++) printf("%lld\n", times[trip]);
        fflush(stdout);
    }
    return 0;
}

int main(int count, char **words) {
    if (count != 3) return 2;
    int is_server = strcmp(words[1], "server") == 0;
    void *socket = zmq_socket(zmq_ctx_new(), is_server ? ZMQ_REP : ZMQ_REQ);
    return is_server ? serve(socket, words[2]) : measure(socket, words[2]);
}
