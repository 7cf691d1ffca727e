/* SPDX-License-Identifier: MIT */
/* libdgm/include/dgm/dgm.h */
/* C interface of libdgm: opens .dgm files, deforms their charts, and hands the shapes to a renderer.
 *
 * This header is complete: a C program needs no other one. Equation numbers are those of Liu, Prakash and Srinivasan,
 * "Interactive deformable geometry maps", The Visual Computer 23 (2007) 119-131, called "the paper".
 *
 * WORDS
 *   asset      the content of one .dgm file: one or more charts
 *   chart      one connected surface, stored as a grid of rows x cols samples
 *   sample     a point of the surface. Grid sample (i, j) has the index i * cols + j. The domain of a chart is square
 *              or free; a free one also has border samples, and border sample b has the index rows * cols + b
 *   seam       the line along which a surface was cut open. A sample on it is stored more than once: its seam copies
 *              form a weld class, whose lowest index is its representative. All copies have the same bits at all times
 *              (on a surface with one side, some have the opposite normal, to the bit: formats/SPEC.md section 3.5)
 *   state      the deformable copy of a chart. It keeps three shapes: rest (as baked), permanent (rest and plastic
 *              touches) and present (permanent and elastic touches)
 *   mean step  the square root of the mean area of a quad at rest: the typical length of a grid step
 *   local      coordinates of a state, in the units of the source mesh: source = dgm_chart_info.offset + local
 *
 * ERRORS
 *   A function that can fail returns a dgm_code; DGM_OK is 0. If `error` is not NULL, it also receives the code, a
 *   message and a place in the file. On failure nothing else is written and nothing is changed, unless the function
 *   says so. Initialize handles to NULL: a function that fails to create one sets it to NULL, except if a required
 *   pointer was NULL.
 *
 * POINTERS
 *   A pointer may be NULL where its function says so, and `error` always may. Any other NULL gives DGM_BAD_ARGUMENT.
 *   Functions that return no code accept NULL for every pointer; they then do nothing, or return the value they name.
 *
 * STRUCTS
 *   Each struct starts with struct_size. Set it to sizeof(struct) and all other fields to 0, then set the fields you
 *   need. Older and newer libraries then exchange the fields that both know. A field that the library does not know
 *   must be 0, else the call gives DGM_UNSUPPORTED. Options whose struct_size is below 4 or above 4096 give
 *   DGM_BAD_ARGUMENT; a result whose struct_size is below 4 is not written.
 *   Elements of an array lie struct_size bytes apart. Each one needs the same struct_size, unless the function says
 *   that the first one counts for all.
 *   A uint32_t that stands for a choice names its enum. A value that the enum does not name gives DGM_UNSUPPORTED.
 *   A uint32_t described by "1: ..." is a flag; any value other than 0 counts as 1.
 *
 * NUMBERS
 *   Coordinates, displacements and radii beyond 1e18 in size give DGM_BAD_ARGUMENT. So do NaN and infinity, unless the
 *   comment allows them. Vectors are x, y, z.
 *
 * THREADS
 *   Any number of threads may use one asset or one table at the same time. One thread at a time may use a state, even
 *   to read it: reading brings faded displacements up to date. Functions that any thread may call at any time say so.
 *   Different states are independent. Snapshots carry shapes from the thread of a state to others. No handle may be
 *   destroyed while another thread uses it.
 *
 * MEMORY
 *   A handle takes its memory when it is created and releases it when it is destroyed; dgm_chart_validate() takes some
 *   while it runs. No other call allocates. Handles may be destroyed in any order.
 *
 * Nothing throws, aborts, prints or keeps global state.
 */
#pragma once
#include <stddef.h>
#include <stdint.h>

#include <dgm/export.h>

#ifdef __cplusplus
extern "C" {
#endif

/* -------- Version and constants -------- */

/* Changes when a program must be compiled anew. 2: DGM_FOOTPRINT_SURFACE is 0 and DGM_FOOTPRINT_GRID is 3. */
#define DGM_ABI_VERSION 2u
/* No sample, no class. */
#define DGM_NONE 0xFFFFFFFFu
/* No place in a file. */
#define DGM_NO_OFFSET 0xFFFFFFFFFFFFFFFFull
/* A vertex attribute that is not wanted. */
#define DGM_NO_ATTRIBUTE ((size_t)-1)
/* The index that ends a strip: the fixed restart index of OpenGL, Vulkan, Direct3D and Metal for 32-bit indices. */
#define DGM_RESTART 0xFFFFFFFFu

/* Returns the DGM_ABI_VERSION that the library was compiled with. If it differs from yours, do not call anything
 * else. Any thread. */
DGM_API uint32_t dgm_abi_version(void);

/* -------- Errors -------- */

/* Result of a call. Numbers are never reused; new ones are added at the end. */
typedef enum dgm_code {
    DGM_OK = 0,
    DGM_BAD_ARGUMENT = 1,      /* a parameter is NULL, out of range or not finite */
    DGM_OUT_OF_MEMORY = 2,     /* the allocator returned NULL */
    DGM_FILE_MISSING = 3,      /* no such file */
    DGM_READ_FAILED = 4,       /* the file exists but cannot be read or mapped */
    DGM_NOT_DGM = 5,           /* the file does not start with the magic of a .dgm */
    DGM_BAD_VERSION = 6,       /* format version 0, or newer than this library */
    DGM_TRUNCATED = 7,         /* the file is shorter than its header says */
    DGM_HASH_MISMATCH = 8,     /* stored bytes differ from their hash (XXH3-128) */
    DGM_BAD_INDEX = 9,         /* the header, a chart record or a layer record is inconsistent */
    DGM_BAD_LAYER = 10,        /* a known layer has the wrong type or shape */
    DGM_BAD_VALUE = 11,        /* a layer contains a value outside its range */
    DGM_BAD_SEAM_TABLE = 12,   /* seam pairs are out of range, repeated, or do not name the lowest index first */
    DGM_SEAM_GAP = 13,         /* copies of one weld class differ */
    DGM_NOT_FINITE = 14,       /* a position on the surface is NaN or infinite */
    DGM_MISSING_LAYER = 15,    /* the chart does not have a layer that the call needs */
    DGM_UNKNOWN_LAYER = 16,    /* the file requires a layer that this library does not know */
    DGM_LIMIT_EXCEEDED = 17,   /* beyond a limit of the options, or beyond the address space */
    DGM_BUFFER_TOO_SMALL = 18, /* the caller's memory cannot hold the result */
    DGM_NOT_FOUND = 19,        /* no sample on the surface, no triangle on the ray, no frame yet */
    DGM_UNSUPPORTED = 20,      /* an unknown choice, an option newer than this library, or a platform without files */
    DGM_BUSY = 21              /* a reader was overtaken by the writer too often */
} dgm_code;

/* Receives the outcome of a call; DGM_OK is written too. */
typedef struct dgm_error {
    uint32_t struct_size;
    uint32_t code;        /* dgm_code */
    uint64_t byte_offset; /* place of the faulty field or element in the file, or DGM_NO_OFFSET */
    const char* message;  /* one line in English, static; empty for DGM_OK */
} dgm_error;

/* Returns the name of `code`, a dgm_code, e.g. "BAD_INDEX"; "UNKNOWN" for any other number. The text is static, and the
 * names do not change. Any thread. */
DGM_API const char* dgm_code_name(uint32_t code);

/* -------- Memory -------- */

/* Where a handle takes its memory from. Set both functions, or neither for the C library's heap; one alone gives
 * DGM_BAD_ARGUMENT. The struct is copied; `user` must stay valid until the handle is destroyed. The functions are
 * called while handles are created and destroyed, on the thread that does so. */
typedef struct dgm_allocator {
    uint32_t struct_size;
    void* user; /* passed to both functions */
    /* Returns at least `bytes` bytes, aligned to `alignment` (a power of two, at most 64), or NULL: the call then
     * gives DGM_OUT_OF_MEMORY and leaves nothing behind. */
    void* (*allocate)(void* user, size_t bytes, size_t alignment);
    /* Takes back what `allocate` returned, with the same `bytes`. */
    void (*release)(void* user, void* memory, size_t bytes);
} dgm_allocator;

/* -------- Handles -------- */

/* An open file. Read-only: any number of threads. */
typedef struct dgm_asset dgm_asset;
/* A deformable chart, independent of its asset once created. One thread at a time. */
typedef struct dgm_state dgm_state;
/* The values of a kernel. Read-only: any number of threads. */
typedef struct dgm_table dgm_table;
/* Scratch memory for contacts of one state. Belongs to the thread of that state. */
typedef struct dgm_contact_solver dgm_contact_solver;
/* Shapes from one writer to any number of readers on other threads. */
typedef struct dgm_snapshots dgm_snapshots;

/* -------- Assets and charts -------- */

/* The part of the unit square that a chart covers. */
typedef enum dgm_domain {
    DGM_DOMAIN_SQUARE = 0, /* the whole square: every grid sample is on the surface */
    /* Any shape: a mask says which grid samples are on the surface, and a strip of faces joins them to border
     * samples. */
    DGM_DOMAIN_FREE = 1
} dgm_domain;

/* Element type of a layer. */
typedef enum dgm_element_type {
    DGM_ELEMENT_TYPE_U8 = 1,  /* uint8_t */
    DGM_ELEMENT_TYPE_U16 = 2, /* uint16_t */
    DGM_ELEMENT_TYPE_U32 = 3, /* uint32_t */
    DGM_ELEMENT_TYPE_I16 = 4, /* int16_t */
    DGM_ELEMENT_TYPE_F16 = 5, /* IEEE 754 binary16, as its bits */
    DGM_ELEMENT_TYPE_F32 = 6  /* float */
} dgm_element_type;

/* Limits and choices for opening a file. */
typedef struct dgm_open_options {
    uint32_t struct_size;
    uint32_t verify_hashes;             /* 1: check the hash of every layer now, as dgm_asset_verify() */
    const char* const* required_layers; /* names that every chart must have, else DGM_MISSING_LAYER; NULL: none */
    size_t required_layer_count;        /* number of `required_layers` */
    uint64_t max_file_bytes;            /* longer files give DGM_LIMIT_EXCEEDED; 0: no limit */
    uint32_t max_charts;                /* more charts give DGM_LIMIT_EXCEEDED; 0: 65536 */
    uint32_t max_layers;                /* more layers, of all charts together, give DGM_LIMIT_EXCEEDED; 0: 1048576 */
    uint32_t max_samples;               /* larger charts, grid and border, give DGM_LIMIT_EXCEEDED; 0: 0xFFFFFFFE */
    /* If there are any, only these layers and the tables that every reader needs (seams, diagonals, mask,
     * border_...) are listed, verified and read. NULL: all layers. */
    const char* const* layers;
    size_t layer_count; /* number of `layers` */
} dgm_open_options;

/* Size, place and origin of a chart. */
typedef struct dgm_chart_info {
    uint32_t struct_size;
    uint32_t rows, cols;     /* grid samples: row i runs along u, column j along v */
    uint32_t domain;         /* dgm_domain */
    uint32_t border_samples; /* 0 in a square domain; a chart has rows * cols + border_samples samples */
    uint32_t layer_count;    /* layers that dgm_asset_layer() lists */
    double bbox[6];          /* min x, y, z, then max x, y, z, in the frame of the source mesh */
    double offset[3];        /* source = offset + local: add it to the object's matrix */
    double scale[3];         /* local = scale * value stored in the layer `geometry` */
    const char* method;      /* name of the parameterization, e.g. "stretch"; lives as long as the asset */
} dgm_chart_info;

/* An array of a chart in the asset's own memory: row-major, contiguous, little-endian. `name` and `data` live as
 * long as the asset. */
typedef struct dgm_layer_view {
    uint32_t struct_size;
    uint32_t type;        /* dgm_element_type */
    uint32_t rank;        /* number of dimensions, 1 .. 4 */
    uint32_t known;       /* 0: an optional layer that this library has no rules for */
    uint64_t shape[4];    /* elements in each dimension; 0 beyond `rank` */
    uint64_t file_offset; /* place of `data` in the file */
    const char* name;     /* e.g. "geometry" */
    const void* data;     /* the elements */
    size_t bytes;         /* size of `data` */
} dgm_layer_view;

/* Opens a .dgm file: maps it and checks its header and index. The layers are not read; see dgm_asset_verify() and
 * dgm_chart_validate(). The file must not become shorter while it is open: reading pages beyond its end is a fault
 * (SIGBUS, an access violation). If it is overwritten in place, calls give old values, new values or an error.
 *
 * path       file name, zero-terminated; UTF-8 on Windows, elsewhere the system's own bytes
 * options    NULL: defaults
 * allocator  for the index; NULL: the C library's heap
 * asset      receives the handle
 * Errors: DGM_FILE_MISSING, DGM_READ_FAILED, DGM_UNSUPPORTED (a platform that maps no files), and those of
 * dgm_asset_open_memory(). Cost: O(charts + layers), and the whole file with `verify_hashes`. Any thread. */
DGM_API dgm_code dgm_asset_open(const char* path, const dgm_open_options* options, const dgm_allocator* allocator,
                                dgm_asset** asset, dgm_error* error);

/* Opens a .dgm that is already in memory, as dgm_asset_open() does.
 *
 * data       the bytes of the file, aligned to 16; not copied: keep them alive and unchanged until the asset is
 *            closed. NULL if `bytes` is 0
 * bytes      size of `data`
 * options    NULL: defaults
 * allocator  for the index; NULL: the C library's heap
 * asset      receives the handle
 * Errors: DGM_NOT_DGM, DGM_BAD_VERSION, DGM_TRUNCATED, DGM_HASH_MISMATCH, DGM_BAD_INDEX, DGM_BAD_LAYER,
 * DGM_UNKNOWN_LAYER, DGM_MISSING_LAYER, DGM_LIMIT_EXCEEDED, DGM_OUT_OF_MEMORY, DGM_BAD_ARGUMENT (also for memory
 * that is not aligned). byte_offset names the field or layer at fault. Cost: as dgm_asset_open(). Any thread. */
DGM_API dgm_code dgm_asset_open_memory(const void* data, size_t bytes, const dgm_open_options* options,
                                       const dgm_allocator* allocator, dgm_asset** asset, dgm_error* error);

/* Closes an asset and unmaps its file. Layer views and method names of it become invalid; states stay valid. */
DGM_API void dgm_asset_close(dgm_asset* asset);

/* Checks the bytes of every listed layer against their hashes (XXH3-128).
 *
 * Errors: DGM_HASH_MISMATCH with the offset of the layer. Cost: reads the whole file. Any thread. */
DGM_API dgm_code dgm_asset_verify(const dgm_asset* asset, dgm_error* error);

/* Returns the number of charts; 0 if `asset` is NULL. O(1). Any thread. */
DGM_API uint32_t dgm_asset_chart_count(const dgm_asset* asset);

/* Describes a chart.
 *
 * chart  0 .. dgm_asset_chart_count() - 1
 * info   receives the description
 * Errors: DGM_BAD_ARGUMENT (no such chart). O(1). Any thread. */
DGM_API dgm_code dgm_asset_chart(const dgm_asset* asset, uint32_t chart, dgm_chart_info* info, dgm_error* error);

/* Gives access to layer number `layer` of a chart, in the order of the file.
 *
 * chart  0 .. dgm_asset_chart_count() - 1
 * layer  0 .. dgm_chart_info.layer_count - 1
 * view   receives the layer
 * Errors: DGM_BAD_ARGUMENT (no such chart or layer). O(1). Any thread. */
DGM_API dgm_code dgm_asset_layer(const dgm_asset* asset, uint32_t chart, uint32_t layer, dgm_layer_view* view,
                                 dgm_error* error);

/* Gives access to a layer of a chart by its name, e.g. "texture".
 *
 * chart  0 .. dgm_asset_chart_count() - 1
 * name   zero-terminated
 * view   receives the layer
 * Errors: DGM_MISSING_LAYER (the chart has no such layer, or it was not asked for when the file was opened),
 * DGM_BAD_ARGUMENT (no such chart). Cost: O(layers of the chart). Any thread. */
DGM_API dgm_code dgm_asset_find_layer(const dgm_asset* asset, uint32_t chart, const char* name, dgm_layer_view* view,
                                      dgm_error* error);

/* Checks the values of a chart: positions, mask, diagonals, border samples and faces, first fundamental form,
 * stiffness, mobility and seams. No call of this library can crash on a chart that passes. dgm_state_create() does
 * the same checks; call this for charts that get no state.
 *
 * chart      0 .. dgm_asset_chart_count() - 1
 * allocator  for scratch memory, 4 bytes a sample if the chart has seams; NULL: the C library's heap
 * Errors: DGM_NOT_FINITE, DGM_BAD_VALUE, DGM_BAD_SEAM_TABLE, DGM_SEAM_GAP with the offset of the element;
 * DGM_MISSING_LAYER, DGM_OUT_OF_MEMORY, DGM_BAD_ARGUMENT (no such chart). Cost: O(samples). Any thread. */
DGM_API dgm_code dgm_chart_validate(const dgm_asset* asset, uint32_t chart, const dgm_allocator* allocator,
                                    dgm_error* error);

/* -------- States -------- */

/* Sizes and limits of a state. */
typedef struct dgm_state_options {
    uint32_t struct_size;
    uint32_t max_reach;   /* largest kernel reach b and tracking window a + 1 that will be used: 1 .. 1024; 0: 65 */
    uint64_t max_bytes;   /* a state that needs more gives DGM_LIMIT_EXCEEDED; 0: no limit */
    uint32_t metric;      /* without effect; older versions read it */
    uint32_t max_tools;   /* number of different tools in dgm_tick(): 1 .. 64; 0: 4 */
    uint32_t plain_loops; /* 1: no vector instructions beyond the baseline of the platform */
} dgm_state_options;

/* Creates the deformable copy of a chart. All three shapes are the rest shape at first. The values of the chart are
 * checked as dgm_chart_validate() does.
 *
 * chart      0 .. dgm_asset_chart_count() - 1
 * options    NULL: defaults
 * allocator  NULL: the C library's heap
 * state      receives the handle
 * Errors: those of dgm_chart_validate(); DGM_LIMIT_EXCEEDED, DGM_OUT_OF_MEMORY, DGM_BAD_ARGUMENT (also for options
 * out of range). Cost: O(samples), about 130 bytes a sample. Any thread. */
DGM_API dgm_code dgm_state_create(const dgm_asset* asset, uint32_t chart, const dgm_state_options* options,
                                  const dgm_allocator* allocator, dgm_state** state, dgm_error* error);

/* Destroys a state. Its arrays and class members become invalid. */
DGM_API void dgm_state_destroy(dgm_state* state);

/* Ends all elastic touches and contacts: the present shape becomes the permanent one. Cost: O(touched samples). */
DGM_API void dgm_state_release(dgm_state* state);

/* Ends all touches, plastic ones too: the present and the permanent shape become the rest shape. Cost: O(samples). */
DGM_API void dgm_state_reset(dgm_state* state);

/* Lets elastic touches fade: multiplies the elastic displacement of every sample by exp(-rate * dt). Displacements
 * below 1e-6 mean steps are set to zero.
 *
 * dt    seconds, >= 0
 * rate  1/s, >= 0; infinity: the same as dgm_state_release()
 * Errors: DGM_BAD_ARGUMENT. Cost: O(touched samples). */
DGM_API dgm_code dgm_state_relax(dgm_state* state, float dt, float rate, dgm_error* error);

/* Brings the array of dgm_state_normals() up to date with the present shape. dgm_tick() does so by itself; call this
 * after dgm_deform(), dgm_resolve_contact(), dgm_state_release(), dgm_state_relax() and dgm_state_reset().
 * Cost: O(samples moved since the last update). */
DGM_API void dgm_state_update_normals(dgm_state* state);

/* Gives access to the positions of the present shape: three arrays of floats, one a coordinate, local.
 *
 * xyz  receives the arrays x, y and z, each as long as the value returned; may be NULL
 * Returns the number of samples; 0 if `state` is NULL, and then `xyz` is not written. The arrays stay in place while
 * the state lives. Call this again after dgm_tick() or dgm_state_relax() before you read them: the call brings faded
 * displacements up to date.
 * Cost: O(1), or O(faded samples). */
DGM_API size_t dgm_state_positions(const dgm_state* state, const float* xyz[3]);

/* Gives access to the unit normals, as dgm_state_positions() does to the positions. They are those of the last
 * dgm_tick() or dgm_state_update_normals(). Normals are the area-weighted mean over the triangles around a sample,
 * across seams; a sample without area gets 0.
 *
 * xyz  receives the arrays x, y and z, each as long as the value returned; may be NULL
 * Returns the number of samples; 0 if `state` is NULL. Cost: O(1), or O(faded samples). */
DGM_API size_t dgm_state_normals(const dgm_state* state, const float* xyz[3]);

/* Returns the number of samples, grid and border; 0 if `state` is NULL. O(1). Any thread. */
DGM_API uint32_t dgm_state_sample_count(const dgm_state* state);

/* Returns the mean step in local units: at least 1e-15, and 1 for a surface without area; 0 if `state` is NULL.
 * O(1). Any thread. */
DGM_API float dgm_state_mean_step(const dgm_state* state);

/* Reads the position of one sample of the present shape.
 *
 * sample    0 .. dgm_state_sample_count() - 1
 * position  receives x, y, z, local
 * Errors: DGM_BAD_ARGUMENT (no such sample). Cost: O(1), or O(faded samples). */
DGM_API dgm_code dgm_state_position(const dgm_state* state, uint32_t sample, float position[3], dgm_error* error);

/* Computes the unit normal of one sample from the present shape; it needs no dgm_state_update_normals().
 *
 * sample  0 .. dgm_state_sample_count() - 1
 * normal  receives x, y, z; 0, 0, 0 off the surface and where there is no area
 * Errors: DGM_BAD_ARGUMENT (no such sample). Cost: O(1), or O(faded samples). */
DGM_API dgm_code dgm_state_normal(const dgm_state* state, uint32_t sample, float normal[3], dgm_error* error);

/* Returns the weld class of a sample; DGM_NONE if the sample has no copies, does not exist, or `state` is NULL.
 * O(1). Any thread. */
DGM_API uint32_t dgm_state_class_of(const dgm_state* state, uint32_t sample);

/* Gives access to the samples of a weld class, in ascending order: the first one is the representative.
 *
 * class_id  from dgm_state_class_of()
 * members   receives an array of the state that lives as long as the state; may be NULL
 * Returns the length of the array; 0 if there is no such class or `state` is NULL. O(1). Any thread. */
DGM_API size_t dgm_state_class_members(const dgm_state* state, uint32_t class_id, const uint32_t** members);

/* -------- Vertices and indices -------- */

/* Form of the indices. */
typedef enum dgm_topology {
    DGM_TOPOLOGY_TRIANGLES = 0, /* three indices a triangle */
    DGM_TOPOLOGY_STRIPS = 1     /* triangle strips with DGM_RESTART between them */
} dgm_topology;

/* Format of one number of a vertex attribute. */
typedef enum dgm_vertex_format {
    DGM_VERTEX_FORMAT_F32 = 0, /* float */
    DGM_VERTEX_FORMAT_F16 = 1, /* IEEE 754 binary16, rounded to nearest */
    /* 0 .. 65535, rounded and clamped: normals of -1 .. 1, uv of 0 .. 1, positions as (position - origin) / step. */
    DGM_VERTEX_FORMAT_U16 = 2
} dgm_vertex_format;

/* Size of a mesh. */
typedef struct dgm_mesh_counts {
    uint32_t struct_size;
    uint32_t vertices; /* the number of samples, whatever the level of detail */
    uint64_t indices;  /* restarts of strips count too */
} dgm_mesh_counts;

/* Where vertices go, and the form of the indices. Vertex k is sample k. An attribute of it starts at
 *     data + k * stride + offset of the attribute;
 * any alignment will do. An offset of 0 is the start of the vertex: set the offsets of attributes that you do not want
 * to DGM_NO_ATTRIBUTE. */
typedef struct dgm_vertex_target {
    uint32_t struct_size;
    uint32_t lod_stride;      /* 0 or 1: all quads; k: blocks of at least k x k quads become two triangles each */
    void* data;               /* NULL: write no vertices */
    size_t bytes;             /* size of `data`: at least vertices * stride */
    size_t stride;            /* bytes from one vertex to the next */
    size_t position_offset;   /* to x, y, z: local */
    size_t normal_offset;     /* to x, y, z: unit length */
    size_t uv_offset;         /* to two numbers: along columns, then along rows; the first row is on top */
    uint32_t strips;          /* dgm_topology of the indices; any value other than 0 counts as STRIPS */
    uint32_t position_format; /* dgm_vertex_format */
    uint32_t normal_format;   /* dgm_vertex_format */
    uint32_t uv_format;       /* dgm_vertex_format */
    float origin[3];          /* U16 positions: the position that is stored as 0 */
    float step[3];            /* U16 positions: local units for a step of 1, > 0 */
} dgm_vertex_target;

/* Counts the vertices and indices of a chart at full detail, as triangles.
 *
 * chart   0 .. dgm_asset_chart_count() - 1
 * counts  receives them; may be NULL
 * Errors: DGM_MISSING_LAYER, DGM_BAD_ARGUMENT (no such chart). Cost: O(samples). Any thread. */
DGM_API dgm_code dgm_chart_mesh_counts(const dgm_asset* asset, uint32_t chart, dgm_mesh_counts* counts,
                                       dgm_error* error);

/* Counts the vertices and indices of a chart for a level of detail and a topology.
 *
 * chart       0 .. dgm_asset_chart_count() - 1
 * lod_stride  as dgm_vertex_target.lod_stride
 * strips      dgm_topology; any value other than 0 counts as DGM_TOPOLOGY_STRIPS
 * counts      receives them; may be NULL
 * Errors: DGM_MISSING_LAYER, DGM_BAD_VALUE, DGM_BAD_ARGUMENT (no such chart). Cost: O(samples). Any thread. */
DGM_API dgm_code dgm_chart_mesh_counts_at(const dgm_asset* asset, uint32_t chart, uint32_t lod_stride, uint32_t strips,
                                          dgm_mesh_counts* counts, dgm_error* error);

/* Writes the baked surface of a chart: its vertices, its indices, or both. It needs no state.
 *
 * Triangles are the two of each quad in row-major order, then the border strip, counter-clockwise in (u, v). Blocks
 * of a coarser level replace the quads; the border of the chart keeps all its samples, so that seams and
 * neighbouring charts stay closed at every level. All levels use the same vertices. A vertex off the surface is in
 * no triangle.
 *
 * chart        0 .. dgm_asset_chart_count() - 1
 * vertices     where they go, and the level of detail; NULL: no vertices, full detail, triangles
 * indices      receives the indices; NULL: none
 * index_count  length of `indices`: at least dgm_mesh_counts.indices for this level and topology
 * counts       receives the numbers written; may be NULL
 * Errors: DGM_BUFFER_TOO_SMALL, DGM_BAD_ARGUMENT (an attribute beyond the stride, steps of U16 positions, no such
 * chart), DGM_MISSING_LAYER (geometry, normals), DGM_NOT_FINITE, DGM_BAD_VALUE, DGM_UNSUPPORTED (a format). On failure
 * `vertices->data` and `indices` may be partly written. Cost: O(samples). Any thread. */
DGM_API dgm_code dgm_chart_reconstruct(const dgm_asset* asset, uint32_t chart, const dgm_vertex_target* vertices,
                                       uint32_t* indices, size_t index_count, dgm_mesh_counts* counts,
                                       dgm_error* error);

/* Counts the vertices and indices of a state at full detail, as triangles. They do not change while it is deformed.
 *
 * counts  receives them; may be NULL
 * Errors: DGM_BAD_ARGUMENT. Cost: O(samples). */
DGM_API dgm_code dgm_state_mesh_counts(const dgm_state* state, dgm_mesh_counts* counts, dgm_error* error);

/* Counts the vertices and indices of a state for a level of detail and a topology.
 *
 * lod_stride  as dgm_vertex_target.lod_stride
 * strips      dgm_topology; any value other than 0 counts as DGM_TOPOLOGY_STRIPS
 * counts      receives them; may be NULL
 * Errors: DGM_BAD_ARGUMENT. Cost: O(samples). */
DGM_API dgm_code dgm_state_mesh_counts_at(const dgm_state* state, uint32_t lod_stride, uint32_t strips,
                                          dgm_mesh_counts* counts, dgm_error* error);

/* Writes the present shape of a state, as dgm_chart_reconstruct() writes a chart. Normals are those of the present
 * shape, whether or not dgm_state_update_normals() was called; copies of a weld class get the same bits, or opposite
 * ones where a surface with one side was opened.
 *
 * vertices     where they go, and the level of detail; NULL: no vertices, full detail, triangles
 * indices      receives the indices; NULL: none
 * index_count  length of `indices`: at least dgm_mesh_counts.indices for this level and topology
 * counts       receives the numbers written; may be NULL
 * Errors: DGM_BUFFER_TOO_SMALL, DGM_BAD_ARGUMENT, DGM_UNSUPPORTED, as dgm_chart_reconstruct(). On failure
 * `vertices->data` and `indices` may be partly written. Cost: O(samples). */
DGM_API dgm_code dgm_state_reconstruct(const dgm_state* state, const dgm_vertex_target* vertices, uint32_t* indices,
                                       size_t index_count, dgm_mesh_counts* counts, dgm_error* error);

/* -------- Kernels and touches -------- */

/* How the weight of a touch falls with the distance from the contact. */
typedef enum dgm_kernel_shape {
    DGM_KERNEL_SHAPE_CIRCULAR = 0, /* eq. 7: exp(-distance^2 / sigma) */
    DGM_KERNEL_SHAPE_ELLIPTIC = 1, /* exp(-(x / radius_a)^2 - (y / radius_b)^2), with axes rotated by `angle` */
    DGM_KERNEL_SHAPE_USER = 2      /* the weights in `values`, linear between them */
} dgm_kernel_shape;

/* How the kernel ends at its reach b. */
typedef enum dgm_kernel_end {
    /* Eq. 7 as printed: a square window, with a step of at most exp(-b^2 / sigma) at its rim. */
    DGM_KERNEL_END_PRINTED = 0,
    /* Smooth: value and slope are 0 at distance b, and the weight is 0 beyond. For an elliptic kernel b lies on the
     * longer axis. */
    DGM_KERNEL_END_COMPACT = 1
} dgm_kernel_end;

/* Which samples a touch moves: the distance that replaces that of eq. 7. */
typedef enum dgm_footprint {
    DGM_FOOTPRINT_SURFACE = 0,  /* distance along the rest surface, across seams; weights within 6 % of the peak */
    DGM_FOOTPRINT_METRIC = 1,   /* deprecated: the same as DGM_FOOTPRINT_SURFACE */
    DGM_FOOTPRINT_GEODESIC = 2, /* distance along the rest surface; weights within 1 % of the peak, and slower */
    /* Eq. 7 as printed: distance in grid steps, which is right only where the map is isometric up to scale. Across a
     * seam a touch can move samples far away and tear the shape. */
    DGM_FOOTPRINT_GRID = 3
} dgm_footprint;

/* How long a touch or a contact lasts. */
typedef enum dgm_deform_mode {
    DGM_DEFORM_MODE_ELASTIC = 0, /* adds to the present shape, until it fades or dgm_state_release() ends it */
    DGM_DEFORM_MODE_PLASTIC = 1  /* adds to the permanent shape too, until dgm_state_reset() */
} dgm_deform_mode;

/* The kernel of eq. 7. A kernel has no default: set `reach`, and `sigma`, the radii or `values`, as its shape needs. */
typedef struct dgm_kernel_options {
    uint32_t struct_size;
    uint32_t shape;           /* dgm_kernel_shape */
    uint32_t end;             /* dgm_kernel_end; without effect for DGM_KERNEL_SHAPE_USER */
    uint32_t reach;           /* b of eq. 7, grid steps: 1 .. 1024 */
    float sigma;              /* circular: squared grid steps, 1e-6 .. 1e12. E.g. 16 with a reach of 11 */
    float radius_a, radius_b; /* elliptic: grid steps to the weight 1/e, 1e-3 .. 1e6; their ratio is at most 1e4 */
    float angle;              /* elliptic: radians from the row direction (+i) to axis a, towards +j */
    const float* values;      /* user: weights in -1 .. 1 at equal distances 0 .. b; copied */
    size_t value_count;       /* user: length of `values`, 2 .. 65536 */
} dgm_kernel_options;

/* One push or pull at a sample. */
typedef struct dgm_touch {
    uint32_t struct_size;
    uint32_t sample;       /* the contact; any copy of a weld class will do */
    float displacement[3]; /* d_c, local units: the way of the contact; other samples move by their weight times d_c */
    float d_max;           /* local units, > 0: a longer displacement is shortened to this */
    uint32_t footprint;    /* dgm_footprint */
    uint32_t mode;         /* dgm_deform_mode */
    /* Local length of one grid step of the kernel, 1e-15 .. 1e15; 0: the mean step. The footprint GRID ignores it. */
    float step;
} dgm_touch;

/* Effect of a touch. */
typedef struct dgm_deform_report {
    uint32_t struct_size;
    uint32_t samples;      /* samples in reach; copies count */
    float displacement[3]; /* d_c after it was shortened */
    uint32_t crossed_seam; /* 1: the touch reached across a seam */
    uint32_t truncated;    /* 1: footprint GRID was cut short, because too many sheets meet around a seam node */
} dgm_deform_report;

/* Creates the table of a kernel's values. States and threads may share it.
 *
 * options    the kernel; not NULL
 * allocator  NULL: the C library's heap
 * table      receives the handle
 * Errors: DGM_BAD_ARGUMENT (a value out of range), DGM_UNSUPPORTED (shape or end), DGM_OUT_OF_MEMORY.
 * Cost: O(reach^2) time and memory. Any thread. */
DGM_API dgm_code dgm_table_create(const dgm_kernel_options* options, const dgm_allocator* allocator, dgm_table** table,
                                  dgm_error* error);

/* Destroys a table. */
DGM_API void dgm_table_destroy(dgm_table* table);

/* Returns the kernel's weight at an offset from the contact, in grid steps: `di` along rows, `dj` along columns; 0
 * at and beyond the reach, and if `table` is NULL. O(1). Any thread. */
DGM_API float dgm_table_weight(const dgm_table* table, float di, float dj);

/* Returns the kernel's weight at a distance from the contact, in grid steps: the value that all footprints but GRID
 * use. For an elliptic kernel the distance is along its longer axis. The kernel ends at the reach; with
 * DGM_KERNEL_END_PRINTED it continues into the corners of its square window. Returns 0 beyond its end, for a negative
 * `distance` and if `table` is NULL. O(1). Any thread. */
DGM_API float dgm_table_profile(const dgm_table* table, float distance);

/* Applies one touch, eq. 7: every sample in reach moves by its weight times the displacement. Copies of a weld class
 * move alike. If the chart has the layer `deformation`, the stiffness of a sample (0 .. 1) multiplies its sigma. If it
 * has the layer `contact`, the mobility of a sample (0 .. 1) multiplies its displacement.
 *
 * Touches add up. For a tool that presses elastically, call dgm_state_release() or dgm_state_relax() before the
 * touches of each tick, or use dgm_tick(). Normals need dgm_state_update_normals() afterwards.
 *
 * table   its reach must not exceed dgm_state_options.max_reach
 * touch   the contact and its displacement
 * report  may be NULL
 * Errors: DGM_BAD_ARGUMENT (sample not on the surface, value out of range), DGM_UNSUPPORTED (footprint or mode),
 * DGM_LIMIT_EXCEEDED (footprint GRID: more samples in reach than the state has scratch memory for).
 * Cost: O(reach^2), no allocation. A touch at one of the last two contacts, by a kernel of the same values, skips
 * the search for its footprint. */
DGM_API dgm_code dgm_deform(dgm_state* state, const dgm_table* table, const dgm_touch* touch, dgm_deform_report* report,
                            dgm_error* error);

/* -------- Nearest sample -------- */

/* Finds the sample of the present shape that is nearest to a point, by a search of all samples through boxes. If
 * several are equally near, the lowest index wins.
 *
 * tool      x, y, z, local
 * sample    receives the index; may be NULL
 * distance  receives the distance in local units; may be NULL
 * Errors: DGM_BAD_ARGUMENT, DGM_NOT_FOUND (no sample is on the surface).
 * Cost: O(log samples) near the surface, and O(samples moved since the last search); no allocation. */
DGM_API dgm_code dgm_nearest_sample(dgm_state* state, const float tool[3], uint32_t* sample, float* distance,
                                    dgm_error* error);

/* Finds the nearest sample in a window of (2a + 1) x (2a + 1) samples around `last`, across seams. It misses a
 * nearer sample outside of the window; dgm_track_nearest() does not.
 *
 * tool      x, y, z, local
 * last      a sample on the surface, e.g. the answer of the last tick
 * a         half the side of the window: 0 .. dgm_state_options.max_reach - 1
 * sample    receives the index; may be NULL
 * distance  receives the distance in local units; may be NULL
 * Errors: DGM_BAD_ARGUMENT, DGM_LIMIT_EXCEEDED (more samples in the window than the state has scratch memory for).
 * Cost: O(a^2), no allocation. */
DGM_API dgm_code dgm_track_sample(dgm_state* state, const float tool[3], uint32_t last, uint32_t a, uint32_t* sample,
                                  float* distance, dgm_error* error);

/* Finds the nearest sample of all, as dgm_nearest_sample() does, but faster if it lies in the window around `last`.
 *
 * tool      x, y, z, local
 * last      a sample on the surface, e.g. the answer of the last tick
 * a         half the side of the window: 0 .. dgm_state_options.max_reach - 1
 * sample    receives the index; may be NULL
 * distance  receives the distance in local units; may be NULL
 * lost      receives 1 if the window alone missed the sample, else 0; may be NULL
 * Errors: those of dgm_track_sample(). Cost: that of dgm_track_sample() and of a short search; no allocation. */
DGM_API dgm_code dgm_track_nearest(dgm_state* state, const float tool[3], uint32_t last, uint32_t a, uint32_t* sample,
                                   float* distance, uint32_t* lost, dgm_error* error);

/* Tests whether a tool has entered the surface (paper, section 5.1): it has if tool_vector . normal < 0.
 *
 * tool_vector  x, y, z: from the nearest sample to the tool
 * normal       x, y, z: the normal of that sample, see dgm_state_normal()
 * hit          receives 1 if the tool has entered, else 0
 * Errors: DGM_BAD_ARGUMENT. O(1). Any thread. */
DGM_API dgm_code dgm_hit_test(const float tool_vector[3], const float normal[3], uint32_t* hit, dgm_error* error);

/* -------- Rays -------- */

/* Limits of a ray. */
typedef struct dgm_pick_options {
    uint32_t struct_size;
    uint32_t skip_back_faces; /* 1: ignore triangles seen from the side that their normals point away from */
    float max_distance;       /* local units, > 0; a hit at exactly this distance counts; 0: no limit */
} dgm_pick_options;

/* The triangle that a ray meets first. */
typedef struct dgm_ray_hit {
    uint32_t struct_size;
    uint32_t sample;      /* the corner with the largest weight, as the representative of its weld class */
    uint32_t row, column; /* the quad; DGM_NONE for a face of the border strip */
    uint32_t triangle;    /* number in the quad, 0 or 1; else the row of the layer `border_faces` */
    uint32_t corners[3];  /* samples of the triangle */
    uint32_t front;       /* 1: seen from the side that `normal` points to */
    float barycentric[3]; /* weights of the corners, 0 .. 1; their sum is 1 up to rounding */
    float distance;       /* from the origin, local units, whatever the length of the direction */
    float point[3];       /* where the ray meets the triangle, local */
    float normal[3];      /* unit normal of the flat triangle, on the same side as dgm_state_normals() */
} dgm_ray_hit;

/* Finds the first triangle of the present shape along a ray, border strips included. The test is watertight: no ray
 * slips through an edge, a corner or a seam of a closed surface. Among equally near triangles the first one wins: quads
 * row by row, then the border strip.
 *
 * origin     x, y, z, local; any finite numbers
 * direction  x, y, z; any finite numbers but 0, 0, 0; need not be of unit length
 * options    NULL: both sides, no limit
 * hit        receives the triangle; may be NULL
 * Errors: DGM_NOT_FOUND (no triangle), DGM_BAD_ARGUMENT (a number that is not finite, a direction of 0, a
 * negative max_distance).
 * Cost: O(log samples) for most rays, and O(samples moved since the last search); no allocation. */
DGM_API dgm_code dgm_pick_ray(dgm_state* state, const float origin[3], const float direction[3],
                              const dgm_pick_options* options, dgm_ray_hit* hit, dgm_error* error);

/* -------- Haptic loop -------- */

/* How a tool touches. */
typedef enum dgm_tool_kind {
    DGM_TOOL_KIND_TOUCH = 0, /* presses and slides: displaces the nearest sample along its normal */
    DGM_TOOL_KIND_POKE = 1,  /* presses and sticks: the sample first hit follows the tool until the tool comes out */
    DGM_TOOL_KIND_GRASP = 2  /* the sample nearest at the start follows the tool, in or out, until it is lifted */
} dgm_tool_kind;

/* Which displacement a touching tool asks for. */
typedef enum dgm_contact_rule {
    DGM_CONTACT_RULE_SMOOTH = 0, /* its depth along the normal: the force is continuous in time */
    DGM_CONTACT_RULE_PRINTED = 1 /* as the paper prints it: from the nearest sample to the tool; the force jumps */
} dgm_contact_rule;

/* A tool in a tick. */
typedef struct dgm_tool_input {
    uint32_t struct_size;
    uint32_t tool;     /* number: 0 .. dgm_state_options.max_tools - 1, each at most once a tick */
    uint32_t kind;     /* dgm_tool_kind */
    uint32_t lifted;   /* 1: the tool lets go and does not touch */
    float position[3]; /* local */
} dgm_tool_input;

/* Answer to a tool in a tick. */
typedef struct dgm_tool_output {
    uint32_t struct_size;
    uint32_t sample;       /* nearest sample of the permanent shape; exact */
    float distance;        /* to that sample, local units */
    uint32_t hit;          /* 1: the tool has entered the permanent shape there */
    uint32_t lost;         /* 1: all samples had to be searched for the nearest one */
    uint32_t holding;      /* 1: the tool is in contact, or grasps */
    uint32_t contact;      /* the sample that it displaces, or DGM_NONE */
    float displacement[3]; /* way of that sample, at most d_max long */
    float force[3];        /* eqs. 8-10, see dgm_contact_force() */
} dgm_tool_output;

/* Settings of a tick. d_max has no default. */
typedef struct dgm_tick_options {
    uint32_t struct_size;
    uint32_t footprint;    /* dgm_footprint */
    uint32_t mode;         /* dgm_deform_mode */
    uint32_t rule;         /* dgm_contact_rule */
    uint32_t skip_normals; /* 1: do not bring dgm_state_normals() up to date */
    float dt;              /* seconds since the last tick; 0: 0.001 */
    float d_max;           /* largest displacement, local units, > 0 */
    float f_max;           /* largest force on each axis, >= 0; its unit is that of the forces */
    /* Where no tool is in contact, elastic displacement fades by exp(-relax_rate * dt), 1/s. 0: it springs back at
     * once; negative: it stays. */
    float relax_rate;
    /* DGM_CONTACT_RULE_SMOOTH: time constant in which jumps of the displacement fade, seconds. 0: 0.01; negative:
     * jumps pass at once. */
    float settle_time;
    float grasp_distance; /* a grasp farther away than this has no effect, local units; 0: four mean steps */
    float step;           /* as dgm_touch.step */
} dgm_tick_options;

/* Effect of a tick. */
typedef struct dgm_tick_report {
    uint32_t struct_size;
    uint32_t contacts;     /* tools that displace a sample */
    uint32_t samples;      /* samples in reach of them, summed over the tools */
    uint32_t crossed_seam; /* 1: a touch reached across a seam */
    uint32_t truncated;    /* 1: as dgm_deform_report.truncated */
} dgm_tick_report;

/* Runs one turn of the haptic loop: tracks the tools, tests for hits, computes forces, deforms, and updates the
 * normals. The present shape becomes the permanent shape, the rest of earlier elastic touches, and the displacement
 * of every tool in contact. Tools are tracked against the permanent shape, not against the dent that they make.
 *
 * table       the kernel; its reach must not exceed dgm_state_options.max_reach
 * options     d_max at least; not NULL
 * tools       the tools that are near; tools that are not named do not touch. NULL if `tool_count` is 0
 * tool_count  0 .. 64
 * outputs     receives one element for each tool; may be NULL
 * report      may be NULL
 * Errors: DGM_BAD_ARGUMENT (a value out of range, a tool number too high or named twice), DGM_UNSUPPORTED (kind,
 * rule, footprint or mode), DGM_NOT_FOUND (no sample is on the surface). DGM_LIMIT_EXCEEDED (as dgm_deform()): some
 * of the tools may already have moved the state, and `outputs` is not written.
 * Cost: O(footprint) for each tool; no allocation, no lock, no system call. */
DGM_API dgm_code dgm_tick(dgm_state* state, const dgm_table* table, const dgm_tick_options* options,
                          const dgm_tool_input* tools, size_t tool_count, dgm_tool_output* outputs,
                          dgm_tick_report* report, dgm_error* error);

/* Computes the force at a tool, eqs. 8-10: f = -(d / d_max)^3 * f_max on each axis; d is first clamped to
 * -d_max .. d_max on each axis.
 *
 * d      x, y, z: displacement of the contact, local units
 * d_max  largest displacement, local units, > 0
 * f_max  largest force on each axis, >= 0, in any unit
 * force  receives x, y, z in the unit of f_max
 * Errors: DGM_BAD_ARGUMENT. O(1). Any thread. */
DGM_API dgm_code dgm_contact_force(const float d[3], float d_max, float f_max, float force[3], dgm_error* error);

/* -------- Contact -------- */

/* Shape of an obstacle. */
typedef enum dgm_obstacle_kind {
    DGM_OBSTACLE_KIND_PLANE = 0,   /* a half space: it fills the side where (p - point) . normal < 0 */
    DGM_OBSTACLE_KIND_SPHERE = 1,  /* `radius` around `point` */
    DGM_OBSTACLE_KIND_CAPSULE = 2, /* `radius` around the segment from `point` to `end` */
    DGM_OBSTACLE_KIND_BOX = 3,     /* `half` sides around `point`, rotated by `rotation` */
    DGM_OBSTACLE_KIND_SURFACE = 4  /* the present shape of another state */
} dgm_obstacle_kind;

/* How the surface around a contact bulges. */
typedef enum dgm_bulge {
    DGM_BULGE_EXACT = 0, /* so that the volume stays what it was before the contact */
    DGM_BULGE_PAPER = 1, /* eq. 11 as printed: keeps no volume, and grows with the number of samples */
    DGM_BULGE_NONE = 2   /* not at all */
} dgm_bulge;

/* Outcome of a contact. */
typedef enum dgm_contact_status {
    DGM_CONTACT_STATUS_CLEAR = 0,    /* no sample is in the obstacle; the shape is unchanged */
    DGM_CONTACT_STATUS_CONTACT = 1,  /* samples were projected onto the obstacle, and the surface bulges if asked to */
    DGM_CONTACT_STATUS_RESTORED = 2, /* a limit was exceeded; the shape is unchanged, bit for bit */
    DGM_CONTACT_STATUS_OPEN = 3      /* the surface encloses no volume: samples were projected and smoothed */
} dgm_contact_status;

/* A body to press a state against, in the local coordinates of that state. */
typedef struct dgm_obstacle {
    uint32_t struct_size;
    uint32_t kind;      /* dgm_obstacle_kind */
    float point[3];     /* plane: any point of it; sphere, box: centre; capsule: one end; surface: its own origin */
    float normal[3];    /* plane: towards the free side, of any length but 0 */
    float end[3];       /* capsule: the other end */
    float radius;       /* sphere, capsule: > 0 */
    float half[3];      /* box: half of each side, > 0 */
    float rotation[9];  /* box, surface: rotation from its own frame to the state's, row by row; all 0: none */
    dgm_state* surface; /* surface: another state, on the same thread; its shape is not changed */
    /* Surface: a sample farther behind it than this is taken to be on its other side, local units. 0: no limit for a
     * closed surface, four of its mean steps for an open one. */
    float reach;
    /* Surface, in dgm_physics_step() and dgm_cloth_step(): where its samples were in the step before, as copies of
     * dgm_state_positions() from then, dgm_state_sample_count() floats each. Friction goes with a skin that bends and
     * stretches, then, and the substeps of cloth meet its samples on their way; without (NULL), friction goes with the
     * frame alone. Read during the call. */
    const float* before[3];
} dgm_obstacle;

/* Row of the paper's table: the size of the bulge by the sum D of all displacements. */
typedef struct dgm_ring_size {
    uint32_t struct_size;
    float total; /* the row applies to D up to this; the last row to any D */
    float reach; /* R: width of the ring around the contact, local units, 1e-15 .. 1e18 */
    float sigma; /* width of the bulge exp(-s^2 / sigma), local units squared, 1e-30 .. 1e36 */
} dgm_ring_size;

/* Settings of a contact. All 0: exact volume, elastic, no limits. */
typedef struct dgm_contact_options {
    uint32_t struct_size;
    uint32_t bulge;        /* dgm_bulge; closed surfaces only */
    uint32_t mode;         /* dgm_deform_mode */
    uint32_t smoothing;    /* open surfaces: rounds of averaging in the ring, 1 .. 64; 0: 8 */
    uint32_t no_smoothing; /* 1: no rounds, whatever `smoothing` */
    float max_depth;       /* dS_max: the farthest that one sample may move, local units; 0 or infinity: no limit */
    float max_total;       /* dT_max: the farthest that all samples together may move; 0 or infinity: no limit */
    /* Sizes of the ring, at most 16, in ascending order of `total`. NULL: R is half the radius of a disk as large as
     * the contact, but at least two mean steps, and sigma is R^2 / 4. */
    const dgm_ring_size* rings;
    size_t ring_count; /* length of `rings` */
} dgm_contact_options;

/* Effect of a contact. */
typedef struct dgm_contact_report {
    uint32_t struct_size;
    uint32_t status;          /* dgm_contact_status */
    uint32_t volume_kept;     /* 1: |volume_error| <= 1e-6; never for an open surface */
    uint32_t sunk;            /* 1: samples that may not move (mobility) are still in the obstacle */
    uint32_t samples;         /* samples in contact; a weld class counts once, as in `total` */
    uint32_t ring;            /* bulged samples; copies count */
    uint32_t passes;          /* bulged volumes that were computed or measured */
    float deepest;            /* largest displacement of a sample, local units */
    float total;              /* D: the sum of all displacements, local units */
    float ring_reach;         /* R in use, local units */
    float ring_sigma;         /* sigma in use, local units squared */
    float beta;               /* height of the bulge at the rim of the contact, local units */
    double removed;           /* volume that the projection removed; positive for outward normals */
    double volume_error;      /* volume gained by the whole call, divided by `removed` */
    double first_order_error; /* the same if beta came from the gradient of the volume alone */
    double paper_error;       /* the same for eq. 11 as printed */
} dgm_contact_report;

/* Creates the scratch memory for contacts of one state.
 *
 * state      the state that will be pressed
 * allocator  NULL: the C library's heap
 * solver     receives the handle
 * Errors: DGM_OUT_OF_MEMORY, DGM_BAD_ARGUMENT. Cost: O(samples), about 40 bytes a sample and 50 KB. */
DGM_API dgm_code dgm_contact_solver_create(const dgm_state* state, const dgm_allocator* allocator,
                                           dgm_contact_solver** solver, dgm_error* error);

/* Destroys a solver. */
DGM_API void dgm_contact_solver_destroy(dgm_contact_solver* solver);

/* Returns 1 if the surface is closed, so that it encloses a volume: every edge has two sides, once seams are joined.
 * Else 0, also if `solver` is NULL. O(1). */
DGM_API uint32_t dgm_contact_solver_closed(const dgm_contact_solver* solver);

/* Returns the volume that the present shape encloses, local units cubed, negative for inward normals; 0 for an open or
 * one-sided surface, for a state of another size than the solver's, and if a pointer is NULL. Cost: O(samples). */
DGM_API double dgm_contact_solver_volume(const dgm_contact_solver* solver, const dgm_state* state);

/* Gives the volume that the present shape encloses, as dgm_contact_solver_volume(), but refuses by name.
 *
 * volume  receives the volume, local units cubed; unchanged on an error
 *
 * Returns DGM_UNSUPPORTED if the surface has a border or one side only (the message says which), DGM_BAD_ARGUMENT if a
 * pointer is NULL or the solver was made for a state of another size. Cost: O(samples). */
DGM_API dgm_code dgm_contact_solver_enclosed_volume(const dgm_contact_solver* solver, const dgm_state* state,
                                                    double* volume, dgm_error* error);

/* Moves the present shape out of an obstacle (paper, section 6): samples in it are projected onto its border, and
 * the surface around them bulges. Copies of a weld class stay equal; the mobility of a sample scales its
 * displacement. A depth below 2e-7 of the largest coordinate counts as none, so that a shape at rest stays
 * unchanged. Normals need dgm_state_update_normals() afterwards.
 *
 * solver    created for this state
 * obstacle  not NULL
 * options   NULL: exact volume, elastic, no limits
 * report    may be NULL; read its `status`: a contact that exceeds a limit is no error
 * Errors: DGM_BAD_ARGUMENT (a value out of range, a matrix that is no rotation, an obstacle that is the state
 * itself, a solver of another state), DGM_UNSUPPORTED (kind, bulge or mode), DGM_NOT_FOUND (a surface without
 * triangles).
 * Cost: O(samples in contact and in the ring), times a search for a surface; no allocation. */
DGM_API dgm_code dgm_resolve_contact(dgm_state* state, const dgm_contact_solver* solver, const dgm_obstacle* obstacle,
                                     const dgm_contact_options* options, dgm_contact_report* report, dgm_error* error);

/* Measures the distance of a point from an obstacle; exact to the triangles of a surface.
 *
 * obstacle  not NULL
 * point     x, y, z in the frame of the obstacle's coordinates
 * distance  receives the distance, negative inside; may be NULL
 * nearest   receives x, y, z of the nearest point on the obstacle's border; may be NULL
 * Errors: those of the obstacle in dgm_resolve_contact(). O(1), or O(log samples) for a surface, on its thread. */
DGM_API dgm_code dgm_obstacle_distance(const dgm_obstacle* obstacle, const float point[3], float* distance,
                                       float nearest[3], dgm_error* error);

/* -------- Changes of a state -------- */

/* The samples first + r * cols + c for r < rows and c < columns, where `cols` is that of the chart: a rectangle of
 * the grid. If first >= rows * cols of the chart, `rows` is 1 and the range is an interval of border samples. */
typedef struct dgm_changed_range {
    uint32_t struct_size;
    uint32_t first, columns, rows; /* index of the first sample; size of the rectangle */
} dgm_changed_range;

/* Lists the samples whose positions or normals have changed since the last call with the same cursor, so that a
 * renderer uploads those alone.
 *
 * Every changed sample is in a range. Ranges contain more than that: columns are rounded out to multiples of eight,
 * contacts and fading are known by tiles of 8 x 8, and what does not fit into the list is joined to larger ranges.
 * Ranges do not overlap unless they were joined. Normals count as they are: call dgm_state_update_normals() first.
 *
 * cursor    0 before the first call, which then lists all samples; updated by each call. Each reader keeps one of
 *           its own for each state
 * ranges    receives the list; struct_size of the first element counts for all
 * capacity  length of `ranges`: at least 1, or 2 if there are border samples; no more than 256 are used
 * count     receives the number of ranges; 0 if nothing has changed
 * Errors: DGM_BUFFER_TOO_SMALL, DGM_BAD_ARGUMENT; the cursor stays then.
 * Cost: O(1) if nothing has changed, else O(touched samples + rows / 8); no allocation. */
DGM_API dgm_code dgm_state_changed_rows(const dgm_state* state, uint64_t* cursor, dgm_changed_range* ranges,
                                        size_t capacity, size_t* count, dgm_error* error);

/* -------- Snapshots -------- */

/* Sizes and limits of snapshots. */
typedef struct dgm_snapshot_options {
    uint32_t struct_size;
    uint32_t slots;      /* copies kept, 2 .. 16; 0: 3. More of them let slower readers finish */
    uint32_t no_normals; /* 1: positions only */
    uint64_t max_bytes;  /* snapshots that need more give DGM_LIMIT_EXCEEDED; 0: no limit */
} dgm_snapshot_options;

/* The frame that was read. */
typedef struct dgm_snapshot_info {
    uint32_t struct_size;
    uint32_t retries; /* how often the reader was overtaken and started again */
    uint64_t frame;   /* number of the frame, from 1 */
    uint64_t tag;     /* the writer's number for this frame */
} dgm_snapshot_info;

/* Creates snapshots: one thread publishes shapes, and any number of threads read the newest one. Neither side
 * waits for the other.
 *
 * state      any state with the rows, columns and border samples of those that will be published
 * options    NULL: three slots, with normals
 * allocator  NULL: the C library's heap
 * snapshots  receives the handle
 * Errors: DGM_BAD_ARGUMENT (slots), DGM_LIMIT_EXCEEDED, DGM_OUT_OF_MEMORY.
 * Cost: for each slot 12.5 bytes a sample, 24.5 with normals. */
DGM_API dgm_code dgm_snapshots_create(const dgm_state* state, const dgm_snapshot_options* options,
                                      const dgm_allocator* allocator, dgm_snapshots** snapshots, dgm_error* error);

/* Destroys snapshots. No thread may use them any more. */
DGM_API void dgm_snapshots_destroy(dgm_snapshots* snapshots);

/* Publishes the present shape and the normals (of the last dgm_tick() or dgm_state_update_normals()) as a new frame.
 *
 * state  of the same rows, columns and border samples as at dgm_snapshots_create()
 * tag    any number for the readers, e.g. the number of the tick
 * frame  receives the number of the frame, from 1; may be NULL
 * Errors: DGM_BAD_ARGUMENT (a state of another size). Cost: O(samples); wait-free, no allocation.
 * Threads: one writer at a time, on the thread of the state. */
DGM_API dgm_code dgm_snapshots_publish(dgm_snapshots* snapshots, const dgm_state* state, uint64_t tag, uint64_t* frame,
                                       dgm_error* error);

/* Returns the number of the newest frame; 0 before the first one and if `snapshots` is NULL. O(1). Any thread. */
DGM_API uint64_t dgm_snapshots_frame(const dgm_snapshots* snapshots);

/* Copies the newest frame: x of all samples, then y, then z. A reader that the writer overtakes starts again, at
 * most 64 times.
 *
 * positions    receives 3 x samples floats; NULL: none
 * normals      receives 3 x samples floats; NULL: none
 * floats_each  length of `positions` and of `normals`: at least 3 * dgm_state_sample_count()
 * info         may be NULL
 * Errors: DGM_NOT_FOUND (no frame yet), DGM_BUFFER_TOO_SMALL, DGM_BAD_ARGUMENT (normals of snapshots without them).
 * DGM_BUSY: overtaken every time; the memory then contains parts of several frames.
 * Cost: O(samples); lock-free, no allocation. Any thread. */
DGM_API dgm_code dgm_snapshots_read(const dgm_snapshots* snapshots, float* positions, float* normals,
                                    size_t floats_each, dgm_snapshot_info* info, dgm_error* error);

/* Brings memory that contains an earlier frame to the newest one: copies the samples that differ and lists them. All
 * samples count as changed if the reader is overtaken, if the frames come from more than one state, or if a state is
 * published to more than four snapshots.
 *
 * positions    as dgm_snapshots_read(), with frame `since`; NULL: none
 * normals      as dgm_snapshots_read(), with frame `since`; NULL: none
 * floats_each  length of `positions` and of `normals`
 * since        dgm_snapshot_info.frame of the last read into this memory; 0, or a frame to come: copy all
 * ranges       receives the samples copied, as dgm_state_changed_rows() lists them
 * capacity     length of `ranges`: at least 1, or 2 if there are border samples; no more than 256 are used
 * count        receives the number of ranges
 * info         may be NULL
 * Errors: those of dgm_snapshots_read(); DGM_BUFFER_TOO_SMALL also for `ranges`. After DGM_BUSY call with `since` 0.
 * Cost: O(copied samples + rows / 8); lock-free, no allocation. Any thread. */
DGM_API dgm_code dgm_snapshots_read_changed(const dgm_snapshots* snapshots, float* positions, float* normals,
                                            size_t floats_each, uint64_t since, dgm_changed_range* ranges,
                                            size_t capacity, size_t* count, dgm_snapshot_info* info, dgm_error* error);

/* -------- Usage -------- */

/* Memory of an asset. */
typedef struct dgm_asset_usage {
    uint32_t struct_size;
    uint64_t mapped_bytes; /* address space; pages are loaded when they are read. 0 for dgm_asset_open_memory() */
    uint64_t heap_bytes;   /* taken from the allocator */
} dgm_asset_usage;

/* Memory of a state, and work that is due. */
typedef struct dgm_state_usage {
    uint32_t struct_size;
    uint32_t samples;        /* grid and border */
    uint32_t active_samples; /* present shape may differ from the permanent one: dgm_state_release() visits these */
    uint32_t dirty_samples;  /* moved since the last update of the normals */
    uint64_t bytes;          /* taken from the allocator, all at creation */
} dgm_state_usage;

/* Reports the memory of an asset.
 *
 * usage  receives it
 * Errors: DGM_BAD_ARGUMENT. O(1). Any thread. */
DGM_API dgm_code dgm_asset_get_usage(const dgm_asset* asset, dgm_asset_usage* usage, dgm_error* error);

/* Reports the memory of a state, and how much of it the next calls have to visit.
 *
 * usage  receives it
 * Errors: DGM_BAD_ARGUMENT. Cost: O(1), or O(faded samples). */
DGM_API dgm_code dgm_state_get_usage(const dgm_state* state, dgm_state_usage* usage, dgm_error* error);

#ifdef __cplusplus
}
#endif
