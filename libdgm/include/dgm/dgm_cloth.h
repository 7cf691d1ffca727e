/* SPDX-License-Identifier: MIT */
/* libdgm/include/dgm/dgm_cloth.h */
/* C interface of libdgm_cloth: gives a chart the mass and material of cloth. The rules of dgm.h hold here, too: sized
 * structs, codes, handles, memory. docs/cloth.md has the model; cloth.h is the C++ interface with the same functions.
 * Pins and answers to tools are those of dgm_physics.h, which need not be linked. */
#pragma once
#include <dgm/dgm_physics.h>

#if defined(_WIN32) && defined(DGM_BUILD_CLOTH)
#define DGM_CLOTH_API __declspec(dllexport)
#elif defined(_WIN32) && !defined(DGM_STATIC)
#define DGM_CLOTH_API __declspec(dllimport)
#elif !defined(DGM_CLOTH_API)
#define DGM_CLOTH_API DGM_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Stencils of all strides, velocities and place of one cloth. */
typedef struct dgm_cloth dgm_cloth;

/* Fabric of a dgm_cloth. SI units. What is 0 is what the layer `material` says; without one, what is written below. */
typedef struct dgm_cloth_options {
    uint32_t struct_size;
    float warp;             /* N/m along columns of the map, 1e-3 .. 1e9. 0: 2000 */
    float weft;             /* N/m along rows, 1e-3 .. 1e9. 0: 2000 */
    float cross;            /* N/m, at most 0.95 sqrt(warp weft). 0: none; negative: none, whatever the layer says */
    float shear;            /* N/m, 1e-6 .. 1e9. 0: 400 */
    float bending;          /* N m, up to 1e9. 0: 1e-5; negative: none */
    float density;          /* kg/m^2, 1e-6 .. 1e6. 0: 0.2 */
    float damping;          /* 1/s, up to 1e6. 0: 0.5; negative: none */
    float thickness;        /* metres. 0: 1e-3; negative: none */
    double metres_per_unit; /* length of a local unit, 1e-9 .. 1e9. 0: the file's, or DGM_UNSUPPORTED */
    uint64_t max_bytes;     /* DGM_LIMIT_EXCEEDED if more memory is needed. 0: no limit */
    uint32_t self_contact;  /* 1: layers of the cloth keep apart */
    uint32_t plain_loops;   /* 1: no vector instructions beyond the baseline of the platform; same bits */
} dgm_cloth_options;

/* Settings of a frame. */
typedef struct dgm_cloth_step_options {
    uint32_t struct_size;
    uint32_t substeps;             /* 1 .. 100. 0: 2 */
    uint32_t cycles;               /* conjugate gradients in a substep, 1 .. 100. 0: 1 */
    float dt;                      /* seconds a frame, 1e-5 .. 10. 0: 1 / 60 */
    float gravity[3];              /* m/s^2 */
    float friction;                /* Coulomb's coefficient, up to 100. 0: 0.3; negative: none */
    float tool_radius;             /* tools are spheres, local units; > 0 if there are tools */
    const dgm_obstacle* obstacles; /* obstacle_count of them, at most 64 together with the tools */
    size_t obstacle_count;         /* length of the array above */
    const dgm_pin* pins;           /* pin_count of them, at most 256 here; cloth.h takes any number */
    size_t pin_count;              /* length of the array above */
} dgm_cloth_step_options;

/* What a frame did. */
typedef struct dgm_cloth_report {
    uint32_t struct_size;
    uint32_t contacts; /* unknowns that press against obstacles or tools */
    uint32_t touches;  /* pairs of a sample and a triangle of the cloth itself that were kept apart */
    uint32_t clamped;  /* 1: the frame led to numbers that are not finite; nothing moved */
    double kinetic;    /* J */
    double elastic;    /* J */
    double potential;  /* J, of gravity */
    double residual;   /* force left unbalanced over force at the start of the last substep */
} dgm_cloth_report;

/* Makes a cloth of `state`, whose rest shape is taken as free of stress. `options` may be NULL: all defaults;
 * `allocator` may be NULL for the C heap. The handle goes to `cloth`.
 * DGM_BAD_ARGUMENT, DGM_UNSUPPORTED (no unit, a free domain, a mask, a surface with one side, fewer than 3 x 3
 * samples),
 * DGM_LIMIT_EXCEEDED (memory), DGM_OUT_OF_MEMORY. */
DGM_CLOTH_API dgm_code dgm_cloth_create(const dgm_state* state, const dgm_cloth_options* options,
                                        const dgm_allocator* allocator, dgm_cloth** cloth, dgm_error* error);
/* Releases the memory. The state stays as it is. */
DGM_CLOTH_API void dgm_cloth_destroy(dgm_cloth* cloth);
/* Takes the present shape of the state as the cloth's place, without velocity. DGM_BAD_ARGUMENT: another size. */
DGM_CLOTH_API dgm_code dgm_cloth_take_shape(dgm_cloth* cloth, const dgm_state* state, dgm_error* error);
/* Advances `state` by one frame of `cloth` and writes its present shape. `options` may be NULL for the defaults.
 * `tools` and `answers` are arrays of tool_count elements; `answers` and `report` may be NULL. Normals need
 * dgm_state_update_normals() afterwards.
 * DGM_BAD_ARGUMENT, DGM_UNSUPPORTED, DGM_LIMIT_EXCEEDED: nothing has been changed then. */
DGM_CLOTH_API dgm_code dgm_cloth_step(dgm_state* state, dgm_cloth* cloth, const dgm_cloth_step_options* options,
                                      const dgm_tool_input* tools, size_t tool_count, dgm_step_tool* answers,
                                      dgm_cloth_report* report, dgm_error* error);

#ifdef __cplusplus
}
#endif
