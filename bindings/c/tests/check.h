/* Checks of the tests in C: each ends the program with the line and the last error where it fails. */
#ifndef CULLET_TESTS_CHECK_H
#define CULLET_TESTS_CHECK_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cullet.h>

static int checks = 0;

#define IS(expected, call) is(expected, call, #call, __LINE__)
static void is(cullet_status expected, cullet_status got, const char *call, int line) {
    checks++;
    if (expected == got && (got == CULLET_STATUS_OK || strlen(cullet_last_error()) > 12)) return;
    fprintf(stderr, "line %d: %s: %s, not %s (%s)\n", line, call, cullet_status_name((int32_t)got),
            cullet_status_name((int32_t)expected), cullet_last_error());
    exit(1);
}

#define THAT(condition) that(condition, #condition, __LINE__)
static void that(int condition, const char *words, int line) {
    checks++;
    if (condition) return;
    fprintf(stderr, "line %d: %s (last error: %s)\n", line, words, cullet_last_error());
    exit(1);
}

/* The message of the last call that failed has these words. */
#define SAYS(words) that(strstr(cullet_last_error(), words) != NULL, words, __LINE__)

static inline cullet_view ahead(void) {
    const double eye[3] = {0, 0, 0}, target[3] = {0, 0, -1};
    cullet_view view;
    IS(CULLET_STATUS_OK, cullet_view_look_at(eye, target, 0.9, 0.1, 640, 400, &view));
    return view;
}

#endif
