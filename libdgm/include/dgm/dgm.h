/* SPDX-License-Identifier: MIT */
/* libdgm/include/dgm/dgm.h */
/* C interface of the runtime. It wraps the C++ one (asset.h, state.h, deform.h, ... hold the full contracts).
 *
 * Rules: a call that can fail returns a dgm_code (DGM_OK is 0) and fills `error` if that is not null. Structs start
 * with struct_size = sizeof(struct): older and newer libraries then read and write only what both know; a newer option
 * that is not 0 and not known is DGM_UNSUPPORTED. All-zero options are the defaults. Handles are destroyed with their
 * _destroy / _close call, null is allowed there. Nothing throws, aborts, prints or keeps global state. Coordinates,
 * displacements and radii beyond 1e18 are DGM_BAD_ARGUMENT (limits.h).
 */
#pragma once
#include <stddef.h>
#include <stdint.h>

#include <dgm/export.h>

#ifdef __cplusplus
extern "C" {
#endif

#define DGM_ABI_VERSION 2u                  /* 2: footprint 0 is the surface's distance; eq. 7 as printed is 3 */
#define DGM_NONE 0xFFFFFFFFu                /* no sample, no class */
#define DGM_NO_OFFSET 0xFFFFFFFFFFFFFFFFull /* no place in a file */
#define DGM_NO_ATTRIBUTE ((size_t)-1)       /* vertex attribute not wanted */

/* Numbers of dgm::ErrorCode. */
typedef enum dgm_code {
    DGM_OK = 0,
    DGM_BAD_ARGUMENT = 1,
    DGM_OUT_OF_MEMORY = 2,
    DGM_FILE_MISSING = 3,
    DGM_READ_FAILED = 4,
    DGM_NOT_DGM = 5,
    DGM_BAD_VERSION = 6,
    DGM_TRUNCATED = 7,
    DGM_HASH_MISMATCH = 8,
    DGM_BAD_INDEX = 9,
    DGM_BAD_LAYER = 10,
    DGM_BAD_VALUE = 11,
    DGM_BAD_SEAM_TABLE = 12,
    DGM_SEAM_GAP = 13,
    DGM_NOT_FINITE = 14,
    DGM_MISSING_LAYER = 15,
    DGM_UNKNOWN_LAYER = 16,
    DGM_LIMIT_EXCEEDED = 17,
    DGM_BUFFER_TOO_SMALL = 18,
    DGM_NOT_FOUND = 19,
    DGM_UNSUPPORTED = 20,
    DGM_BUSY = 21
} dgm_code;

typedef struct dgm_asset dgm_asset; /* an opened file: read-only, shared by threads */
typedef struct dgm_state dgm_state; /* a deformable chart: one thread at a time; outlives its asset */
typedef struct dgm_table dgm_table; /* kernel values: read-only, shared by threads */

typedef struct dgm_error {
    uint32_t struct_size;
    uint32_t code;        /* dgm_code */
    uint64_t byte_offset; /* in the file, or DGM_NO_OFFSET */
    const char* message;  /* static text */
} dgm_error;

/* Both functions, or neither for the C library's heap. Called while handles are made and destroyed, never in a tick. */
typedef struct dgm_allocator {
    uint32_t struct_size;
    void* user;
    void* (*allocate)(void* user, size_t bytes, size_t alignment);
    void (*release)(void* user, void* memory, size_t bytes);
} dgm_allocator;

typedef struct dgm_open_options {
    uint32_t struct_size;
    uint32_t verify_hashes;             /* 1: hash every layer now */
    const char* const* required_layers; /* names every chart must hold */
    size_t required_layer_count;
    uint64_t max_file_bytes; /* limits: 0 is the default */
    uint32_t max_charts, max_layers, max_samples;
    const char* const* layers; /* if not null: only these and the tables every reader needs are listed */
    size_t layer_count;
} dgm_open_options;

typedef struct dgm_asset_usage {
    uint32_t struct_size;
    uint64_t mapped_bytes; /* of address space; pages are loaded when they are read */
    uint64_t heap_bytes;
} dgm_asset_usage;

typedef struct dgm_state_usage {
    uint32_t struct_size;
    uint32_t samples, active_samples, dirty_samples;
    uint64_t bytes;
} dgm_state_usage;

typedef struct dgm_chart_info {
    uint32_t struct_size;
    uint32_t rows, cols;
    uint32_t domain; /* 0 square, 1 free */
    uint32_t border_samples;
    uint32_t layer_count;
    double bbox[6];             /* min xyz, max xyz in the source frame */
    double offset[3], scale[3]; /* source frame = offset + local; local = scale * stored */
    const char* method;         /* lives as long as the asset */
} dgm_chart_info;

typedef struct dgm_layer_view {
    uint32_t struct_size;
    uint32_t type; /* 1 u8, 2 u16, 3 u32, 4 i16, 5 f16, 6 f32 */
    uint32_t rank;
    uint32_t known; /* 0: an optional layer this version has no rules for */
    uint64_t shape[4];
    uint64_t file_offset;
    const char* name; /* name and data live as long as the asset */
    const void* data;
    size_t bytes;
} dgm_layer_view;

typedef struct dgm_mesh_counts {
    uint32_t struct_size;
    uint32_t vertices;
    uint64_t indices;
} dgm_mesh_counts;

#define DGM_RESTART 0xFFFFFFFFu /* ends a strip */

/* Caller's vertices: attribute of vertex k at data + k * stride + offset: position xyz, normal xyz, uv. */
typedef struct dgm_vertex_target {
    uint32_t struct_size;
    uint32_t lod_stride; /* 0 or 1: every sample; k: blocks of at least k x k quads as two triangles */
    void* data;          /* null: no vertices */
    size_t bytes, stride;
    size_t position_offset, normal_offset, uv_offset;   /* or DGM_NO_ATTRIBUTE */
    uint32_t strips;                                    /* 1: indices are strips with DGM_RESTART between them */
    uint32_t position_format, normal_format, uv_format; /* 0 f32, 1 f16, 2 u16 */
    float origin[3], step[3];                           /* u16 positions: stored = (position - origin) / step */
} dgm_vertex_target;

typedef struct dgm_state_options {
    uint32_t struct_size;
    uint32_t max_reach;   /* 0: 65 */
    uint64_t max_bytes;   /* 0: no limit */
    uint32_t metric;      /* read by older versions alone */
    uint32_t max_tools;   /* 0: 4 */
    uint32_t plain_loops; /* 1: no vector instructions beyond the baseline */
} dgm_state_options;

typedef struct dgm_kernel_options {
    uint32_t struct_size;
    uint32_t shape;           /* 0 circular, 1 elliptic, 2 user */
    uint32_t end;             /* 0 eq. 7 as printed, 1 compact */
    uint32_t reach;           /* b of eq. 7 */
    float sigma;              /* squared grid steps, 1e-6 .. 1e12 */
    float radius_a, radius_b; /* elliptic: grid steps to weight 1/e, 1e-3 .. 1e6, ratio at most 1e4 */
    float angle;              /* elliptic: radians from +i towards +j */
    const float* values;      /* user: weights at equal distances 0 .. b, copied */
    size_t value_count;
} dgm_kernel_options;

typedef struct dgm_touch {
    uint32_t struct_size;
    uint32_t sample;
    float displacement[3];
    float d_max;
    uint32_t footprint; /* 0 surface, 1 the same (once metric), 2 geodesic, 3 grid: eq. 7 as printed */
    uint32_t mode;      /* 0 elastic, 1 plastic */
    float step;         /* surface, geodesic: local length of a kernel step, 1e-15 .. 1e15; 0: the mean one */
} dgm_touch;

typedef struct dgm_deform_report {
    uint32_t struct_size;
    uint32_t samples;
    float displacement[3];
    uint32_t crossed_seam;
    uint32_t truncated;
} dgm_deform_report;

/* A tool in a tick. In arrays elements stand struct_size bytes apart, the same for all. */
typedef struct dgm_tool_input {
    uint32_t struct_size;
    uint32_t tool;     /* 0 .. max_tools - 1, each at most once */
    uint32_t kind;     /* 0 touch, 1 poke, 2 grasp */
    uint32_t lifted;   /* 1: lets go, does not touch */
    float position[3]; /* local coordinates */
} dgm_tool_input;

typedef struct dgm_tool_output {
    uint32_t struct_size;
    uint32_t sample; /* nearest sample of the permanent shape */
    float distance;
    uint32_t hit;     /* N_t . N_n < 0 */
    uint32_t lost;    /* the window did not certify the sample: the pyramid was searched */
    uint32_t holding; /* in contact or grasping */
    uint32_t contact; /* displaced sample, or DGM_NONE */
    float displacement[3];
    float force[3];
} dgm_tool_output;

typedef struct dgm_tick_options {
    uint32_t struct_size;
    uint32_t footprint, mode; /* as dgm_touch */
    uint32_t rule;            /* 0 smooth, 1 as the paper prints it */
    uint32_t skip_normals;    /* 1: leave dgm_state_normals() as they are */
    float dt;                 /* seconds; 0: 0.001 */
    float d_max, f_max;
    float relax_rate;     /* 1/s; 0: springs back at once, negative: never */
    float settle_time;    /* seconds; 0: 0.01, negative: none */
    float grasp_distance; /* 0: four mean steps */
    float step;           /* as dgm_touch */
} dgm_tick_options;

typedef struct dgm_tick_report {
    uint32_t struct_size;
    uint32_t contacts, samples;
    uint32_t crossed_seam, truncated;
} dgm_tick_report;

/* A ray and what it meets first (pick.h), local coordinates. */
typedef struct dgm_pick_options {
    uint32_t struct_size;
    uint32_t skip_back_faces; /* 1: triangles seen from behind are passed */
    float max_distance;       /* 0: no limit */
} dgm_pick_options;

typedef struct dgm_ray_hit {
    uint32_t struct_size;
    uint32_t sample;      /* corner with the largest weight, by its class's representative */
    uint32_t row, column; /* quad, or DGM_NONE for a face of a border strip */
    uint32_t triangle;    /* of the quad: 0 or 1; else the place in `border_faces` */
    uint32_t corners[3];  /* samples */
    uint32_t front;       /* 1: seen from the side that `normal` points to */
    float barycentric[3];
    float distance; /* local units, whatever the direction's length */
    float point[3];
    float normal[3]; /* unit normal of the flat triangle */
} dgm_ray_hit;

/* Contact with an obstacle (contact.h), local coordinates of the state that is pressed against it. */
typedef struct dgm_contact_solver dgm_contact_solver; /* scratch of contacts of one state */

typedef struct dgm_obstacle {
    uint32_t struct_size;
    uint32_t kind;   /* 0 plane, 1 sphere, 2 capsule, 3 box, 4 surface */
    float point[3];  /* of the plane; centre of sphere or box; one end of the capsule; origin of the surface's frame */
    float normal[3]; /* plane: towards the free side */
    float end[3];    /* capsule */
    float radius;    /* sphere, capsule */
    float half[3];   /* box */
    float rotation[9];  /* box, surface: own frame to the state's, rows first; all 0: none */
    dgm_state* surface; /* another state */
    float reach;        /* surface: farther behind it a sample is on the other side; 0: the default */
} dgm_obstacle;

/* Row of the table of R and sigma by D. In arrays elements stand struct_size bytes apart. */
typedef struct dgm_ring_size {
    uint32_t struct_size;
    float total, reach, sigma;
} dgm_ring_size;

typedef struct dgm_contact_options {
    uint32_t struct_size;
    uint32_t bulge;             /* 0 exact, 1 eq. 11 as printed, 2 none */
    uint32_t mode;              /* 0 elastic, 1 plastic */
    uint32_t smoothing;         /* open surfaces: rounds; 0: 8 */
    uint32_t no_smoothing;      /* 1: no rounds */
    float max_depth, max_total; /* dS_max, dT_max; 0: no limit */
    const dgm_ring_size* rings; /* null: sized by the contact */
    size_t ring_count;
} dgm_contact_options;

typedef struct dgm_contact_report {
    uint32_t struct_size;
    uint32_t status; /* 0 clear, 1 contact, 2 restored, 3 open: no volume is kept */
    uint32_t volume_kept, sunk;
    uint32_t samples, ring, passes;
    float deepest, total, ring_reach, ring_sigma, beta;
    double removed, volume_error, first_order_error, paper_error;
} dgm_contact_report;

/* Samples first + r * cols + c, r < rows, c < columns: a rectangle of the grid or, first >= rows * cols of the chart,
   an interval of border samples (changed.h). In arrays elements stand struct_size bytes apart. */
typedef struct dgm_changed_range {
    uint32_t struct_size;
    uint32_t first, columns, rows;
} dgm_changed_range;

/* Shapes from one writer to any number of readers (snapshot.h). */
typedef struct dgm_snapshots dgm_snapshots;

typedef struct dgm_snapshot_options {
    uint32_t struct_size;
    uint32_t slots;      /* 0: 3 */
    uint32_t no_normals; /* 1: positions only */
    uint64_t max_bytes;  /* 0: no limit */
} dgm_snapshot_options;

typedef struct dgm_snapshot_info {
    uint32_t struct_size;
    uint32_t retries;
    uint64_t frame, tag;
} dgm_snapshot_info;

DGM_API uint32_t dgm_abi_version(void);
/* Stable name of a code, e.g. "BAD_INDEX". */
DGM_API const char* dgm_code_name(uint32_t code);

/* Assets. `options` and `allocator` may be null. open_memory: bytes aligned to 16, kept alive by the caller. */
DGM_API dgm_code dgm_asset_open(const char* path, const dgm_open_options* options, const dgm_allocator* allocator,
                                dgm_asset** asset, dgm_error* error);
DGM_API dgm_code dgm_asset_open_memory(const void* data, size_t bytes, const dgm_open_options* options,
                                       const dgm_allocator* allocator, dgm_asset** asset, dgm_error* error);
DGM_API void dgm_asset_close(dgm_asset* asset);
DGM_API dgm_code dgm_asset_verify(const dgm_asset* asset, dgm_error* error);
DGM_API uint32_t dgm_asset_chart_count(const dgm_asset* asset);
DGM_API dgm_code dgm_asset_chart(const dgm_asset* asset, uint32_t chart, dgm_chart_info* info, dgm_error* error);
DGM_API dgm_code dgm_asset_layer(const dgm_asset* asset, uint32_t chart, uint32_t layer, dgm_layer_view* view,
                                 dgm_error* error);
DGM_API dgm_code dgm_asset_find_layer(const dgm_asset* asset, uint32_t chart, const char* name, dgm_layer_view* view,
                                      dgm_error* error);
DGM_API dgm_code dgm_chart_validate(const dgm_asset* asset, uint32_t chart, const dgm_allocator* allocator,
                                    dgm_error* error);

/* Reconstruction. `counts` may be null; `indices` null leaves the triangles out, `vertices` null the vertices. */
DGM_API dgm_code dgm_chart_mesh_counts(const dgm_asset* asset, uint32_t chart, dgm_mesh_counts* counts,
                                       dgm_error* error);
DGM_API dgm_code dgm_chart_reconstruct(const dgm_asset* asset, uint32_t chart, const dgm_vertex_target* vertices,
                                       uint32_t* indices, size_t index_count, dgm_mesh_counts* counts,
                                       dgm_error* error);
DGM_API dgm_code dgm_state_mesh_counts(const dgm_state* state, dgm_mesh_counts* counts, dgm_error* error);
/* The same for indices at a stride, as triangles or strips. */
DGM_API dgm_code dgm_chart_mesh_counts_at(const dgm_asset* asset, uint32_t chart, uint32_t lod_stride, uint32_t strips,
                                          dgm_mesh_counts* counts, dgm_error* error);
DGM_API dgm_code dgm_state_mesh_counts_at(const dgm_state* state, uint32_t lod_stride, uint32_t strips,
                                          dgm_mesh_counts* counts, dgm_error* error);
DGM_API dgm_code dgm_state_reconstruct(const dgm_state* state, const dgm_vertex_target* vertices, uint32_t* indices,
                                       size_t index_count, dgm_mesh_counts* counts, dgm_error* error);

/* States. */
DGM_API dgm_code dgm_state_create(const dgm_asset* asset, uint32_t chart, const dgm_state_options* options,
                                  const dgm_allocator* allocator, dgm_state** state, dgm_error* error);
DGM_API void dgm_state_destroy(dgm_state* state);
DGM_API void dgm_state_release(dgm_state* state); /* ends elastic touches */
DGM_API void dgm_state_reset(dgm_state* state);   /* back to rest */
/* Fading: rate in 1/s, infinity is release. */
DGM_API dgm_code dgm_state_relax(dgm_state* state, float dt, float rate, dgm_error* error);
DGM_API void dgm_state_update_normals(dgm_state* state);
/* The state's own arrays: x, y, z of all samples. normals: as of the last tick or dgm_state_update_normals(). Ask again
   after a tick: what fades is brought up to date by this call. */
DGM_API size_t dgm_state_positions(const dgm_state* state, const float* xyz[3]);
DGM_API size_t dgm_state_normals(const dgm_state* state, const float* xyz[3]);
/* Where these arrays hold other bits than when *cursor was last passed here; *cursor is 0 at first, each reader has its
   own. ranges[0].struct_size is set by the caller and counts for all; capacity is at least 1, or 2 if there are border
   samples (else DGM_BUFFER_TOO_SMALL), and more than 256 are not used: what does not fit is joined to larger ranges. */
DGM_API dgm_code dgm_state_changed_rows(const dgm_state* state, uint64_t* cursor, dgm_changed_range* ranges,
                                        size_t capacity, size_t* count, dgm_error* error);
DGM_API float dgm_state_mean_step(const dgm_state* state);
DGM_API uint32_t dgm_state_sample_count(const dgm_state* state);
DGM_API dgm_code dgm_state_position(const dgm_state* state, uint32_t sample, float position[3], dgm_error* error);
DGM_API dgm_code dgm_state_normal(const dgm_state* state, uint32_t sample, float normal[3], dgm_error* error);
/* Seam class of a sample (DGM_NONE if none), and the samples of a class: *members is the state's own memory. */
DGM_API uint32_t dgm_state_class_of(const dgm_state* state, uint32_t sample);
DGM_API size_t dgm_state_class_members(const dgm_state* state, uint32_t class_id, const uint32_t** members);

/* Touch. */
DGM_API dgm_code dgm_table_create(const dgm_kernel_options* options, const dgm_allocator* allocator, dgm_table** table,
                                  dgm_error* error);
DGM_API void dgm_table_destroy(dgm_table* table);
DGM_API float dgm_table_weight(const dgm_table* table, float di, float dj);
DGM_API float dgm_table_profile(const dgm_table* table, float distance);
DGM_API dgm_code dgm_deform(dgm_state* state, const dgm_table* table, const dgm_touch* touch, dgm_deform_report* report,
                            dgm_error* error);
DGM_API dgm_code dgm_nearest_sample(dgm_state* state, const float tool[3], uint32_t* sample, float* distance,
                                    dgm_error* error);
DGM_API dgm_code dgm_track_sample(dgm_state* state, const float tool[3], uint32_t last, uint32_t a, uint32_t* sample,
                                  float* distance, dgm_error* error);
/* dgm_track_sample() made certain by the pyramid; *lost: the window alone had missed the sample. */
DGM_API dgm_code dgm_track_nearest(dgm_state* state, const float tool[3], uint32_t last, uint32_t a, uint32_t* sample,
                                   float* distance, uint32_t* lost, dgm_error* error);
/* First triangle of the present shape along a ray; DGM_NOT_FOUND if there is none. `options` and `hit` may be null. The
   direction may have any length but 0. */
DGM_API dgm_code dgm_pick_ray(dgm_state* state, const float origin[3], const float direction[3],
                              const dgm_pick_options* options, dgm_ray_hit* hit, dgm_error* error);
/* One turn of the haptic loop: track, hit, force, deform, normals (tick.h). outputs and report may be null. */
DGM_API dgm_code dgm_tick(dgm_state* state, const dgm_table* table, const dgm_tick_options* options,
                          const dgm_tool_input* tools, size_t tool_count, dgm_tool_output* outputs,
                          dgm_tick_report* report, dgm_error* error);
/* N_t . N_n < 0, paper section 5.1: tool_vector from the nearest sample to the tool. */
DGM_API dgm_code dgm_hit_test(const float tool_vector[3], const float normal[3], uint32_t* hit, dgm_error* error);
/* f = -(d / |d_max|)^3 f_max per axis, paper eqs. 8-10. */
DGM_API dgm_code dgm_contact_force(const float d[3], float d_max, float f_max, float force[3], dgm_error* error);

/* Contact. `options` may be null; `report` too. */
DGM_API dgm_code dgm_contact_solver_create(const dgm_state* state, const dgm_allocator* allocator,
                                           dgm_contact_solver** solver, dgm_error* error);
DGM_API void dgm_contact_solver_destroy(dgm_contact_solver* solver);
DGM_API uint32_t dgm_contact_solver_closed(const dgm_contact_solver* solver);
DGM_API double dgm_contact_solver_volume(const dgm_contact_solver* solver, const dgm_state* state);
DGM_API dgm_code dgm_resolve_contact(dgm_state* state, const dgm_contact_solver* solver, const dgm_obstacle* obstacle,
                                     const dgm_contact_options* options, dgm_contact_report* report, dgm_error* error);
DGM_API dgm_code dgm_obstacle_distance(const dgm_obstacle* obstacle, const float point[3], float* distance,
                                       float nearest[3], dgm_error* error);

/* Snapshots. frame and info may be null; positions or normals too: x of all samples, then y, then z. */
DGM_API dgm_code dgm_snapshots_create(const dgm_state* state, const dgm_snapshot_options* options,
                                      const dgm_allocator* allocator, dgm_snapshots** snapshots, dgm_error* error);
DGM_API void dgm_snapshots_destroy(dgm_snapshots* snapshots);
DGM_API dgm_code dgm_snapshots_publish(dgm_snapshots* snapshots, const dgm_state* state, uint64_t tag, uint64_t* frame,
                                       dgm_error* error);
DGM_API uint64_t dgm_snapshots_frame(const dgm_snapshots* snapshots);
DGM_API dgm_code dgm_snapshots_read(const dgm_snapshots* snapshots, float* positions, float* normals,
                                    size_t floats_each, dgm_snapshot_info* info, dgm_error* error);
/* The memory holds frame `since` (0: nothing) and is brought to the newest one: only what differs is copied, and named
   in ranges as by dgm_state_changed_rows(). After DGM_BUSY call with since 0. */
DGM_API dgm_code dgm_snapshots_read_changed(const dgm_snapshots* snapshots, float* positions, float* normals,
                                            size_t floats_each, uint64_t since, dgm_changed_range* ranges,
                                            size_t capacity, size_t* count, dgm_snapshot_info* info, dgm_error* error);

/* What assets and states cost. */
DGM_API dgm_code dgm_asset_get_usage(const dgm_asset* asset, dgm_asset_usage* usage, dgm_error* error);
DGM_API dgm_code dgm_state_get_usage(const dgm_state* state, dgm_state_usage* usage, dgm_error* error);

#ifdef __cplusplus
}
#endif
