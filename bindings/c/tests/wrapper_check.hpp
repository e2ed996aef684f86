// Checks of the tests in C++: each ends the program where it fails.
#ifndef CULLET_TESTS_WRAPPER_CHECK_HPP
#define CULLET_TESTS_WRAPPER_CHECK_HPP

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <cullet.hpp>

static void require(bool condition, const char *what) {
    if (condition) return;
    std::fprintf(stderr, "failed: %s (%s)\n", what, cullet_last_error());
    std::exit(1);
}

template <typename F>
static void throws(cullet_status status, F call, const char *what) {
    try {
        call();
    } catch (const cullet::error &error) {
        require(error.status() == status && std::strlen(error.what()) > 8, what);
        return;
    }
    require(false, what);
}

#endif
