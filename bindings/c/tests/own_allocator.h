/* An allocator over the system's that checks what cullet_set_allocator promises of its calls, and counts them. */
#ifndef CULLET_TESTS_OWN_ALLOCATOR_H
#define CULLET_TESTS_OWN_ALLOCATOR_H

#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cullet.h>

typedef struct {
    /* Calls that took memory, blocks and bytes that were not given back, and the largest alignment. */
    atomic_size_t calls, reallocs, blocks, bytes, most_alignment;
    /* No more memory once so many bytes are taken; 0 for no limit. */
    size_t limit;
} own_memory;

/* Stands behind a block, so that a block is found by its size alone. */
typedef struct { uint64_t size, alignment; } own_end;
enum { OWN_MARK = 0x5eed };

static void own_fail(const char *why, size_t size, size_t alignment) {
    fprintf(stderr, "the caller's allocator: %s (%zu bytes, alignment %zu)\n", why, size, alignment);
    abort();
}

static size_t own_room(size_t size, size_t alignment) {
    const size_t step = alignment < sizeof(own_end) ? sizeof(own_end) : alignment;
    return (size + sizeof(own_end) + step - 1) / step * step;
}

static void own_mark(void *at, size_t size, size_t alignment) {
    const own_end end = {size ^ OWN_MARK, alignment};
    memcpy((char *)at + size, &end, sizeof end);
}

static void *own_alloc(void *context, size_t size, size_t alignment) {
    own_memory *own = context;
    if (size == 0 || alignment == 0 || (alignment & (alignment - 1)) != 0) own_fail("no size, or no alignment", size, alignment);
    if (own->limit && atomic_load(&own->bytes) + size > own->limit) return NULL;
    void *at = aligned_alloc(alignment < 16 ? 16 : alignment, own_room(size, alignment));
    if (!at) return NULL;
    memset(at, 0xa5, size);
    own_mark(at, size, alignment);
    atomic_fetch_add(&own->calls, 1);
    atomic_fetch_add(&own->blocks, 1);
    atomic_fetch_add(&own->bytes, size);
    for (size_t most = own->most_alignment; most < alignment;)
        if (atomic_compare_exchange_weak(&own->most_alignment, &most, alignment)) break;
    return at;
}

static void own_free(void *context, void *memory, size_t size, size_t alignment) {
    own_memory *own = context;
    own_end end;
    if (!memory) own_fail("NULL is given back", size, alignment);
    memcpy(&end, (char *)memory + size, sizeof end);
    if (end.size != (size ^ OWN_MARK) || end.alignment != alignment) own_fail("given back otherwise than taken", size, alignment);
    memset((char *)memory + size, 0, sizeof end);
    atomic_fetch_sub(&own->blocks, 1);
    atomic_fetch_sub(&own->bytes, size);
    free(memory);
}

static void *own_realloc(void *context, void *memory, size_t old_size, size_t size, size_t alignment) {
    own_memory *own = context;
    void *at = own_alloc(context, size, alignment);
    atomic_fetch_add(&own->reallocs, 1);
    if (!at) return NULL;
    memcpy(at, memory, old_size < size ? old_size : size);
    own_free(context, memory, old_size, alignment);
    return at;
}

static cullet_allocator own_functions(own_memory *own) {
    const cullet_allocator functions = {own_alloc, own_free, own_realloc, own};
    return functions;
}

#endif
