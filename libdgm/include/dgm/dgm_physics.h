/* SPDX-License-Identifier: MIT */
/* libdgm/include/dgm/dgm_physics.h */
/* C interface of libdgm_physics: gives a chart mass and material. The rules of dgm.h hold here, too: sized structs,
 * codes, handles, memory. docs/physics.md has the model; physics.h is the C++ interface with the same functions. */
#pragma once
#include <dgm/dgm.h>

#if defined(_WIN32) && defined(DGM_BUILD_PHYSICS)
#define DGM_PHYSICS_API __declspec(dllexport)
#elif defined(_WIN32) && !defined(DGM_STATIC)
#define DGM_PHYSICS_API __declspec(dllimport)
#elif !defined(DGM_PHYSICS_API)
#define DGM_PHYSICS_API DGM_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Stencils of all strides, displacement and velocities of one state. */
typedef struct dgm_physics dgm_physics;
/* How the shape of a coarse state looks on all samples of the fine one. */
typedef struct dgm_detail dgm_detail;

/* Material and step of a dgm_physics. SI units. What is 0 is the file's (its layer material), or, where the file does
 * not say, what is written below. */
typedef struct dgm_physics_options {
    uint32_t struct_size;
    float membrane;         /* Young's modulus times thickness, N/m: 1e-6 .. 1e12. 0: 200 */
    float poisson;          /* 0 .. 0.49. 0: 0.3; negative: 0 */
    float bending;          /* N m, up to 1e12. 0: 1e-3; negative: none */
    float foundation;       /* N/m^3, up to 1e12. 0: 2e4; negative: none */
    float density;          /* kg/m^2, 1e-6 .. 1e12. 0: 5 */
    float viscosity;        /* s, up to 1e6. 0: none; negative: none, whatever the file says */
    float dt;               /* seconds a step, 1e-5 .. 10. 0: 1e-3 */
    double metres_per_unit; /* length of a local unit, 1e-9 .. 1e9. 0: DGM_UNSUPPORTED */
    uint64_t max_bytes;     /* DGM_LIMIT_EXCEEDED if more memory is needed. 0: no limit */
    uint32_t free_volume;   /* 1: closed surfaces may change their volume */
    uint32_t plain_loops;   /* 1: no vector instructions beyond the baseline of the platform; same bits */
    uint32_t solver;        /* 0: multigrid; 1: factors, for at most 129 x 129 samples, see physics.h */
    uint32_t reserved;      /* 0 */
} dgm_physics_options;

/* A sample that is held at a place. */
typedef struct dgm_pin {
    uint32_t struct_size;
    uint32_t sample;   /* its whole weld class is held */
    float position[3]; /* local coordinates */
} dgm_pin;

/* Settings of a step. */
typedef struct dgm_step_options {
    uint32_t struct_size;
    uint32_t cycles;               /* conjugate gradients, 1 .. 1000. 0: 3 */
    float gravity[3];              /* m/s^2 */
    float tool_radius;             /* tools are spheres, local units; > 0 if there are tools */
    const dgm_obstacle* obstacles; /* obstacle_count of them, at most 64 together with the tools */
    size_t obstacle_count;         /* length of the array above */
    const dgm_pin* pins;           /* pin_count of them, at most 256 here; physics.h takes any number */
    size_t pin_count;              /* length of the array above */
    float tool_layer;              /* N/m^3, 1 .. 1e12: soft layer between surface and tools. 0: contact is hard */
    float friction;                /* Coulomb's coefficient, up to 100, see physics.h. 0: none */
} dgm_step_options;

/* What a step did. */
typedef struct dgm_step_report {
    uint32_t struct_size;
    uint32_t contacts;   /* unknowns that press against obstacles or tools */
    uint32_t cycles;     /* that were run */
    uint32_t clamped;    /* 1: the step led to numbers that are not finite; nothing moved */
    double volume_error; /* volume / rest volume - 1, of closed surfaces that keep it */
    double pressure;     /* Pa, inside over outside */
    double residual;     /* force left unbalanced over force at the start of the step */
    double kinetic;      /* J */
    double elastic;      /* J */
    double layers;       /* J, in the soft layer under tools */
} dgm_step_report;

/* Answer to a tool. */
typedef struct dgm_step_tool {
    uint32_t struct_size;
    uint32_t contacts; /* unknowns in the contact patch */
    float force[3];    /* N, on the tool */
} dgm_step_tool;

/* Makes the physics of `state`, whose rest shape is taken as free of stress. `options` may be NULL: all defaults;
 * `allocator` may be NULL for the C heap. The handle goes to `physics`.
 * DGM_BAD_ARGUMENT, DGM_UNSUPPORTED (no unit, a free domain, a surface with one side, fewer than 3 x 3 samples),
 * DGM_LIMIT_EXCEEDED (memory, or a material that bends over a length beyond the body), DGM_OUT_OF_MEMORY. */
DGM_PHYSICS_API dgm_code dgm_physics_create(const dgm_state* state, const dgm_physics_options* options,
                                            const dgm_allocator* allocator, dgm_physics** physics, dgm_error* error);
/* Releases the memory. The state stays as it is. */
DGM_PHYSICS_API void dgm_physics_destroy(dgm_physics* physics);
/* Changes the length of the next steps to `seconds`, 1e-5 .. 10. No allocation. DGM_BAD_ARGUMENT. */
DGM_PHYSICS_API dgm_code dgm_physics_set_dt(dgm_physics* physics, float seconds, dgm_error* error);
/* Forgets displacement and velocity. */
DGM_PHYSICS_API void dgm_physics_reset(dgm_physics* physics);
/* Advances `state` by one step of `physics` and writes its present shape. `options` may be NULL for the defaults.
 * `tools` and `answers` are arrays of tool_count elements; `answers` and `report` may be NULL. Normals need
 * dgm_state_update_normals() afterwards.
 * DGM_BAD_ARGUMENT, DGM_UNSUPPORTED, DGM_LIMIT_EXCEEDED: nothing has been changed then. */
DGM_PHYSICS_API dgm_code dgm_physics_step(dgm_state* state, dgm_physics* physics, const dgm_step_options* options,
                                          const dgm_tool_input* tools, size_t tool_count, dgm_step_tool* answers,
                                          dgm_step_report* report, dgm_error* error);

/* Level of detail: makes a state of every stride-th row and column of `fine` and the last ones, for physics that is
 * quicker than that of all samples. `options` may be NULL: all defaults; the handle goes to `coarse`, is one like any
 * other and is released by dgm_state_destroy(). physics.h has more.
 * DGM_BAD_ARGUMENT (stride 0, options), DGM_UNSUPPORTED (a free domain, a surface with one side, fewer than 3 x 3
 * samples left, seams of which only one side has a sample at this stride), DGM_LIMIT_EXCEEDED, DGM_OUT_OF_MEMORY. */
DGM_PHYSICS_API dgm_code dgm_state_create_coarse(const dgm_state* fine, uint32_t stride,
                                                 const dgm_state_options* options, const dgm_allocator* allocator,
                                                 dgm_state** coarse, dgm_error* error);
/* Prepares to show `coarse`, made of `fine` with this `stride`, on it. The handle goes to `detail`.
 * DGM_BAD_ARGUMENT (sizes that do not fit), DGM_OUT_OF_MEMORY. */
DGM_PHYSICS_API dgm_code dgm_detail_create(const dgm_state* fine, const dgm_state* coarse, uint32_t stride,
                                           const dgm_allocator* allocator, dgm_detail** detail, dgm_error* error);
/* Releases the memory. Both states stay as they are. */
DGM_PHYSICS_API void dgm_detail_destroy(dgm_detail* detail);
/* Writes the present shape of `fine`: that of `coarse` where both have a sample, the rest shape turned and stretched
 * with it between them. Normals need dgm_state_update_normals() afterwards. No allocation. DGM_BAD_ARGUMENT (other
 * states, by their sizes). */
DGM_PHYSICS_API dgm_code dgm_detail_show(dgm_detail* detail, const dgm_state* coarse, dgm_state* fine,
                                         dgm_error* error);

/* Local compliances: how the body gives way near its tools, from the thread of the physics to a haptic loop. */
typedef struct dgm_compliance dgm_compliance;
/* What one haptic thread has of them. */
typedef struct dgm_compliance_reader dgm_compliance_reader;

/* Sizes and limits of a dgm_compliance. */
typedef struct dgm_compliance_options {
    uint32_t struct_size;
    uint32_t tools;     /* 1 .. 8: tools with smaller numbers are published. 0: 1 */
    uint32_t columns;   /* 1 .. 32: forces on a body by a tool; more samples in touch share them. 0: 16 */
    uint32_t cycles;    /* conjugate gradients of a known column, 1 .. 1000. 0: 2 */
    uint32_t renewed;   /* known columns of a tool computed in a frame, oldest first. 0: 4 */
    uint64_t max_bytes; /* DGM_LIMIT_EXCEEDED if more memory is needed. 0: no limit */
} dgm_compliance_options;

/* What dgm_compliance_publish() did. */
typedef struct dgm_compliance_report {
    uint32_t struct_size;
    uint32_t columns;  /* that were computed */
    uint32_t samples;  /* near the tools */
    uint32_t left_out; /* samples in touch that found no place: forces are too small then */
    uint64_t frame;    /* counts publications from 1 */
} dgm_compliance_report;

/* How a reader works. */
typedef struct dgm_compliance_reader_options {
    uint32_t struct_size;
    uint32_t fade; /* ticks over which a jump of the force between two frames is spread, 0 .. 1000 */
    float damper;  /* N s/m, 0 .. 1e6: most damping while the body has given more energy than it got. 0: none */
    float tick;    /* seconds from tick to tick, 1e-5 .. 1. 0: 1e-3 */
} dgm_compliance_reader_options;

/* Answer of dgm_compliance_tick() to a tool. */
typedef struct dgm_compliance_answer {
    uint32_t struct_size;
    uint32_t contacts; /* columns that press; of a grasp 1 */
    float force[3];    /* N, on the tool */
    uint64_t frame;    /* by which it was answered; 0: nothing has been published */
} dgm_compliance_answer;

/* Makes memory for the compliances of `physics`, made of `state`. `options` and `allocator` may be NULL. The handle
 * goes to `compliance`. DGM_BAD_ARGUMENT, DGM_LIMIT_EXCEEDED, DGM_OUT_OF_MEMORY. */
DGM_PHYSICS_API dgm_code dgm_compliance_create(const dgm_state* state, const dgm_physics* physics,
                                               const dgm_compliance_options* options, const dgm_allocator* allocator,
                                               dgm_compliance** compliance, dgm_error* error);
/* Releases the memory. No reader may be used any more. */
DGM_PHYSICS_API void dgm_compliance_destroy(dgm_compliance* compliance);
/* Publishes how the body answers each tool in its next step. Call it after dgm_physics_step(), in the same thread, with
 * the options of the next step and the tools where they are; `report` may be NULL. No bit of `state` and of what
 * `physics` goes on with changes. Readers are not waited for. No allocation.
 * DGM_BAD_ARGUMENT, DGM_UNSUPPORTED, DGM_LIMIT_EXCEEDED: nothing has been published then. */
DGM_PHYSICS_API dgm_code dgm_compliance_publish(dgm_compliance* compliance, const dgm_state* state,
                                                dgm_physics* physics, const dgm_step_options* options,
                                                const dgm_tool_input* tools, size_t tool_count,
                                                dgm_compliance_report* report, dgm_error* error);
/* Makes a reader for one haptic thread, which must not outlive `compliance`. `options` and `allocator` may be NULL. The
 * handle goes to `reader`. DGM_BAD_ARGUMENT, DGM_OUT_OF_MEMORY. */
DGM_PHYSICS_API dgm_code dgm_compliance_reader_create(const dgm_compliance* compliance,
                                                      const dgm_compliance_reader_options* options,
                                                      const dgm_allocator* allocator, dgm_compliance_reader** reader,
                                                      dgm_error* error);
/* Releases the memory. */
DGM_PHYSICS_API void dgm_compliance_reader_destroy(dgm_compliance_reader* reader);
/* Answers the forces of tools where they are now, by the newest frame: at most 64 of them. `tools` and `answers` are
 * arrays of tool_count elements. No allocation, no locks, no waiting. DGM_BAD_ARGUMENT, DGM_LIMIT_EXCEEDED. */
DGM_PHYSICS_API dgm_code dgm_compliance_tick(dgm_compliance_reader* reader, const dgm_tool_input* tools,
                                             size_t tool_count, dgm_compliance_answer* answers, dgm_error* error);

#ifdef __cplusplus
}
#endif
