/* SPDX-License-Identifier: GPL-3.0-or-later */
/* tests/e2e/consumer/engine.c: what an engine does with a map; docs/engines.md explains it with these very lines.
 * gpu_buffer stands for the engine's vertex and index buffers. Exit 0 if the buffers hold what they should.
 */
#include <dgm/dgm.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FLOATS 8 /* a vertex: position, normal, uv */

typedef struct gpu_buffer {
    unsigned char* bytes;
    size_t size, uploaded;
} gpu_buffer;

static void gpu_write(gpu_buffer* buffer, size_t offset, const void* data, size_t size) {
    if (buffer->bytes == NULL || offset + size > buffer->size) exit(20);
    memcpy(buffer->bytes + offset, data, size);
    buffer->uploaded += size;
}

static gpu_buffer gpu_create(const void* data, size_t size) {
    gpu_buffer buffer = {0};
    buffer.bytes = malloc(size);
    buffer.size = size;
    gpu_write(&buffer, 0, data, size);
    return buffer;
}

static void check(dgm_code code, const dgm_error* error) {
    if (code == DGM_OK) return;
    fprintf(stderr, "%s: %s\n", dgm_code_name(error->code), error->message);
    exit(1);
}

/* Load: one vertex buffer for all levels of detail, one index buffer a level. */
static size_t load_vertices(const dgm_state* state, gpu_buffer* out) {
    dgm_error error = {.struct_size = sizeof error};
    dgm_mesh_counts counts = {.struct_size = sizeof counts};
    dgm_vertex_target target = {.struct_size = sizeof target, .stride = FLOATS * sizeof(float)};
    check(dgm_state_mesh_counts(state, &counts, &error), &error);
    target.bytes = counts.vertices * target.stride;
    target.data = malloc(target.bytes);
    target.normal_offset = 3 * sizeof(float);
    target.uv_offset = 6 * sizeof(float);
    if (target.data == NULL) exit(2);
    check(dgm_state_reconstruct(state, &target, NULL, 0, NULL, &error), &error);
    *out = gpu_create(target.data, target.bytes);
    free(target.data);
    return counts.vertices;
}

static size_t load_indices(const dgm_state* state, uint32_t lod_stride, gpu_buffer* out) {
    dgm_error error = {.struct_size = sizeof error};
    dgm_mesh_counts counts = {.struct_size = sizeof counts};
    dgm_vertex_target none = {.struct_size = sizeof none, .lod_stride = lod_stride};
    uint32_t* indices;
    check(dgm_state_mesh_counts_at(state, lod_stride, 0, &counts, &error), &error);
    indices = malloc((size_t)counts.indices * sizeof *indices);
    if (indices == NULL) exit(2);
    check(dgm_state_reconstruct(state, &none, indices, (size_t)counts.indices, NULL, &error), &error);
    *out = gpu_create(indices, (size_t)counts.indices * sizeof *indices);
    free(indices);
    return (size_t)counts.indices;
}

/* Each frame: upload what changed since *cursor, which is 0 before the first one. */
static size_t upload_changes(dgm_state* state, size_t cols, uint64_t* cursor, gpu_buffer* vertices) {
    dgm_error error = {.struct_size = sizeof error};
    dgm_changed_range ranges[16] = {{.struct_size = sizeof ranges[0]}};
    const float *position[3], *normal[3];
    size_t count, r, row, k, samples_sent = 0;
    dgm_state_update_normals(state); /* where touched */
    check(dgm_state_changed_rows(state, cursor, ranges, 16, &count, &error), &error);
    dgm_state_positions(state, position);
    dgm_state_normals(state, normal);
    for (r = 0; r < count; ++r)
        for (row = 0; row < ranges[r].rows; ++row) {
            const size_t first = ranges[r].first + row * cols, end = first + ranges[r].columns;
            for (k = first; k < end; ++k) { /* uv stays; an engine maps the buffer once and writes rows into it */
                const float vertex[6] = {position[0][k], position[1][k], position[2][k],
                                         normal[0][k],   normal[1][k],   normal[2][k]};
                gpu_write(vertices, k * FLOATS * sizeof(float), vertex, sizeof vertex);
            }
            samples_sent += ranges[r].columns;
        }
    return samples_sent;
}

int main(int argc, char** argv) {
    dgm_error error = {.struct_size = sizeof error};
    dgm_chart_info info = {.struct_size = sizeof info};
    dgm_kernel_options kernel = {.struct_size = sizeof kernel, .sigma = 4, .reach = 3};
    dgm_touch touch = {.struct_size = sizeof touch, .d_max = 0.5f, .displacement = {-0.25f, 0, 0}};
    const float tool[3] = {0.9f, 0.01f, 1.0f};
    dgm_asset* asset = NULL;
    dgm_state* state = NULL;
    dgm_table* table = NULL;
    gpu_buffer vertices, indices[2], fresh;
    size_t count, sent, fine, coarse, k;
    uint64_t cursor = 0;

    if (argc != 2) return 2;
    check(dgm_asset_open(argv[1], NULL, NULL, &asset, &error), &error);
    check(dgm_asset_chart(asset, 0, &info, &error), &error); /* info.offset goes into the object's matrix */
    check(dgm_state_create(asset, 0, NULL, NULL, &state, &error), &error);
    check(dgm_table_create(&kernel, NULL, &table, &error), &error);
    count = load_vertices(state, &vertices);
    fine = load_indices(state, 1, &indices[0]);
    coarse = load_indices(state, 4, &indices[1]);
    if (coarse == 0 || coarse >= fine) return 3;
    if (upload_changes(state, info.cols, &cursor, &vertices) != count) return 4; /* at first all of it */
    if (upload_changes(state, info.cols, &cursor, &vertices) != 0) return 5;

    check(dgm_nearest_sample(state, tool, &touch.sample, NULL, &error), &error);
    check(dgm_deform(state, table, &touch, NULL, &error), &error);
    sent = upload_changes(state, info.cols, &cursor, &vertices);
    /* what is nearer than b = 3 mean steps and one more for normals, on both sides of the seam, columns by eight */
    if (sent == 0 || 3 * sent > count) return 6;
    if (upload_changes(state, info.cols, &cursor, &vertices) != 0) return 8;
    load_vertices(state, &fresh); /* all anew: the buffer must hold the same */
    for (k = 0; k < count * FLOATS; ++k) {
        const float now = ((const float*)(void*)fresh.bytes)[k], sent = ((const float*)(void*)vertices.bytes)[k];
        if (k % FLOATS >= 3 && k % FLOATS < 6 ? fabsf(now - sent) > 1e-4f : now != sent) return 7;
    }
    printf("%u of %u samples\n", (unsigned)sent, (unsigned)count);
    free(vertices.bytes);
    free(fresh.bytes);
    free(indices[0].bytes);
    free(indices[1].bytes);
    dgm_table_destroy(table);
    dgm_state_destroy(state);
    dgm_asset_close(asset);
    return 0;
}
