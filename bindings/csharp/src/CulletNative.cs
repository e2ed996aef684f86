// The C library's functions, as its header (bindings/c/include/cullet.h) declares and explains them, and those of its
// structs that hold pointers or handles. The other structs are in CulletTypes.cs and CulletPvs.cs. tests/Layouts.cs compares all of it
// with the header.
using System;
using System.Runtime.InteropServices;

namespace Cullet
{
    /// <summary>The C interface, call for call, for pointers of your own. Nothing is marshalled: every type is
    /// blittable. Each call that can fail returns a status; the classes around it turn that into
    /// <see cref="CulletException"/>.</summary>
    public static unsafe partial class CulletNative
    {
#if (UNITY_IOS || UNITY_WEBGL) && !UNITY_EDITOR
        const string Library = "__Internal";
#else
        const string Library = "cullet";
#endif

        /// <summary>Functions of a native library of yours that the library takes all its memory from. Managed code
        /// cannot serve: they are called on every thread, also on those that end.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_allocator
        {
            public IntPtr alloc;
            public IntPtr free;
            public IntPtr realloc;
            public void* context;
        }

        /// <summary>Handle of a set of boxes. A plain number: copy it freely; 0 is none.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_boxes
        {
            public ulong id;
        }

        /// <summary>Boxes in arrays of the caller's, of any layout. Set it to zero before its fields.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_box_arrays
        {
            public void* first;
            public void* second;
            public UIntPtr stride;
            public UIntPtr second_stride;
            public UIntPtr count;
            public uint number;
            public uint form;
            public CulletDouble3 origin;
        }

        /// <summary>An occluder, in arrays of the caller's. Set it to zero before its fields.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_occluder
        {
            public uint kind;
            public uint index_size;
            public float* positions;
            public UIntPtr stride;
            public UIntPtr position_count;
            public void* indices;
            public UIntPtr index_count;
            public CulletTransform* transform;
        }

        /// <summary>Handle of an occlusion buffer. A plain number: copy it freely; 0 is none.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_occlusion
        {
            public ulong id;
        }

        /// <summary>Triangles in clip space, or with a matrix that takes them there.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_clip_triangles
        {
            public float* vertices;
            public UIntPtr stride;
            public UIntPtr offset_y;
            public UIntPtr offset_zw;
            public uint* indices;
            public UIntPtr triangle_count;
            public float* clip_from_model;
            public uint cull_winding;
            public uint reserved;
        }

        /// <summary>Handle of the state of a view: what it remembers between frames, and its last result.
        /// One for each view that is culled frame after frame. A plain number: copy it freely; 0 is
        /// none.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_state
        {
            public ulong id;
        }

        /// <summary>Handle of a scene. A plain number: copy it freely; 0 is none.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_scene
        {
            public ulong id;
        }

        /// <summary>Threads of yours that run jobs: your pool.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_jobs
        {
            public uint threads;
            public uint reserved;
            public IntPtr run;
            public void* context;
        }

        /// <summary>A mesh to add: its arrays are copied. A struct of zeros with positions and indices is a
        /// mesh of one opaque, two-sided part.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_mesh_arrays
        {
            public float* positions;
            public UIntPtr position_count;
            public uint* indices;
            public UIntPtr index_count;
            public CulletPart* parts;
            public UIntPtr part_count;
            public uint flags;
            public uint material;
        }

        /// <summary>Handle of a region query: its memory, and its last result. A plain number: copy it
        /// freely; 0 is none.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_region
        {
            public ulong id;
        }

        /// <summary>Arrays that draws are written into. Capacities go in, counts come out.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_draws
        {
            public CulletDrawCommand* commands;
            public CulletDrawKey* keys;
            public UIntPtr command_capacity;
            public UIntPtr command_count;
            public uint* instances;
            public UIntPtr instance_capacity;
            public UIntPtr instance_count;
            public uint* indices;
            public UIntPtr index_capacity;
            public UIntPtr index_count;
        }

        /// <summary>The shadows of a light that are wanted. Set it to zero before its fields.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_shadow
        {
            public CulletLight light;
            public CulletView* map;
            public cullet_state receivers;
            public double margin;
            public double slice_near;
            public double slice_far;
        }

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_set_allocator(cullet_allocator* allocator);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_boxes_create(uint occlusion_width, cullet_boxes* boxes);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_boxes_destroy(cullet_boxes boxes);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_boxes_set(cullet_boxes boxes, cullet_box_arrays* arrays);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_boxes_update(
            cullet_boxes boxes, UIntPtr first, cullet_box_arrays* arrays);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_boxes_cull(
            cullet_boxes boxes, CulletView* view, byte* flags, UIntPtr capacity, UIntPtr* visible);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_boxes_cull_bits(
            cullet_boxes boxes, CulletView* view, ulong* words, UIntPtr capacity, UIntPtr* visible);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_boxes_set_occluders(
            cullet_boxes boxes, cullet_occluder* occluders, UIntPtr count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_boxes_set_occluder(
            cullet_boxes boxes, uint number, cullet_occluder* occluder);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_boxes_move_occluder(
            cullet_boxes boxes, uint number, CulletTransform* transform);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_clip_begin(cullet_occlusion buffer, float near_w);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_clip_draw(
            cullet_occlusion buffer, cullet_clip_triangles* triangles, uint* result);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_clip_test_rect(
            cullet_occlusion buffer, float x_min, float y_min, float x_max, float y_max, float least_w, uint* result);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_clip_test_triangles(
            cullet_occlusion buffer, cullet_clip_triangles* triangles, uint* result);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_state_create(cullet_state* state);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_state_destroy(cullet_state state);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_cull(
            cullet_scene scene, CulletView* view, CulletSettings* settings, cullet_state state);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_cull_among(
            cullet_scene scene, CulletView* view, CulletSettings* settings, ulong* words, UIntPtr word_count,
            cullet_state state);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_cull_stereo(
            cullet_scene scene, CulletView* left, CulletView* right, CulletSettings* settings, cullet_state state);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_visible_eyes(
            cullet_state state, cullet_scene scene, CulletView* left, CulletView* right, byte* eyes,
            UIntPtr capacity, UIntPtr* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_cull_on(
            cullet_jobs* jobs, cullet_scene scene, CulletView* view, CulletSettings* settings, cullet_state state);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_explain(
            cullet_scene scene, CulletView* view, CulletSettings* settings, CulletHandle handle,
            CulletReason* reason, byte* text, UIntPtr capacity, UIntPtr* length);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_add_mesh(
            cullet_scene scene, cullet_mesh_arrays* arrays, uint* mesh);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_mesh_info(cullet_scene scene, uint mesh, CulletMeshInfo* info);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_mesh_read(
            cullet_scene scene, uint mesh, float* positions, UIntPtr position_capacity, uint* indices,
            UIntPtr index_capacity);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_occlusion_create(uint width, uint height, cullet_occlusion* buffer);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_occlusion_destroy(cullet_occlusion buffer);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_occlusion_begin(
            cullet_occlusion buffer, CulletView* view, double* origin);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_occlusion_draw_boxes(
            cullet_occlusion buffer, CulletBox* boxes, UIntPtr count, CulletTransform* transform);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_occlusion_draw_triangles(
            cullet_occlusion buffer, float* positions, UIntPtr position_count, uint* indices, UIntPtr index_count,
            uint two_sided, CulletTransform* transform);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_occlusion_test_boxes(
            cullet_occlusion buffer, CulletBox* boxes, UIntPtr count, byte* results);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_occlusion_read(
            cullet_occlusion buffer, float* nearness, UIntPtr capacity);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_lines_of_sight(
            cullet_scene scene, CulletSegment* segments, UIntPtr count, CulletSightOptions* options,
            CulletSight* results);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_box_to_box(
            cullet_scene scene, CulletBox* from, CulletBox* to, UIntPtr count, CulletBoxSightOptions* options,
            byte* results);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_cell_of(cullet_scene scene, double* point, uint* cell);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_region_create(cullet_region* region);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_region_destroy(cullet_region region);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_region_cull(
            cullet_scene scene, CulletEyeBox* eyes, CulletView* view, CulletRegionSettings* settings,
            cullet_region region);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_region_slots(
            cullet_region region, uint* slots, UIntPtr capacity, UIntPtr* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_visible_slots(
            cullet_state state, uint* slots, UIntPtr capacity, UIntPtr* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_visible_handles(
            cullet_state state, cullet_scene scene, CulletHandle* handles, UIntPtr capacity, UIntPtr* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_visible_users(
            cullet_state state, cullet_scene scene, ulong* users, UIntPtr capacity, UIntPtr* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_visible_reasons(
            cullet_state state, CulletReason* reasons, UIntPtr capacity, UIntPtr* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_visible_funnel(
            cullet_state state, CulletFunnelRow* rows, UIntPtr capacity, UIntPtr* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_visible_draws(
            cullet_state state, cullet_scene scene, CulletMeshPlace* places, UIntPtr place_count,
            cullet_draws* draws);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern byte* cullet_stage_name(uint stage);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern byte* cullet_unit_name(uint unit);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_create(cullet_scene* scene);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_open(byte* path, cullet_scene* scene);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_destroy(cullet_scene scene);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_add(
            cullet_scene scene, CulletInstance* instances, UIntPtr count, CulletHandle* handles);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_remove(cullet_scene scene, CulletHandle* handles, UIntPtr count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_set_transforms(
            cullet_scene scene, CulletHandle* handles, CulletTransform* transforms, UIntPtr count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_set_layers(
            cullet_scene scene, CulletHandle* handles, uint* layers, UIntPtr count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_set_flags(
            cullet_scene scene, CulletHandle* handles, uint* values, UIntPtr count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_set_bounds(
            cullet_scene scene, CulletHandle handle, uint kind, float* numbers);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_commit(cullet_scene scene);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_refit(cullet_scene scene);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_get_info(cullet_scene scene, CulletSceneInfo* info);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_slot(cullet_scene scene, CulletHandle handle, uint* slot);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_instance(
            cullet_scene scene, uint slot, CulletInstance* instance, CulletHandle* handle);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_settings_preset(uint number, CulletSettings* settings);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_cull_shadow(
            cullet_scene scene, CulletView* camera, cullet_shadow* shadow, CulletSettings* settings,
            cullet_state state);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_cull_lights(
            cullet_scene scene, cullet_state state, CulletLight* lights, UIntPtr count, byte* reasons);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern byte* cullet_last_error();

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern byte* cullet_status_name(int status);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern byte* cullet_version();

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_view_from_matrix(
            double* clip_from_world, uint depth, uint width, uint height, CulletView* view);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_view_from_camera(
            CulletCamera* camera, uint depth, uint width, uint height, CulletView* view);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_view_look_at(
            double* eye, double* target, double fov_y, double near_plane, uint width, uint height, CulletView* view);
    }
}
