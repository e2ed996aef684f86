/* The C interface of cullet, a visibility engine: given a scene and a view, it decides what need not be drawn, and says why.
 *
 * CALLS. Every call that can fail returns a cullet_status; CULLET_STATUS_OK is 0. After another, cullet_last_error() is a
 * line that names the argument, the value, the limit and what to do, and nothing was changed unless the call says so. Outputs
 * are written only on success, but for counts that say how much room is needed. No panic or exception leaves a call.
 *
 * HANDLES are plain numbers, never pointers: one that is 0, stale, or of another kind of object is refused, for ever.
 *
 * POINTERS must have what the call says is there, as everywhere in C; NULL and what is not aligned is refused. All arrays are
 * copied, none is kept.
 *
 * THREADS. Every call may be made from any thread. Calls that read an object (cullet_cull reads its scene) may run side by
 * side; one that changes it (cullet_cull changes its state) needs it alone. A call that comes while another excludes it
 * returns CULLET_STATUS_BUSY at once and does nothing: nothing here waits. cullet_bake_* alone start threads, and end them
 * before they return. cullet_cull_on and cullet_bake_* alone call back: your functions that run jobs, on your threads, and that
 * hear of progress; and all calls those of an allocator of yours. cullet_last_error() is the calling thread's own.
 *
 * MEMORY is the system's allocator's, or that of functions of yours, if cullet_set_allocator is the first call. Calls that make,
 * add, open, commit, save or bake allocate, and so does whatever says so. A cull, its results, queries, and boxes and occlusion
 * buffers allocate only until their state, region, set or buffer has grown to what it needs; reading a scene never does. A call
 * that fails allocates its message. What a call allocates is freed by the _destroy of its object; nothing is yours to free.
 * Tables of handles and each thread's last message stay. Where memory is exhausted, the library writes a line to stderr and
 * aborts the process, as everywhere in Rust.
 *
 * SPACE is right-handed, +Y up; clip depth is 0 to 1; matrices are column-major. Origins, eyes and translations are double.
 *
 * PARTS. A library may be built without scenes, files or queries, and with tiles and bake (CULLET_FEATURES): cullet_bake_* and
 * cullet_scene_save are in that alone. This file is the same for each: a call that is not in the library fails when a program is
 * linked.
 *
 * This file is written from the source of the library: do not edit it.
 */
