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

#ifndef CULLET_H
#define CULLET_H

#include <stddef.h>
#include <stdint.h>

/**
 * No stage but the layers may cull it. Bit of `cullet_instance.flags`.
 */
#define CULLET_ALWAYS_VISIBLE 1

/**
 * It never hides anything. Bit of `cullet_instance.flags`.
 */
#define CULLET_NO_OCCLUSION 2

/**
 * Both sides of its triangles are drawn, whatever its mesh says. Bit of `cullet_instance.flags`.
 */
#define CULLET_TWO_SIDED 4

/**
 * It is blended, whatever its mesh says. Bit of `cullet_instance.flags`.
 */
#define CULLET_TRANSPARENT 8

/**
 * It is going to move: a hint that keeps nodes of what stands tight. Bit of
 * `cullet_instance.flags`.
 */
#define CULLET_DYNAMIC 16

/**
 * One-sided: only the fronts of its triangles are drawn, which are counter-clockwise. Only such
 * meshes have back faces to cull. Bit of `cullet_part.flags` and `cullet_mesh_arrays.flags`.
 */
#define CULLET_ONE_SIDED 1

/**
 * Vertices may move (skinned, morphed): give instances bounds that hold every pose, and no cluster
 * of it is culled by itself. Bit of `cullet_mesh_arrays.flags`.
 */
#define CULLET_DEFORMABLE 2

/**
 * The material is cut out by a threshold: it never hides anything. Bit of `cullet_part.flags` and
 * `cullet_mesh_arrays.flags`.
 */
#define CULLET_MASKED 4

/**
 * The material is blended: it never hides anything. Bit of `cullet_part.flags` and
 * `cullet_mesh_arrays.flags`.
 */
#define CULLET_BLENDED 8

/**
 * Two sides are drawn. Bit of `cullet_draw_key.state`.
 */
#define CULLET_DRAW_TWO_SIDED 1

/**
 * The transform mirrors: fronts are clockwise on the screen. Bit of `cullet_draw_key.state`.
 */
#define CULLET_DRAW_MIRRORED 2

/**
 * The material is cut out by a threshold. Bit of `cullet_draw_key.state`.
 */
#define CULLET_DRAW_MASKED 4

/**
 * The material is blended: draws want an order from back to front. Bit of `cullet_draw_key.state`.
 */
#define CULLET_DRAW_BLENDED 8

/**
 * Clip depth 0 at the near plane, 1 at the far plane. Value of `depth`.
 */
#define CULLET_DEPTH_STANDARD 0

/**
 * Clip depth 1 at the near plane, 0 at the far plane, which may be infinitely far. Value of
 * `depth`.
 */
#define CULLET_DEPTH_REVERSED 1

/**
 * How a call went. All but `CULLET_STATUS_OK` leave a message in `cullet_last_error`, and change
 * nothing unless they say so.
 */
typedef enum {
  /**
   * It did what it says.
   */
  CULLET_STATUS_OK = 0,
  /**
   * A pointer is NULL that must not be.
   */
  CULLET_STATUS_NULL_POINTER = 1,
  /**
   * A pointer is not aligned to what it points to.
   */
  CULLET_STATUS_ALIGNMENT = 2,
  /**
   * The `size` of a struct is not the one that this library knows: it was not filled by the
   * function that fills it, or header and library are of different versions.
   */
  CULLET_STATUS_STRUCT_SIZE = 3,
  /**
   * A number is outside its range, or not finite, or a text is not UTF-8.
   */
  CULLET_STATUS_INVALID_VALUE = 4,
  /**
   * A handle is 0, so that it was never made.
   */
  CULLET_STATUS_NULL_HANDLE = 5,
  /**
   * A handle's object was destroyed.
   */
  CULLET_STATUS_STALE_HANDLE = 6,
  /**
   * A handle is of another kind of object.
   */
  CULLET_STATUS_WRONG_HANDLE = 7,
  /**
   * Another thread is using the object in a way that excludes this call. Nothing waits; see the
   * rules on threads.
   */
  CULLET_STATUS_BUSY = 8,
  /**
   * An array is too short; the count that is needed was written.
   */
  CULLET_STATUS_TOO_SMALL = 9,
  /**
   * A state holds no result yet, or the scene has changed since, or it is of another scene: cull
   * again.
   */
  CULLET_STATUS_NO_RESULT = 10,
  /**
   * An instance handle names no instance of the scene, or a mesh or a slot is not there.
   */
  CULLET_STATUS_NOT_FOUND = 11,
  /**
   * A mesh is refused: an index beyond the vertices, a position that is not finite.
   */
  CULLET_STATUS_MESH = 12,
  /**
   * The numbers make no view.
   */
  CULLET_STATUS_VIEW = 13,
  /**
   * A file, or the bytes of one, cannot be loaded or written, or is of another scene.
   */
  CULLET_STATUS_FILE = 14,
  /**
   * There are as many objects as there can be.
   */
  CULLET_STATUS_FULL = 15,
  /**
   * A defect of this library: the call was stopped. The object that it was about to change can
   * only be destroyed.
   */
  CULLET_STATUS_INTERNAL = 16,
  /**
   * A bake ended before its end: a callback stopped it, or it was one share of several. The scene
   * is as it was; what was finished lies in the folder of the bake, if it has one.
   */
  CULLET_STATUS_STOPPED = 17,
  /**
   * It had to be called before the library allocated memory.
   */
  CULLET_STATUS_TOO_LATE = 18,
} cullet_status;

/**
 * Contents of the two arrays of boxes.
 */
typedef enum {
  /**
   * The lowest and the highest corner.
   */
  CULLET_BOX_FORM_MIN_MAX = 0,
  /**
   * The centre and half the size.
   */
  CULLET_BOX_FORM_CENTER_HALF = 1,
} cullet_box_form;

/**
 * Kinds of lights.
 */
typedef enum {
  /**
   * Parallel rays, as of the sun.
   */
  CULLET_LIGHT_KIND_DIRECTIONAL = 0,
  /**
   * A light that shines all around.
   */
  CULLET_LIGHT_KIND_POINT = 1,
  /**
   * A light that shines into a cone.
   */
  CULLET_LIGHT_KIND_SPOT = 2,
} cullet_light_kind;

/**
 * Why a light does not matter for a view.
 */
typedef enum {
  /**
   * It may matter.
   */
  CULLET_LIGHT_REASON_KEPT = 0,
  /**
   * It lights nothing at all.
   */
  CULLET_LIGHT_REASON_UNLIT = 1,
  /**
   * Everything that it reaches is outside the view.
   */
  CULLET_LIGHT_REASON_FRUSTUM = 2,
  /**
   * Everything that it reaches is hidden.
   */
  CULLET_LIGHT_REASON_OCCLUSION = 3,
  /**
   * It reaches nothing that the view was found to see.
   */
  CULLET_LIGHT_REASON_NO_RECEIVER = 4,
} cullet_light_reason;

/**
 * Types of numbers in arrays of the caller's.
 */
typedef enum {
  /**
   * `float`.
   */
  CULLET_NUMBER_F32 = 0,
  /**
   * `double`.
   */
  CULLET_NUMBER_F64 = 1,
} cullet_number;

/**
 * Kinds of occluders.
 */
typedef enum {
  /**
   * Boxes, each within what is opaque: `positions` has a lowest and a highest corner for each,
   * six floats.
   */
  CULLET_OCCLUDER_KIND_BOXES = 0,
  /**
   * A closed convex body, of triangles wound counter-clockwise seen from outside: the quickest
   * kind by far for what is convex. Up to 256 corners.
   */
  CULLET_OCCLUDER_KIND_HULL = 1,
  /**
   * Triangles that hide from their fronts alone, which are counter-clockwise.
   */
  CULLET_OCCLUDER_KIND_TRIANGLES = 2,
  /**
   * Triangles that hide from both sides.
   */
  CULLET_OCCLUDER_KIND_TWO_SIDED_TRIANGLES = 3,
} cullet_occluder_kind;

/**
 * Bounds of an instance.
 */
typedef enum {
  /**
   * The box of its mesh, transformed.
   */
  CULLET_BOUNDS_MESH = 0,
  /**
   * None: it is visible to every stage but the layers.
   */
  CULLET_BOUNDS_NONE = 1,
  /**
   * A box in world space, relative to the scene's origin: what is animated, or placed by a
   * shader.
   */
  CULLET_BOUNDS_WORLD = 2,
  /**
   * The box of its mesh, grown on every side by a distance: for vertices that a shader
   * displaces.
   */
  CULLET_BOUNDS_MARGIN = 3,
} cullet_bounds;

/**
 * Settings that go together. None has a stage that is lossy.
 */
typedef enum {
  /**
   * Everything that can be proved, for tools and for renderers to which a triangle costs much.
   */
  CULLET_PRESET_EXACT = 0,
  /**
   * Stages that pay in most frames: the default.
   */
  CULLET_PRESET_BALANCED = 1,
  /**
   * Stages that are fastest to run.
   */
  CULLET_PRESET_FAST = 2,
} cullet_preset;

/**
 * How deep the answer goes.
 */
typedef enum {
  /**
   * Whole instances.
   */
  CULLET_OUTPUT_INSTANCES = 0,
  /**
   * Instances, and of those that straddle the frustum or are one-sided the clusters that are
   * left: the default.
   */
  CULLET_OUTPUT_CLUSTERS = 1,
  /**
   * Triangles of every visible instance.
   */
  CULLET_OUTPUT_TRIANGLES = 2,
} cullet_output;

/**
 * How back faces of one-sided meshes are culled.
 */
typedef enum {
  /**
   * Not at all.
   */
  CULLET_BACKFACES_OFF = 0,
  /**
   * Clusters by cones, and where the output is triangles, each by a plane of four bytes: the
   * default.
   */
  CULLET_BACKFACES_FAST = 1,
  /**
   * Every triangle from its corners, where the output is triangles: some fifty times as long.
   */
  CULLET_BACKFACES_EXACT = 2,
} cullet_backfaces;

/**
 * Kinds of culling, in the order in which they run.
 */
typedef enum {
  /**
   * No stage: visible.
   */
  CULLET_STAGE_VISIBLE = 0,
  /**
   * Layers that view and instance do not share.
   */
  CULLET_STAGE_LAYER = 1,
  /**
   * Outside the frustum.
   */
  CULLET_STAGE_FRUSTUM = 2,
  /**
   * Not in the potentially visible set of the eye's cell.
   */
  CULLET_STAGE_PVS = 3,
  /**
   * Not seen through any portal.
   */
  CULLET_STAGE_PORTAL = 4,
  /**
   * Too small on the screen.
   */
  CULLET_STAGE_DETAIL = 5,
  /**
   * Another level of detail stands for it.
   */
  CULLET_STAGE_LOD = 6,
  /**
   * Behind something.
   */
  CULLET_STAGE_OCCLUSION = 7,
  /**
   * Seen from behind.
   */
  CULLET_STAGE_BACKFACE = 8,
  /**
   * Without area.
   */
  CULLET_STAGE_DEGENERATE = 9,
} cullet_stage;

/**
 * Result of a test of an occlusion buffer.
 */
typedef enum {
  /**
   * It may be visible.
   */
  CULLET_FOUND_VISIBLE = 0,
  /**
   * It is proved to be hidden.
   */
  CULLET_FOUND_HIDDEN = 1,
  /**
   * It is out of the view.
   */
  CULLET_FOUND_OUTSIDE = 2,
} cullet_found;

/**
 * Kinds of items that visible sets hold.
 */
typedef enum {
  /**
   * Cells of the scene. Conservative, and true of whatever moves.
   */
  CULLET_PVS_TARGETS_CELLS = 0,
  /**
   * Instances, by the `index` of their handles, seen from view cells: boxes that the sets bring
   * along. Found by sampled lines, so that something may be missing.
   */
  CULLET_PVS_TARGETS_INSTANCES = 1,
} cullet_pvs_targets;

/**
 * Functions that the library takes all its memory from. They are called on every thread that makes
 * calls, several at once, and must not call this library, throw or jump out.
 */
typedef struct {
  /**
   * Returns `size` bytes, at least 1, at a multiple of `alignment`, a power of two: up to 64 in this
   * version. What is in them does not matter. NULL where there is no memory: then the library
   * writes a line to stderr and aborts the process.
   */
  void *(*alloc)(void *context, size_t size, size_t alignment);
  /**
   * Takes memory back that `alloc` or `realloc` returned, with the size and the alignment that it
   * was asked for with.
   */
  void (*free)(void *context, void *memory, size_t size, size_t alignment);
  /**
   * Makes memory larger or smaller, in place or elsewhere, and keeps what is in it up to the lesser
   * size; NULL where there is no memory, and then the old one stays. NULL for the function itself:
   * the library then calls `alloc`, copies, and calls `free`.
   */
  void *(*realloc)(void *context, void *memory, size_t old_size, size_t size, size_t alignment);
  /**
   * Handed to each of them.
   */
  void *context;
} cullet_allocator;

/**
 * Handle of a scene. A plain number: copy it freely; 0 is none.
 */
typedef struct {
  /**
   * Not to be read or made.
   */
  uint64_t id;
} cullet_scene;

/**
 * Threads, progress and units of a bake. Set it to zero before its fields. Nothing of it changes
 * what is baked.
 */
typedef struct {
  /**
   * Threads that work, up to 1024; 0 and 1 for one. They are the library's own, end before the
   * call does, and have stacks of up to 8 MiB.
   */
  uint32_t threads;
  /**
   * Number of this share of the work, from 0 and below `share_count`.
   */
  uint32_t share;
  /**
   * Shares that the work is split into, each a call on any machine with the same folder and the
   * same scene; 0 and 1 for all of it. A share does its own units, and those of others where the
   * rest of the work needs them. Such a call returns `CULLET_STATUS_STOPPED` once its share lies
   * in the folder and others are missing. A call without shares joins what is there.
   */
  uint32_t share_count;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Folder for finished units, UTF-8; it is made where it is not there. What lies there of the
   * same scene and settings is not done again, so that a bake goes on after a stop. NULL for none.
   */
  const char *folder;
  /**
   * Called after each unit of work with the share of it that is done, 0 to 1 and never falling;
   * returns 1 to go on, and 0 to stop: the call then returns `CULLET_STATUS_STOPPED` as soon as
   * the units that were begun are done. Called on threads of the bake, by one at a time, and no
   * more once it returned 0. It may make calls, but none that changes the scene that is baked.
   * NULL for none.
   */
  uint32_t (*step)(void *context, double share);
  /**
   * Handed to `step`.
   */
  void *context;
} cullet_bake_options;

/**
 * All eyes in a box, in world space. A point is a box too; one whose `min` is above its `max` has
 * no eye; where a number is not finite, eyes may be anywhere.
 */
typedef struct {
  /**
   * The lowest corner.
   */
  double min[3];
  /**
   * The highest corner.
   */
  double max[3];
} cullet_eye_box;

/**
 * Settings of visible sets. Set them to zero before their fields: 0 takes the default of each.
 */
typedef struct {
  /**
   * Boxes to make view cells in, in world space; NULL for the bounds of the scene.
   */
  const cullet_eye_box *boxes;
  /**
   * How many boxes.
   */
  size_t box_count;
  /**
   * 1 where the boxes are the view cells themselves; then `cells` and `grid` are 0.
   */
  uint32_t boxes_are_cells;
  /**
   * How many view cells to make, small ones where geometry is near; default 500.
   */
  uint32_t cells;
  /**
   * In place of that: equal cells, so many along each axis of the one box.
   */
  uint32_t grid[3];
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * The bake ends after about so many rays; default 100,000,000.
   */
  uint64_t rays;
  /**
   * Seed of the rays; default 1.
   */
  uint64_t seed;
  /**
   * The bake ends earlier where the mean share of looks that are estimated to miss something is
   * at most this, up to 1; default 0.00002. Below 0 to use all rays.
   */
  double missing;
  /**
   * Things that could appear wider than this are kept, met by a ray or not: in radians, up to pi,
   * the default, which keeps what a cell may touch.
   */
  double keep_angle;
  /**
   * View cells get the sets of others within this distance, in world units; default none.
   */
  double join;
} cullet_pvs_settings;

/**
 * Handle of potentially visible sets: what may be seen from each of some cells. A plain number: copy
 * it freely; 0 is none.
 */
typedef struct {
  /**
   * Not to be read or made.
   */
  uint64_t id;
} cullet_pvs;

/**
 * Handle of an instance in its scene: stays the same until the instance is removed.
 */
typedef struct {
  /**
   * Index, from 0 in the order in which instances are added, used again after a removal.
   */
  uint32_t index;
  /**
   * How often that index was used before.
   */
  uint32_t generation;
} cullet_handle;

/**
 * Settings of cells that are found. Set them to zero before their fields.
 */
typedef struct {
  /**
   * Side of a voxel, in world units: no more than half as thick as the walls. 0 finds one.
   */
  double voxel;
  /**
   * Instances that hide nothing because they move, such as doors; NULL for none.
   */
  const cullet_handle *ignored;
  /**
   * How many of them.
   */
  size_t ignored_count;
} cullet_cells_settings;

/**
 * Handle of a set of boxes. A plain number: copy it freely; 0 is none.
 */
typedef struct {
  /**
   * Not to be read or made.
   */
  uint64_t id;
} cullet_boxes;

/**
 * Boxes in arrays of the caller's, of any layout. Set it to zero before its fields.
 */
typedef struct {
  /**
   * The three numbers of the first box's lowest corner, or of its centre.
   */
  const void *first;
  /**
   * The three numbers of the first box's highest corner, or of half its size.
   */
  const void *second;
  /**
   * Bytes from one box to the next in `first`: a multiple of the size of a number, at least three
   * of them.
   */
  size_t stride;
  /**
   * The same for `second`; 0 for that of `first`.
   */
  size_t second_stride;
  /**
   * How many boxes.
   */
  size_t count;
  /**
   * A `cullet_number`: the type of all numbers.
   */
  uint32_t number;
  /**
   * A `cullet_box_form`: what `first` and `second` are.
   */
  uint32_t form;
  /**
   * The point of the world that the numbers are relative to; finite. Zero for none.
   */
  double origin[3];
} cullet_box_arrays;

/**
 * A view: what a camera sees, and how. Filled by `cullet_view_from_matrix`,
 * `cullet_view_from_camera` or `cullet_view_look_at`; then its last three fields may be changed.
 */
typedef struct {
  /**
   * The size of this struct, by which one that was never filled is known.
   */
  uint32_t size;
  /**
   * `CULLET_DEPTH_STANDARD` or `CULLET_DEPTH_REVERSED`.
   */
  uint32_t depth;
  /**
   * World to clip space, column-major.
   */
  double clip_from_world[16];
  /**
   * Width of the viewport in pixels, 1 to 65536.
   */
  uint32_t width;
  /**
   * Height of the viewport in pixels, 1 to 65536.
   */
  uint32_t height;
  /**
   * Layers that it sees; all of them at first.
   */
  uint32_t layers;
  /**
   * 1 where fronts are clockwise; 0 at first.
   */
  uint32_t clockwise;
  /**
   * Faces of one-sided meshes that are not drawn: 0 none, 1 the backs, 2 the fronts, as some
   * shadow passes do; 1 at first.
   */
  uint32_t cull_face;
  /**
   * 0.
   */
  uint32_t reserved;
} cullet_view;

/**
 * An affine transform: x becomes linear * x + translation. Mirrored and singular ones too; one
 * that is not finite keeps its instance visible.
 */
typedef struct {
  /**
   * The columns of the linear part, one after another.
   */
  float linear[9];
  /**
   * The translation; double, so that worlds of 1e7 units stay right.
   */
  double translation[3];
} cullet_transform;

/**
 * An occluder, in arrays of the caller's. Set it to zero before its fields.
 */
typedef struct {
  /**
   * A `cullet_occluder_kind`.
   */
  uint32_t kind;
  /**
   * Bytes of an index: 4 or 2; 0 for 4.
   */
  uint32_t index_size;
  /**
   * Three floats a vertex, or six a box, each finite.
   */
  const float *positions;
  /**
   * Bytes from one vertex, or one box, to the next: a multiple of 4.
   */
  size_t stride;
  /**
   * How many vertices, or boxes.
   */
  size_t position_count;
  /**
   * Three a triangle, each below `position_count`: `uint32_t`, or `uint16_t` by `index_size`. Not
   * read for boxes.
   */
  const void *indices;
  /**
   * How many indices.
   */
  size_t index_count;
  /**
   * Where it stands; NULL for the identity. One that is not finite hides nothing.
   */
  const cullet_transform *transform;
} cullet_occluder;

/**
 * Handle of an occlusion buffer. A plain number: copy it freely; 0 is none.
 */
typedef struct {
  /**
   * Not to be read or made.
   */
  uint64_t id;
} cullet_occlusion;

/**
 * Triangles in clip space, or with a matrix that takes them there.
 */
typedef struct {
  /**
   * x of the first vertex.
   */
  const float *vertices;
  /**
   * Bytes from one vertex to the next, a multiple of 4.
   */
  size_t stride;
  /**
   * Bytes from x to y, a multiple of 4.
   */
  size_t offset_y;
  /**
   * Bytes from x to w, or with a matrix from x to z; a multiple of 4.
   */
  size_t offset_zw;
  /**
   * Three a triangle; there must be as many vertices as they say.
   */
  const uint32_t *indices;
  /**
   * How many triangles.
   */
  size_t triangle_count;
  /**
   * 16 floats, column-major, that take x, y, z, 1 to clip space; NULL where vertices are x, y, w
   * of clip space.
   */
  const float *clip_from_model;
  /**
   * Winding that is culled on a screen with y upward: 0 nothing, 1 clockwise, 2
   * counter-clockwise.
   */
  uint32_t cull_winding;
  /**
   * 0.
   */
  uint32_t reserved;
} cullet_clip_triangles;

/**
 * Handle of the state of a view: what it remembers between frames, and its last result. One for
 * each view that is culled frame after frame. A plain number: copy it freely; 0 is none.
 */
typedef struct {
  /**
   * Not to be read or made.
   */
  uint64_t id;
} cullet_state;

/**
 * Settings of culling. Filled by `cullet_settings_preset`; then any field may be changed. Switches
 * are 0 or 1.
 */
typedef struct {
  /**
   * The size of this struct, by which one that was never filled is known.
   */
  uint32_t size;
  /**
   * Cull what is outside the frustum.
   */
  uint32_t frustum;
  /**
   * An exact test for each box that straddles the frustum: drops big boxes near its corners.
   */
  uint32_t frustum_exact;
  /**
   * Cull by the potentially visible sets of a scene that has some.
   */
  uint32_t pvs;
  /**
   * Cull by the cells and portals of a scene that has some.
   */
  uint32_t portals;
  /**
   * A `cullet_backfaces`.
   */
  uint32_t backfaces;
  /**
   * Cull triangles without area.
   */
  uint32_t degenerate;
  /**
   * Cull what lies behind other instances.
   */
  uint32_t occlusion;
  /**
   * Pixels across the occlusion buffer, 1 to 4096, at most the viewport's. More sees smaller
   * gaps, and costs its square.
   */
  uint32_t occlusion_width;
  /**
   * Budget for drawing occluders, in microseconds of a cost model, from 0.
   */
  float occlusion_budget;
  /**
   * Share of the cost of drawing what is left that may be spent where nothing is found, from 0;
   * below 0 for no limit.
   */
  float occlusion_risk;
  /**
   * Lossy: cull what is narrower and lower than so many pixels. 0, the default, culls nothing
   * for its size.
   */
  float detail_pixels;
  /**
   * Lossy: draw levels of detail that are off by at most so many pixels, in scenes that have
   * levels. 0, the default, draws everything in full.
   */
  float lod_pixels;
  /**
   * A `cullet_output`.
   */
  uint32_t output;
  /**
   * Record why each instance was culled, for `cullet_visible_reasons`: two bytes a slot. 0 by
   * default.
   */
  uint32_t reasons;
  /**
   * Lossy: a budget for levels of detail. Where more triangles than this would be drawn, the
   * pixels of `lod_pixels` are raised until they are not, as far as there are levels;
   * `cullet_visible_lod` says to how many. Triangles are counted before occlusion culling, and
   * those without levels in full. 0, the default, for no budget.
   */
  uint32_t lod_triangles;
} cullet_settings;

/**
 * Threads of yours that run jobs: your pool.
 */
typedef struct {
  /**
   * How many jobs run side by side, the calling thread included; at least 1.
   */
  uint32_t threads;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Calls `job(jobs, 0)`, `job(jobs, 1)` and so on below `count`, each once, in any order and on
   * any threads, and returns when all have returned. What it leaves out runs on the calling
   * thread afterwards; a job that it calls twice runs once.
   */
  void (*run)(void *context, void (*job)(void *jobs, size_t number), void *jobs, size_t count);
  /**
   * Handed to `run`.
   */
  void *context;
} cullet_jobs;

/**
 * Why an instance was culled.
 */
typedef struct {
  /**
   * The stage, a `cullet_stage`; 0 for one that is visible.
   */
  uint8_t stage;
  /**
   * For the frustum the number of the plane that it is outside of; 255 where parts went for
   * different ones.
   */
  uint8_t detail;
} cullet_reason;

/**
 * An instance to add: a mesh with a transform.
 */
typedef struct {
  /**
   * Where it is.
   */
  cullet_transform transform;
  /**
   * Number of its mesh.
   */
  uint32_t mesh;
  /**
   * Bits of the layers that it is in; a view sees it where they share a bit. 0 is in none, so
   * never drawn.
   */
  uint32_t layers;
  /**
   * `CULLET_ALWAYS_VISIBLE` and so on.
   */
  uint32_t flags;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * A number of the caller's, such as an entity or an index; `cullet_visible_users` gives it
   * back.
   */
  uint64_t user;
} cullet_instance;

/**
 * Levels of detail of a mesh: one chain of whole meshes, or one hierarchy of clusters.
 */
typedef struct {
  /**
   * The mesh of the scene that holds the triangles of all its levels: draws name it, and
   * `cullet_scene_mesh_read` reads what to upload.
   */
  uint32_t mesh;
  /**
   * Steps of simplification: of a chain its levels.
   */
  uint32_t group_count;
  /**
   * Triangles of all levels together.
   */
  uint64_t triangle_count;
  /**
   * The least distance from the original surface of a step, in units of the mesh.
   */
  float least_error;
  /**
   * The largest.
   */
  float most_error;
} cullet_levels;

/**
 * A range of a mesh's triangles with one material.
 */
typedef struct {
  /**
   * First triangle of the range.
   */
  uint32_t first_triangle;
  /**
   * How many triangles.
   */
  uint32_t triangle_count;
  /**
   * A number of the caller's for the material; draws are sorted by it.
   */
  uint32_t material;
  /**
   * `CULLET_ONE_SIDED`, `CULLET_MASKED`, `CULLET_BLENDED`.
   */
  uint32_t flags;
} cullet_part;

/**
 * A mesh to add: its arrays are copied. A struct of zeros with positions and indices is a mesh of
 * one opaque, two-sided part.
 */
typedef struct {
  /**
   * Vertices: three floats each, `3 * position_count` in all, finite.
   */
  const float *positions;
  /**
   * How many vertices.
   */
  size_t position_count;
  /**
   * Three a triangle, each below `position_count`.
   */
  const uint32_t *indices;
  /**
   * How many indices: a multiple of three.
   */
  size_t index_count;
  /**
   * Ranges of triangles, in order and without a gap; NULL for one part of all.
   */
  const cullet_part *parts;
  /**
   * How many parts; 0 for one part of all.
   */
  size_t part_count;
  /**
   * `CULLET_DEFORMABLE`; without parts also what a part's flags say.
   */
  uint32_t flags;
  /**
   * Material of the mesh where it has no parts.
   */
  uint32_t material;
} cullet_mesh_arrays;

/**
 * How large a mesh of a scene is.
 */
typedef struct {
  /**
   * Vertices.
   */
  size_t position_count;
  /**
   * Indices: three a triangle, degenerate triangles included.
   */
  size_t index_count;
  /**
   * Parts.
   */
  size_t part_count;
  /**
   * Clusters: what culling finer than instances takes as a whole.
   */
  size_t cluster_count;
  /**
   * The lowest corner of its box.
   */
  float min[3];
  /**
   * The highest corner of its box.
   */
  float max[3];
} cullet_mesh_info;

/**
 * A box: its lowest and its highest corner.
 */
typedef struct {
  /**
   * The lowest corner.
   */
  float min[3];
  /**
   * The highest corner.
   */
  float max[3];
} cullet_box;

/**
 * Contents of visible sets.
 */
typedef struct {
  /**
   * Cells that there is a set of.
   */
  uint32_t cell_count;
  /**
   * Items that the sets may hold: cells, or instances.
   */
  uint32_t target_count;
  /**
   * A `cullet_pvs_targets`.
   */
  uint32_t targets;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Rays that were traced for them; 0 for sets of cells.
   */
  uint64_t rays;
  /**
   * Share of looks that are estimated to end on something that its set lacks, 0 to 1: the mean
   * over the cells. 0 for sets of cells, which lack nothing.
   */
  double mean_missing;
  /**
   * The same of the cell where it is largest.
   */
  double most_missing;
} cullet_pvs_info;

/**
 * Two points in world space: from where one looks, and what is looked at.
 */
typedef struct {
  /**
   * The start.
   */
  double from[3];
  /**
   * The end.
   */
  double to[3];
} cullet_segment;

/**
 * Settings of lines of sight. Set them to zero before their fields.
 */
typedef struct {
  /**
   * Layers that do not block, as bits; an instance that is in others too does.
   */
  uint32_t ignored_layers;
  /**
   * 1 where both sides of one-sided triangles block; 0 for the side that is drawn.
   */
  uint32_t both_sides;
  /**
   * 1 for any blocker, which ends the search as soon as there is one; 0 for the nearest.
   */
  uint32_t any;
  /**
   * How many of `ignored` are there, up to 2.
   */
  uint32_t ignored_count;
  /**
   * Instances that do not block, such as who looks and who is looked at. One that names nothing
   * is no error.
   */
  cullet_handle ignored[2];
} cullet_sight_options;

/**
 * Result for one line of sight.
 */
typedef struct {
  /**
   * 1 where something opaque blocks; 0 where nothing is known to, and then all else is 0.
   */
  uint32_t blocked;
  /**
   * Slot of the blocker.
   */
  uint32_t slot;
  /**
   * Handle of the blocker.
   */
  cullet_handle handle;
  /**
   * Triangle of the blocker, as numbered in the mesh that was added.
   */
  uint32_t triangle;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * How far along the way it is crossed, from 0 at the start to 1 at the end.
   */
  double share;
  /**
   * Where, in world space.
   */
  double point[3];
} cullet_sight;

/**
 * Settings of `cullet_box_to_box`. Set them to zero before their fields.
 */
typedef struct {
  /**
   * Layers that hide nothing, as bits; an instance that is in others too does.
   */
  uint32_t ignored_layers;
  /**
   * How often boxes may be halved, 0 to 16, to find a proof for each half: several occluders may
   * hide together what none hides alone.
   */
  uint32_t splits;
  /**
   * 0.
   */
  uint32_t reserved;
} cullet_box_sight_options;

/**
 * Handle of a region query: its memory, and its last result. A plain number: copy it freely; 0 is
 * none.
 */
typedef struct {
  /**
   * Not to be read or made.
   */
  uint64_t id;
} cullet_region;

/**
 * Settings of region queries. Set them to zero before their fields: 0 takes the default of each.
 */
typedef struct {
  /**
   * Longest side of the cells that the box is cut into, in world units; default 2. Occluders lose
   * half of it on every side. A smaller one drops more, and costs with its third power.
   */
  double cell_world;
  /**
   * The farthest that a point of a view's near rectangle is from its eye; default 0.25.
   */
  double near_world;
  /**
   * No more cells than this; default 64. Cost is in proportion.
   */
  uint32_t most_cells;
  /**
   * Pixels across each of the six squares that are looked at, 8 to 4096; default 512.
   */
  uint32_t width;
  /**
   * No more occluders than this; default 2048.
   */
  uint32_t most_bodies;
  /**
   * Layers that the eyes do not see, as bits. Not read where there is a view, which has its own.
   */
  uint32_t ignored_layers;
  /**
   * 0.
   */
  uint32_t reserved;
} cullet_region_settings;

/**
 * Numbers of instances, of their clusters and of their triangles.
 */
typedef struct {
  /**
   * Instances.
   */
  uint64_t instances;
  /**
   * Clusters.
   */
  uint64_t clusters;
  /**
   * Triangles.
   */
  uint64_t triangles;
} cullet_counts;

/**
 * Counts of one stage at one unit; what leaves a row enters the next.
 */
typedef struct {
  /**
   * A `cullet_stage`.
   */
  uint32_t stage;
  /**
   * Unit that it tested: 0 instances, 1 clusters, 2 triangles.
   */
  uint32_t unit;
  /**
   * Counts in.
   */
  cullet_counts entered;
  /**
   * Counts out.
   */
  cullet_counts left;
} cullet_funnel_row;

/**
 * Where the renderer's buffers hold a mesh.
 */
typedef struct {
  /**
   * Where its indices begin.
   */
  uint32_t first_index;
  /**
   * Where its vertices begin.
   */
  int32_t base_vertex;
} cullet_mesh_place;

/**
 * One indexed indirect draw, as Vulkan, Direct3D 12, Metal and WebGPU read it: 20 bytes.
 */
typedef struct {
  /**
   * How many indices.
   */
  uint32_t index_count;
  /**
   * How many instances.
   */
  uint32_t instance_count;
  /**
   * First index, in the order of `cullet_scene_mesh_read`, plus the place of the mesh.
   */
  uint32_t first_index;
  /**
   * Added to each index.
   */
  int32_t base_vertex;
  /**
   * First entry of `instances`.
   */
  uint32_t first_instance;
} cullet_draw_command;

/**
 * Properties of a draw command: the same for all its instances.
 */
typedef struct {
  /**
   * `CULLET_DRAW_TWO_SIDED` and so on.
   */
  uint32_t state;
  /**
   * The material.
   */
  uint32_t material;
  /**
   * The mesh.
   */
  uint32_t mesh;
  /**
   * The part of the mesh.
   */
  uint32_t part;
  /**
   * The level of detail.
   */
  uint32_t level;
} cullet_draw_key;

/**
 * Arrays that draws are written into. Capacities go in, counts come out.
 */
typedef struct {
  /**
   * Room for commands, sorted by key: opaque ones first, then by material and mesh.
   */
  cullet_draw_command *commands;
  /**
   * Room for as many keys: one for each command.
   */
  cullet_draw_key *keys;
  /**
   * How many commands and keys there is room for.
   */
  size_t command_capacity;
  /**
   * How many there are.
   */
  size_t command_count;
  /**
   * Room for slots: the instances of each command are a range of them.
   */
  uint32_t *instances;
  /**
   * How many slots there is room for.
   */
  size_t instance_capacity;
  /**
   * How many there are.
   */
  size_t instance_count;
  /**
   * Room for indices, where the output is triangles; else not used.
   */
  uint32_t *indices;
  /**
   * How many indices there is room for.
   */
  size_t index_capacity;
  /**
   * How many there are; 0 where the output is not triangles.
   */
  size_t index_count;
} cullet_draws;

/**
 * Contents of a scene.
 */
typedef struct {
  /**
   * Instances.
   */
  uint32_t instance_count;
  /**
   * Slots, empty ones included: how long an array by slot must be.
   */
  uint32_t slot_count;
  /**
   * Meshes.
   */
  uint32_t mesh_count;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Triangles of all instances.
   */
  uint64_t triangle_count;
  /**
   * Rises whenever a commit put instances into other slots.
   */
  uint64_t order_version;
  /**
   * The point that boxes in world space are relative to: zero, but for files far from it.
   */
  double origin[3];
  /**
   * The lowest corner of the box around all instances, relative to `origin`; above `max` for
   * none.
   */
  float min[3];
  /**
   * The highest corner.
   */
  float max[3];
} cullet_scene_info;

/**
 * A light that casts shadows, in world space. Numbers that make no light keep every caster.
 */
typedef struct {
  /**
   * A `cullet_light_kind`.
   */
  uint32_t kind;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Where it is; not read for a directional light.
   */
  double position[3];
  /**
   * The way the light travels, of any length above 0; not read for a point light.
   */
  double direction[3];
  /**
   * How far it reaches, in world units: `INFINITY` for no limit; one that is not above 0 lights
   * nothing. Not read for a directional light.
   */
  double range;
  /**
   * Spot: the angle between the axis and the side of the cone, in radians.
   */
  double half_angle;
} cullet_light;

/**
 * The shadows of a light that are wanted. Set it to zero before its fields.
 */
typedef struct {
  /**
   * The light.
   */
  cullet_light light;
  /**
   * The view that the shadow map is drawn with; NULL where it is not known yet. With one, what is
   * outside of it or hidden in it is dropped too, and layers, faces and sizes are those of it.
   */
  const cullet_view *map;
  /**
   * The state of the camera's own cull of the scene as it is: then only what casts a shadow on
   * what that found visible is kept. 0 for shadows on any place that the camera shows.
   */
  cullet_state receivers;
  /**
   * Shadows may be wrong by so much to every side, in world units, for blurred edges; at least 0.
   */
  double margin;
  /**
   * A cascade of the camera, by distance along its direction: where it begins. Both 0 for all of
   * what the camera sees.
   */
  double slice_near;
  /**
   * Where the cascade ends; INFINITY in perspective for no end.
   */
  double slice_far;
} cullet_shadow;

/**
 * A camera. Right-handed, looking along `direction`.
 */
typedef struct {
  /**
   * Where it stands.
   */
  double eye[3];
  /**
   * Where it looks; of any length above 0.
   */
  double direction[3];
  /**
   * Up; not along `direction`.
   */
  double up[3];
  /**
   * Perspective: the full vertical field of view in radians, above 0 and below pi. 0 for an
   * orthographic camera.
   */
  double fov_y;
  /**
   * Orthographic: height of what it sees, in units of the scene. Not read in perspective.
   */
  double height;
  /**
   * Width over height of what it sees; 0 takes that of the viewport.
   */
  double aspect;
  /**
   * Distance of the near plane: above 0 in perspective.
   */
  double near_plane;
  /**
   * Distance of the far plane, beyond the near one; INFINITY in perspective for none.
   */
  double far_plane;
} cullet_camera;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Makes the library take all its memory from functions of yours, which are copied, in place of the
 * system's allocator. Call it before all other functions, once: it is refused with
 * `CULLET_STATUS_TOO_LATE`, and nothing changes, where the library has allocated already. Calls that
 * allocate nothing, such as `cullet_version` or this one when it is refused, may come before. The
 * choice is the whole process's, also for other parts of it that use the same library, and holds to
 * its end: a thread that ends, the main thread too, frees its last error message. `alloc` and `free`
 * must be there. Stacks of threads, files that are mapped, and what the system's own functions
 * allocate are not asked for. Cost: with and without it, each allocation costs a load more; with it
 * also an indirect call. Culling allocates nothing.
 */
cullet_status cullet_set_allocator(const cullet_allocator *allocator);

/**
 * Bakes occluders of every mesh, boxes and polygons that hide no more than the mesh does, and gives
 * them to meshes as `cullet_scene_take_occluders` does; `always` and `given` are those of it. Meshes
 * that deform have none. `cullet_scene_save` keeps them. `options` may be NULL; a unit is a mesh.
 * The same on every run and machine. Needs the scene alone. Cost: up to seconds a mesh.
 */
cullet_status cullet_bake_occluders(cullet_scene scene,
                                    uint32_t always,
                                    const cullet_bake_options *options,
                                    uint32_t *given);

/**
 * Bakes levels of detail of every mesh: the whole mesh again and again, each time with fewer
 * triangles and a measured error. They replace the levels that a mesh has, from whatever source,
 * and are held by meshes of their own, with new numbers: `cullet_scene_levels` lists them. Meshes
 * that deform, or that cannot be simplified, have none. `count` takes how many meshes have some,
 * unless it is NULL. `cullet_scene_save` keeps them. `options` may be NULL; a unit is a mesh. The
 * same on every run and machine. Needs the scene alone; commit it afterwards. Cost: seconds for
 * meshes of a hundred thousand triangles.
 */
cullet_status cullet_bake_levels(cullet_scene scene,
                                 const cullet_bake_options *options,
                                 uint32_t *count);

/**
 * Bakes visible sets of a scene, as `cullet pvs` does, with the same bytes; `cullet_pvs_write`
 * writes them, and `cullet_scene_set_pvs` culls by them. A scene with cells of its own and
 * settings that ask for no view cells gets sets of those: conservative. Otherwise it gets sets of
 * instances, seen from view cells and found by rays: something may be missing, and
 * `cullet_pvs_info.mean_missing` says how much is likely to be. `settings` and `options` may be
 * NULL. The same on every run and machine, for any threads, shares and stops. Reads the scene,
 * which must stay as it is. Cost: seconds to hours, in proportion to `rays`.
 */
cullet_status cullet_bake_pvs(cullet_scene scene,
                              const cullet_pvs_settings *settings,
                              const cullet_bake_options *options,
                              cullet_pvs *pvs);

/**
 * Finds the rooms of a scene and the openings between them, in its triangles, and gives the scene
 * these cells in place of its own: `cullet_cull` culls by them at once, and `cullet_bake_pvs` bakes
 * sets of them. Conservative: walls are closed, opaque meshes, which must stay where they are.
 * `count` takes how many cells there are, unless it is NULL; the first is the outside. `settings`
 * and `options` may be NULL; the work has five steps and no units, so that `options->folder` must
 * be NULL. Refused with `CULLET_STATUS_INVALID_VALUE` where nothing is closed, all is one cell, or
 * there are too many voxels; the message says what to try. `cullet_scene_save` keeps them in a GLB.
 * Needs the scene alone. Cost: linear in the voxels, and in the triangles by the voxels that they
 * touch.
 */
cullet_status cullet_bake_cells(cullet_scene scene,
                                const cullet_cells_settings *settings,
                                const cullet_bake_options *options,
                                uint32_t *count);

/**
 * Makes an empty set of boxes, to be culled over your own arrays: `cullet_boxes_set` takes the
 * boxes, `cullet_boxes_set_occluders` what hides them, `cullet_boxes_cull` a view.
 * `occlusion_width` is how many pixels the occlusion buffer has across, up to 4096 and at most the
 * viewport's width; 0 takes 640. Destroy the set with `cullet_boxes_destroy`.
 */
cullet_status cullet_boxes_create(uint32_t occlusion_width, cullet_boxes *boxes);

/**
 * Destroys a set of boxes; its handle is stale from then on.
 */
cullet_status cullet_boxes_destroy(cullet_boxes boxes);

/**
 * Replaces all boxes of a set by those of your arrays, which are copied. A box with a NaN or an
 * infinite number is always visible; one whose lowest corner is above its highest, or whose half
 * size is negative, is empty and never visible. Rounding only ever grows a box. Allocates nothing
 * once the set has held as many. Cost: linear in the boxes; several times that of a cull without
 * occluders, so use `cullet_boxes_update` where few have moved.
 */
cullet_status cullet_boxes_set(cullet_boxes boxes, const cullet_box_arrays *arrays);

/**
 * Replaces boxes `first`, `first` + 1 and so on of a set, as many as the arrays have: those that
 * moved. Otherwise as `cullet_boxes_set`. Cost: linear in the boxes that are replaced.
 */
cullet_status cullet_boxes_update(cullet_boxes boxes,
                                  size_t first,
                                  const cullet_box_arrays *arrays);

/**
 * Culls a set of boxes for a view, and writes a flag for each: 1 where the box may be visible, 0
 * where it is proved to be outside the view or behind occluders. `capacity` must be at least the
 * number of boxes. `visible` takes how many flags are 1, unless it is NULL. Layers and faces of the
 * view play no part. Allocates nothing once the set has been culled with a view as large. Cost: the
 * frustum test of all boxes, some nanoseconds each; then, with occluders, drawing those and testing
 * what is left. Needs the set alone: for views side by side, make a set for each thread.
 */
cullet_status cullet_boxes_cull(cullet_boxes boxes,
                                const cullet_view *view,
                                uint8_t *flags,
                                size_t capacity,
                                size_t *visible);

/**
 * Culls as `cullet_boxes_cull` does, and writes bits: bit i mod 64 of word i / 64 is the flag of
 * box i; bits beyond the last box are 0. `capacity`, in words, must be at least a 64th of the
 * number of boxes, rounded up.
 */
cullet_status cullet_boxes_cull_bits(cullet_boxes boxes,
                                     const cullet_view *view,
                                     uint64_t *words,
                                     size_t capacity,
                                     size_t *visible);

/**
 * Replaces the occluders of a set: they have the numbers 0, 1, 2, ... in this order. All or none:
 * where one is refused, the message names it and the set keeps those that it had. Their space is
 * the world's, by `transform`. What hides must be opaque, and stand where you draw it. Allocates;
 * `cullet_boxes_move_occluder` and `cullet_boxes_set_occluder` are for every frame.
 */
cullet_status cullet_boxes_set_occluders(cullet_boxes boxes,
                                         const cullet_occluder *occluders,
                                         size_t count);

/**
 * Replaces one occluder of a set, such as triangles that deform. Triangles in the place of
 * triangles allocate nothing once as many were there, and are quickest where the indices are the
 * same as before. What is refused changes nothing, but for triangles in the place of triangles:
 * then the occluder hides nothing until it is set again.
 */
cullet_status cullet_boxes_set_occluder(cullet_boxes boxes,
                                        uint32_t number,
                                        const cullet_occluder *occluder);

/**
 * Moves one occluder of a set; NULL for the identity. Allocates nothing.
 */
cullet_status cullet_boxes_move_occluder(cullet_boxes boxes,
                                         uint32_t number,
                                         const cullet_transform *transform);

/**
 * Empties a buffer for triangles in clip space, whose near plane is at `near_w`; below 0.001 it is
 * there. Boxes are not to be tested until the next `cullet_occlusion_begin`.
 */
cullet_status cullet_clip_begin(cullet_occlusion buffer, float near_w);

/**
 * Draws triangles in clip space as occluders, and writes a `cullet_found` into `result`, unless
 * that is NULL: outside where none of them can be seen, else visible. Needs `cullet_clip_begin`.
 * How a set of triangles is drawn is worked out once and kept by where its indices lie, for as
 * long as it is drawn every now and then.
 */
cullet_status cullet_clip_draw(cullet_occlusion buffer,
                               const cullet_clip_triangles *triangles,
                               uint32_t *result);

/**
 * Tests a rectangle of the screen, in normalised device coordinates with y upward, as near as
 * `least_w`, and writes a `cullet_found`. Hidden is proved for all of it. Visible where a number
 * is NaN, and this side of the near plane.
 */
cullet_status cullet_clip_test_rect(cullet_occlusion buffer,
                                    float x_min,
                                    float y_min,
                                    float x_max,
                                    float y_max,
                                    float least_w,
                                    uint32_t *result);

/**
 * Tests triangles in clip space, and writes a `cullet_found`: hidden where each that may be seen
 * is proved to be. Each is tested by its rectangle and its nearest corner, so that large slanted
 * ones are found less.
 */
cullet_status cullet_clip_test_triangles(cullet_occlusion buffer,
                                         const cullet_clip_triangles *triangles,
                                         uint32_t *result);

/**
 * Makes the state of a view. Destroy it with `cullet_state_destroy`.
 */
cullet_status cullet_state_create(cullet_state *state);

/**
 * Destroys the state of a view; its handle is stale from then on.
 */
cullet_status cullet_state_destroy(cullet_state state);

/**
 * Culls a scene for a view; `cullet_visible_slots` and its like read the result. `settings` may be
 * NULL for `CULLET_PRESET_BALANCED`. Conservative: what the view sees is never culled, but for
 * lossy settings. The answer depends on scene, view and settings alone; `state` makes the next
 * frame faster, and keeps the answer where none of the three has changed. Allocates nothing once
 * the state has grown to what the scene needs, and starts no thread. Other threads may cull the
 * same scene meanwhile, each with a state of its own.
 */
cullet_status cullet_cull(cullet_scene scene,
                          const cullet_view *view,
                          const cullet_settings *settings,
                          cullet_state state);

/**
 * Culls as `cullet_cull` does, among candidates: instances that may be visible for all that you
 * know, by fog of war, streaming or what an editor isolates. Bit s mod 64 of word s / 64 is that of
 * slot s; there must be as many words as the scene's `slot_count` needs. All others are culled
 * after the frustum, by `CULLET_STAGE_PVS`; instances that are always visible stay. The words are
 * not kept, and so is no answer: each call culls. Cells of the scene play no part.
 */
cullet_status cullet_cull_among(cullet_scene scene,
                                const cullet_view *view,
                                const cullet_settings *settings,
                                const uint64_t *words,
                                size_t word_count,
                                cullet_state state);

/**
 * Culls once for both eyes of a headset: what either eye sees stays, and what is hidden from both
 * goes. Perspective views of the same viewport, depth and layers, turned against each other by less
 * than a right angle. Back faces are culled by whole clusters alone, and cells cull nothing. Cost:
 * little more than that of one view. Otherwise as `cullet_cull`.
 */
cullet_status cullet_cull_stereo(cullet_scene scene,
                                 const cullet_view *left,
                                 const cullet_view *right,
                                 const cullet_settings *settings,
                                 cullet_state state);

/**
 * Writes which eye may see each slot of `cullet_visible_slots`, a byte each in that order: bit 0
 * for `left`, bit 1 for `right`, at least one of them. The views are those of
 * `cullet_cull_stereo`; `capacity` and `count` as for `cullet_visible_slots`. The scene must be as
 * it was culled.
 */
cullet_status cullet_visible_eyes(cullet_state state,
                                  cullet_scene scene,
                                  const cullet_view *left,
                                  const cullet_view *right,
                                  uint8_t *eyes,
                                  size_t capacity,
                                  size_t *count);

/**
 * Culls as `cullet_cull` does, with the same answer, on threads of yours: `jobs->run` is called,
 * from this thread, some times in a call that has enough to do for several, and not at all in
 * others. It must not use `state`. Occlusion alone is split into jobs; to cull several views at
 * once, calls of `cullet_cull` side by side do better. A scene with cells is culled on the calling
 * thread. `state` is larger by a few hundred kilobytes for each thread.
 */
cullet_status cullet_cull_on(const cullet_jobs *jobs,
                             cullet_scene scene,
                             const cullet_view *view,
                             const cullet_settings *settings,
                             cullet_state state);

/**
 * Replays the stages for one instance, and writes why it is drawn or culled: its reason (stage 0
 * for an instance that is drawn) unless `reason` is NULL; and a line for each stage into `text`,
 * UTF-8 with a 0 at its end, cut off where `capacity` bytes are too few. `length` takes the bytes
 * that all of it needs, the 0 included, unless it is NULL. `settings` may be NULL as in
 * `cullet_cull`. For tools: it may cull the whole scene, and allocates.
 */
cullet_status cullet_explain(cullet_scene scene,
                             const cullet_view *view,
                             const cullet_settings *settings,
                             cullet_handle handle,
                             cullet_reason *reason,
                             char *text,
                             size_t capacity,
                             size_t *length);

/**
 * Opens a file as a scene: glTF and GLB, with what `cullet bake` wrote into them, OBJ, PLY, STL,
 * OFF, maps of Quake with the visible sets that are in them; and 3D Tiles, in libraries that are
 * built with `tiles`. The path is UTF-8. The scene is committed; instances have the handles 0, 1, 2,
 * ... of generation 0 in the order of the file. Reading takes at most three times the memory of the
 * geometry. The message of a failure names the file, the item and what would be right.
 */
cullet_status cullet_open(const char *path,
                          cullet_scene *scene);

/**
 * Adds instances, and writes a handle for each into `handles`, unless that is NULL. All or none:
 * if one has no mesh or an unknown flag, nothing is added. Commit before culling where many were
 * added.
 */
cullet_status cullet_scene_add(cullet_scene scene,
                               const cullet_instance *instances,
                               size_t count,
                               cullet_handle *handles);

/**
 * Removes instances; their handles are stale from then on. All or none, but that a handle which is
 * there twice is an error after the first was removed.
 */
cullet_status cullet_scene_remove(cullet_scene scene, const cullet_handle *handles, size_t count);

/**
 * Moves instances: `transforms` has one for each of `handles`. All or none. Cull on as it is: the
 * answer is right at once, and `cullet_scene_refit` after a frame's moves makes it faster.
 */
cullet_status cullet_scene_set_transforms(cullet_scene scene,
                                          const cullet_handle *handles,
                                          const cullet_transform *transforms,
                                          size_t count);

/**
 * Sets the layers of instances: `layers` has a mask for each of `handles`. All or none.
 */
cullet_status cullet_scene_set_layers(cullet_scene scene,
                                      const cullet_handle *handles,
                                      const uint32_t *layers,
                                      size_t count);

/**
 * Sets the flags of instances: `values` has some for each of `handles`. All or none.
 */
cullet_status cullet_scene_set_flags(cullet_scene scene,
                                     const cullet_handle *handles,
                                     const uint32_t *values,
                                     size_t count);

/**
 * Gives an instance bounds of the caller's. `kind` is a `cullet_bounds`; `numbers` has six floats
 * for `CULLET_BOUNDS_WORLD`, the lowest and the highest corner relative to the scene's origin, one
 * for `CULLET_BOUNDS_MARGIN`, from 0, and is not read for the others. A box that is not finite
 * keeps its instance visible.
 */
cullet_status cullet_scene_set_bounds(cullet_scene scene,
                                      cullet_handle handle,
                                      uint32_t kind,
                                      const float *numbers);

/**
 * Writes the slot of an instance: the index of arrays by slot, until the next commit.
 */
cullet_status cullet_scene_slot(cullet_scene scene, cullet_handle handle, uint32_t *slot);

/**
 * Writes the instance of a slot, as draws name it: its mesh, transform, layers, flags and number;
 * and its handle into `handle`, unless that is NULL. `CULLET_STATUS_NOT_FOUND` for an empty slot
 * and one beyond the last.
 */
cullet_status cullet_scene_instance(cullet_scene scene,
                                    uint32_t slot,
                                    cullet_instance *instance,
                                    cullet_handle *handle);

/**
 * Writes the levels that a mesh of a scene has: from its file, by `cullet_scene_add_lod`, or baked.
 * The first is number 1 in `cullet_draw_key.level`; 0 is the mesh itself. `capacity` and `count` as
 * for `cullet_visible_slots`; most meshes have at most two. `cullet_settings.lod_pixels` and
 * `.lod_triangles` choose among them in each cull. Reads the scene.
 */
cullet_status cullet_scene_levels(cullet_scene scene,
                                  uint32_t mesh,
                                  cullet_levels *levels,
                                  size_t capacity,
                                  size_t *count);

/**
 * Gives a mesh a coarser one to be drawn in its place where the eye is far enough: another mesh of
 * the scene, in the same space, with the same parts and materials. No point of it may be farther
 * than `error` from the surface of `mesh`, in units of the mesh, nor the other way round; at least
 * 0 and finite. Call it once for each level, in any order. Refused with `CULLET_STATUS_MESH` where
 * `coarse` has triangles without area. Commit the scene before culling.
 */
cullet_status cullet_scene_add_lod(cullet_scene scene, uint32_t mesh, uint32_t coarse, float error);

/**
 * Takes all levels of a mesh away. Meshes that held them stay in the scene.
 */
cullet_status cullet_scene_clear_levels(cullet_scene scene, uint32_t mesh);

/**
 * Writes by how many pixels the surfaces of the last result may be off: `cullet_settings.lod_pixels`,
 * or what the budget of triangles raised it to; 0 where no levels were chosen.
 */
cullet_status cullet_visible_lod(cullet_state state,
                                 double *pixels);

/**
 * Adds a mesh that instances may share, and writes its number, from 0 on. Cost: linear in its
 * triangles; what culling needs of it is made by the next `cullet_scene_commit`. Refused with
 * `CULLET_STATUS_MESH` where an index is beyond the vertices, a position is not finite, or the
 * parts do not cover the triangles in order.
 */
cullet_status cullet_scene_add_mesh(cullet_scene scene,
                                    const cullet_mesh_arrays *arrays,
                                    uint32_t *mesh);

/**
 * Writes how large a mesh of a scene is.
 */
cullet_status cullet_scene_mesh_info(cullet_scene scene, uint32_t mesh, cullet_mesh_info *info);

/**
 * Writes the geometry of a mesh as draws count it: its triangles are put into the order of
 * clusters once, when it is added, and `first_index` of a draw is of that order. Upload these
 * indices. `positions` takes three floats a vertex; the capacities are in floats and in indices.
 * Either array may be NULL with a capacity of 0: then it is left out.
 */
cullet_status cullet_scene_mesh_read(cullet_scene scene,
                                     uint32_t mesh,
                                     float *positions,
                                     size_t position_capacity,
                                     uint32_t *indices,
                                     size_t index_capacity);

/**
 * Gives meshes the occluders that were baked of them and that the scene's file brought; each mesh
 * is its own occluder otherwise. With `always` 0 a mesh takes them only where they hide nearly all
 * that it hides itself and cost less than half as much to draw; with 1 wherever there are some,
 * which `cullet_box_to_box` and `cullet_region_cull` may need: boxes and polygons hide there, and
 * walls that are sheets do not. `given` takes how many meshes took some, unless it is NULL. Call it
 * after a commit. Cost: linear in the triangles of meshes that are new.
 */
cullet_status cullet_scene_take_occluders(cullet_scene scene, uint32_t always, uint32_t *given);

/**
 * Makes an occlusion buffer of so many pixels, 1 to 4096 each way; a quarter or half of the
 * screen's width finds nearly as much as all of it, and is never wrong. Destroy it with
 * `cullet_occlusion_destroy`.
 */
cullet_status cullet_occlusion_create(uint32_t width, uint32_t height, cullet_occlusion *buffer);

/**
 * Destroys an occlusion buffer; its handle is stale from then on.
 */
cullet_status cullet_occlusion_destroy(cullet_occlusion buffer);

/**
 * Empties a buffer and turns it to a view. Boxes that are tested later are relative to `origin`,
 * three doubles; NULL for zero.
 */
cullet_status cullet_occlusion_begin(cullet_occlusion buffer,
                                     const cullet_view *view,
                                     const double *origin);

/**
 * Draws boxes that hide: each must lie within what is opaque. `transform` stands for all of them;
 * NULL for none. Draw near ones first. Allocates a few hundred bytes a box. Boxes that are empty
 * or not finite are refused, and none is drawn.
 */
cullet_status cullet_occlusion_draw_boxes(cullet_occlusion buffer,
                                          const cullet_box *boxes,
                                          size_t count,
                                          const cullet_transform *transform);

/**
 * Draws triangles that hide, nearest first, without those that are hidden by then: `positions` has
 * three finite floats a vertex, `indices` three a triangle. `two_sided` is 1 for triangles that
 * hide from both sides, 0 where only their fronts do, which are counter-clockwise. Vertices are
 * one where they have one index: pixels across shared edges count as covered. Allocates nothing
 * once the buffer has seen as many triangles, and is quickest where the indices are those of the
 * last call.
 */
cullet_status cullet_occlusion_draw_triangles(cullet_occlusion buffer,
                                              const float *positions,
                                              size_t position_count,
                                              const uint32_t *indices,
                                              size_t index_count,
                                              uint32_t two_sided,
                                              const cullet_transform *transform);

/**
 * Tests boxes, relative to the origin of the view, and writes a `cullet_found` for each, one byte.
 * Hidden is proved, at every resolution. Boxes that are not finite or cross the near plane are
 * visible; empty ones are outside. Allocates nothing once as many were tested.
 */
cullet_status cullet_occlusion_test_boxes(cullet_occlusion buffer,
                                          const cullet_box *boxes,
                                          size_t count,
                                          uint8_t *results);

/**
 * Writes the nearness that covers all of each pixel, row by row from the top left: 1 / w in
 * perspective, 0 where nothing is proved. `capacity` must be at least width times height.
 */
cullet_status cullet_occlusion_read(cullet_occlusion buffer, float *nearness, size_t capacity);

/**
 * Opens a file of visible sets, as `cullet pvs` and `cullet_pvs_write` make them. The path is
 * UTF-8. Refused with `CULLET_STATUS_FILE` where it cannot be read, is cut short or was changed; the
 * message names the file. Destroy them with `cullet_pvs_destroy`. Cost: linear in the file.
 */
cullet_status cullet_pvs_open(const char *path,
                              cullet_pvs *pvs);

/**
 * Makes visible sets of the bytes of such a file, for programs with files of their own; they are
 * copied. Otherwise as `cullet_pvs_open`.
 */
cullet_status cullet_pvs_read(const uint8_t *bytes, size_t size, cullet_pvs *pvs);

/**
 * Writes visible sets as the bytes of a file, which `cullet_pvs_open`, `cullet_pvs_read` and the
 * program `cullet` read. `capacity` and `count`, in bytes, as for `cullet_visible_slots`.
 */
cullet_status cullet_pvs_write(cullet_pvs pvs, uint8_t *bytes, size_t capacity, size_t *count);

/**
 * Destroys visible sets; their handle is stale from then on. Scenes that were given them keep them.
 */
cullet_status cullet_pvs_destroy(cullet_pvs pvs);

/**
 * Writes the contents of visible sets.
 */
cullet_status cullet_pvs_get_info(cullet_pvs pvs, cullet_pvs_info *info);

/**
 * Writes the view cells, in the order of their numbers, in world space; `CULLET_STATUS_NOT_FOUND`
 * for sets of a scene's own cells. `capacity` and `count` as for `cullet_visible_slots`.
 */
cullet_status cullet_pvs_cells(cullet_pvs pvs,
                               cullet_eye_box *boxes,
                               size_t capacity,
                               size_t *count);

/**
 * Writes for each view cell the share of looks from it that are estimated to end on something that
 * its set lacks, 0 to 1. Otherwise as `cullet_pvs_cells`.
 */
cullet_status cullet_pvs_missing(cullet_pvs pvs, float *shares, size_t capacity, size_t *count);

/**
 * Writes the view cell of each point, three doubles in world space; `UINT32_MAX` where it is in
 * none, or not finite. Of several that touch there, it is the lowest. `CULLET_STATUS_NOT_FOUND` for
 * sets of a scene's own cells: ask `cullet_scene_cell_of`. Cost: that of a tree of the cells for
 * each point; allocates nothing.
 */
cullet_status cullet_pvs_cell_of(cullet_pvs pvs,
                                 const double *points,
                                 size_t count,
                                 uint32_t *cells);

/**
 * Writes all that may be seen from any of some cells, ascending: the `index` of each handle, or
 * numbers of cells, as `cullet_pvs_info.targets` says. For streaming and for your own culling;
 * instances that were added since the bake are in no set. `CULLET_STATUS_NOT_FOUND` where there is
 * no such cell. `capacity` and `count` as for `cullet_visible_slots`. Cost: linear in the targets,
 * for each cell; allocates a bit a target.
 */
cullet_status cullet_pvs_visible(cullet_pvs pvs,
                                 const uint32_t *cells,
                                 size_t cell_count,
                                 uint32_t *targets,
                                 size_t capacity,
                                 size_t *count);

/**
 * Gives a scene visible sets, to be culled by from now on where `cullet_settings.pvs` is 1 and the
 * eye is in one of their cells; 0 for no more. They are copied. Sets of view cells take the place
 * of the scene's own cells and portals until then; those of cells need the cells that they were
 * baked of. Instances that are added or moved later are seen from everywhere; what hides must stay
 * where it was. Refused with `CULLET_STATUS_FILE` where they are of another scene, or of this one
 * before it was changed. Cost: linear in the triangles of the meshes and in the instances.
 */
cullet_status cullet_scene_set_pvs(cullet_scene scene, cullet_pvs pvs);

/**
 * Finds what blocks lines of sight, and writes a result for each segment. Exact: nothing slips
 * through between two triangles that share an edge, and an end on a surface is not blocked by it.
 * What deforms, is blended or cut out does not block, and nothing does where a number is not
 * finite. `options` may be NULL. Cost: what each segment comes near; allocates nothing. Reads the
 * scene: give each thread its own part of the segments. Commit the scene for it to be quick.
 */
cullet_status cullet_lines_of_sight(cullet_scene scene,
                                    const cullet_segment *segments,
                                    size_t count,
                                    const cullet_sight_options *options,
                                    cullet_sight *results);

/**
 * Tests for each box of `to` whether all of it is hidden from all of the box `from`, all relative
 * to the scene's origin, and writes a `cullet_found`, one byte each: outside where one of the two
 * boxes is empty. Hidden is a proof that no segment between the two is free; visible is that there
 * is none, and the answer for numbers that are not finite. Convex occluders alone hide here, as
 * made by `cullet_scene_commit` or baked. `options` may be NULL. Cost: what lies between the
 * middles of the boxes; twice as much for each split. Allocates nothing, and reads the scene.
 */
cullet_status cullet_box_to_box(cullet_scene scene,
                                const cullet_box *from,
                                const cullet_box *to,
                                size_t count,
                                const cullet_box_sight_options *options,
                                uint8_t *results);

/**
 * Writes the cell of a point in world space, in a scene whose file brought cells, as maps and baked
 * files do; `UINT32_MAX` where the point is in none, or the scene has none. Reads the scene.
 */
cullet_status cullet_scene_cell_of(cullet_scene scene, const double *point, uint32_t *cell);

/**
 * Makes the memory of region queries. Destroy it with `cullet_region_destroy`.
 */
cullet_status cullet_region_create(cullet_region *region);

/**
 * Destroys the memory of region queries; its handle is stale from then on.
 */
cullet_status cullet_region_destroy(cullet_region region);

/**
 * Finds what may be seen from any eye in a box, for streaming, for baking, or for a frame whose eye
 * is not known yet; `cullet_region_slots` reads the result. `view` is how all the eyes look, a
 * perspective view carried to each; NULL for any direction. `settings` may be NULL. Nothing that an
 * eye sees is missing. Closed convex bodies alone hide here; walls that are sheets do not. Cost: up
 * to `most_cells` times six occlusion buffers, milliseconds and more. Reads the scene, and needs
 * `region` alone.
 */
cullet_status cullet_region_cull(cullet_scene scene,
                                 const cullet_eye_box *eyes,
                                 const cullet_view *view,
                                 const cullet_region_settings *settings,
                                 cullet_region region);

/**
 * Writes the slots that may be seen, ascending, as the scene had them when it was culled;
 * `capacity` and `count` as for `cullet_visible_slots`.
 */
cullet_status cullet_region_slots(cullet_region region,
                                  uint32_t *slots,
                                  size_t capacity,
                                  size_t *count);

/**
 * Writes the slots of which something is visible, ascending, and how many there are. With a
 * capacity of 0 only `count` is written; where the capacity is too small, that alone is, with
 * `CULLET_STATUS_TOO_SMALL`. The instances of a scene are always enough. Slots change with a
 * commit; `cullet_visible_handles` gives names that do not.
 */
cullet_status cullet_visible_slots(cullet_state state,
                                   uint32_t *slots,
                                   size_t capacity,
                                   size_t *count);

/**
 * Returns the same as `cullet_visible_slots`, but handles, in the order of the slots. The scene
 * must be as it was culled.
 */
cullet_status cullet_visible_handles(cullet_state state,
                                     cullet_scene scene,
                                     cullet_handle *handles,
                                     size_t capacity,
                                     size_t *count);

/**
 * Returns the same as `cullet_visible_slots`, but the callers' numbers (`cullet_instance.user`),
 * in the order of the slots. The scene must be as it was culled.
 */
cullet_status cullet_visible_users(cullet_state state,
                                   cullet_scene scene,
                                   uint64_t *users,
                                   size_t capacity,
                                   size_t *count);

/**
 * Writes why each slot was culled, one for each slot of the scene: stage 0 for what is visible,
 * and for empty slots. Needs `cullet_settings.reasons`; without, there are none.
 */
cullet_status cullet_visible_reasons(cullet_state state,
                                     cullet_reason *reasons,
                                     size_t capacity,
                                     size_t *count);

/**
 * Writes the counts in and out of each stage that ran; 32 rows are always enough.
 */
cullet_status cullet_visible_funnel(cullet_state state,
                                    cullet_funnel_row *rows,
                                    size_t capacity,
                                    size_t *count);

/**
 * Writes the draws of the last result: one command for the whole instances of a mesh and part, one
 * for each run of clusters of the others; where the output is triangles, one for each part of each
 * instance, of `indices` to be uploaded with it. `places` says where the renderer's buffers hold
 * meshes 0, 1, ...; for one beyond them commands count from its own first index. The counts are
 * always written; where an array is too small, only they are, with `CULLET_STATUS_TOO_SMALL`; all
 * capacities 0 asks for them. The scene must be as it was culled. Allocates nothing once the state
 * has grown.
 */
cullet_status cullet_visible_draws(cullet_state state,
                                   cullet_scene scene,
                                   const cullet_mesh_place *places,
                                   size_t place_count,
                                   cullet_draws *draws);

/**
 * The name of a stage, such as "frustum"; "unknown" for a number that is none. Never NULL; lives
 * for ever.
 */
const char *cullet_stage_name(uint32_t stage);

/**
 * The name of a unit of a funnel: "instances", "clusters" or "triangles"; "unknown" else. Never
 * NULL; lives for ever.
 */
const char *cullet_unit_name(uint32_t unit);

/**
 * Writes a scene to a file, by the ending of its name: `.glb` with the levels, occluders and cells
 * that were baked, which `cullet_open` reads; `.ply`, `.obj` and `.stl` without them. With
 * `original`, which may be NULL, a `.glb` is that glTF file as it is, textures and all, with what
 * was baked added: the one that the scene was opened from. Paths are UTF-8. An existing file is
 * replaced when all has been written. Refused with `CULLET_STATUS_FILE`; the message names the
 * file. Needs the scene alone. Cost: linear in the file.
 */
cullet_status cullet_scene_save(cullet_scene scene, const char *path, const char *original);

/**
 * Makes an empty scene. Destroy it with `cullet_scene_destroy`.
 */
cullet_status cullet_scene_create(cullet_scene *scene);

/**
 * Destroys a scene; its handle is stale from then on, and so are those of its instances.
 */
cullet_status cullet_scene_destroy(cullet_scene scene);

/**
 * Sorts the slots by place, closes gaps, and prepares meshes that are new. Call it once after
 * loading, and again after much was added, removed or moved far. Results of before are refused
 * (`CULLET_STATUS_NO_RESULT`) until the next cull. Cost: linear in instances, and in the triangles
 * of new meshes.
 */
cullet_status cullet_scene_commit(cullet_scene scene);

/**
 * Fits the nodes of the hierarchy to what moved: makes the next cull faster, never different.
 * Cost: that of what moved.
 */
cullet_status cullet_scene_refit(cullet_scene scene);

/**
 * Writes the contents of a scene. Cost: linear in its instances.
 */
cullet_status cullet_scene_get_info(cullet_scene scene, cullet_scene_info *info);

/**
 * Fills settings from a preset, a `cullet_preset`.
 */
cullet_status cullet_settings_preset(uint32_t number, cullet_settings *settings);

/**
 * Culls a scene for a light: what must be drawn into its shadow map so that the picture of
 * `camera` has its shadows. `cullet_visible_slots` and its like read the result. For the cascades
 * of a sun call it once for each, with one state each. Conservative: what is dropped casts no
 * shadow that the camera sees. The same stages by the same `settings` (NULL for
 * `CULLET_PRESET_BALANCED`) as `cullet_cull`; of a culled instance, stage `CULLET_STAGE_FRUSTUM`
 * says that its shadow cannot matter. Portals and visible sets play no part. Cost: that of a view.
 * Allocates nothing once `state` has grown. Reads the scene and `receivers`.
 */
cullet_status cullet_cull_shadow(cullet_scene scene,
                                 const cullet_view *camera,
                                 const cullet_shadow *shadow,
                                 const cullet_settings *settings,
                                 cullet_state state);

/**
 * Finds the lights that can change the picture of the view that `state` was last culled for by
 * `cullet_cull` or `cullet_cull_among`, and writes a `cullet_light_reason` for each, one byte: 0 is
 * kept. Uses what that cull found visible, and its occlusion buffer. The scene must be as it was
 * culled. Conservative: what is dropped lights no point that the view sees; light that is
 * scattered on its way, as in fog, is not thought of. Cost: a few tests a light, and a walk of the
 * hierarchy for each that is left. Allocates nothing once `state` has seen as many. Reads the
 * scene, and needs `state` alone.
 */
cullet_status cullet_cull_lights(cullet_scene scene,
                                 cullet_state state,
                                 const cullet_light *lights,
                                 size_t count,
                                 uint8_t *reasons);

/**
 * The message of the last call of this thread that failed: UTF-8, one line, which names the
 * function, the argument, the value, its limit and what to do. Empty where none failed yet. It
 * stays valid until the next call of this thread that fails. Never NULL.
 */
const char *cullet_last_error(void);

/**
 * The name of a status, such as "stale handle"; "unknown status" for a number that is none. Never
 * NULL; lives for ever.
 */
const char *cullet_status_name(int32_t status);

/**
 * The version of the library, such as "0.2.0". Never NULL; lives for ever.
 */
const char *cullet_version(void);

/**
 * Fills a view from a matrix that takes world to clip space: 16 doubles, column-major, invertible,
 * with depth 0 to 1 (`depth` says which is near). Perspective, orthographic, off-centre, mirrored,
 * with or without a far plane.
 */
cullet_status cullet_view_from_matrix(const double *clip_from_world,
                                      uint32_t depth,
                                      uint32_t width,
                                      uint32_t height,
                                      cullet_view *view);

/**
 * Fills a view from a camera; the message of a failure names the number that makes none.
 */
cullet_status cullet_view_from_camera(const cullet_camera *camera,
                                      uint32_t depth,
                                      uint32_t width,
                                      uint32_t height,
                                      cullet_view *view);

/**
 * Fills a perspective view from `eye` to `target`, three doubles each, +Y up (+Z where it looks
 * along Y), reversed depth without a far plane. `fov_y` is the full vertical field of view in
 * radians.
 */
cullet_status cullet_view_look_at(const double *eye,
                                  const double *target,
                                  double fov_y,
                                  double near_plane,
                                  uint32_t width,
                                  uint32_t height,
                                  cullet_view *view);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CULLET_H */
