/* SPDX-License-Identifier: GPL-3.0-or-later */
/* tests/e2e/consumer/consumer.c: maps a file, presses on its seam, prints what it felt. Exit 0 if all is as expected.
 */
#include <dgm/dgm.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int fail(const char* what, const dgm_error* error) {
    fprintf(stderr, "%s: %s: %s (byte %llu)\n", what, dgm_code_name(error->code), error->message,
            (unsigned long long)error->byte_offset);
    return 1;
}

int main(int argc, char** argv) {
    dgm_error error = {0};
    dgm_chart_info info = {0};
    dgm_kernel_options kernel = {0};
    dgm_touch touch = {0};
    dgm_vertex_target target = {0};
    dgm_mesh_counts counts = {0};
    dgm_asset* asset = NULL;
    dgm_state* state = NULL;
    dgm_table* table = NULL;
    dgm_contact_solver* solver = NULL;
    dgm_snapshots* snapshots = NULL;
    dgm_obstacle plane = {0};
    dgm_contact_options contact = {0};
    dgm_contact_report report = {0};
    dgm_state_usage usage = {0};
    dgm_asset_usage mapped = {0};
    dgm_snapshot_info shot = {0};
    uint64_t frame = 0;
    uint32_t* indices;
    const float tool[3] = {0.9f, 0.01f, 1.0f};
    float force[3];
    uint32_t sample = DGM_NONE, i;
    const uint32_t* members = NULL;
    size_t copies;
    float *vertices, first[3], other[3];

    error.struct_size = sizeof error;
    info.struct_size = sizeof info;
    kernel.struct_size = sizeof kernel;
    touch.struct_size = sizeof touch;
    target.struct_size = sizeof target;
    counts.struct_size = sizeof counts;
    plane.struct_size = sizeof plane;
    contact.struct_size = sizeof contact;
    report.struct_size = sizeof report;
    usage.struct_size = sizeof usage;
    mapped.struct_size = sizeof mapped;
    shot.struct_size = sizeof shot;
    if (argc != 2 || dgm_abi_version() != DGM_ABI_VERSION) return 2;

    if (dgm_asset_open(argv[1], NULL, NULL, &asset, &error) != DGM_OK) return fail("open", &error);
    if (dgm_asset_verify(asset, &error) != DGM_OK) return fail("verify", &error);
    if (dgm_asset_chart(asset, 0, &info, &error) != DGM_OK) return fail("chart", &error);
    if (info.rows != 17 || info.cols != 33 || strcmp(info.method, "test") != 0) return 3;
    if (info.domain != DGM_DOMAIN_SQUARE) return 18;
    if (dgm_asset_get_usage(asset, &mapped, &error) != DGM_OK || mapped.mapped_bytes < 17 * 33 * 12) return 10;
    if (dgm_state_create(asset, 0, NULL, NULL, &state, &error) != DGM_OK) return fail("state", &error);
    dgm_asset_close(asset); /* the state stands on its own */

    kernel.shape = DGM_KERNEL_SHAPE_CIRCULAR;
    kernel.reach = 6;
    kernel.sigma = 10;
    if (dgm_table_create(&kernel, NULL, &table, &error) != DGM_OK) return fail("table", &error);
    if (dgm_nearest_sample(state, tool, &sample, NULL, &error) != DGM_OK) return fail("nearest", &error);
    if (sample != 8 * 33) return 4; /* on the seam: the lower of two copies */
    touch.sample = sample;
    touch.displacement[0] = -0.25f;
    touch.d_max = 0.5f;
    touch.footprint = DGM_FOOTPRINT_SURFACE;
    touch.mode = DGM_DEFORM_MODE_ELASTIC;
    if (dgm_deform(state, table, &touch, NULL, &error) != DGM_OK) return fail("deform", &error);
    copies = dgm_state_class_members(state, dgm_state_class_of(state, sample), &members);
    if (copies != 2) return 5;
    dgm_state_position(state, members[0], first, NULL);
    dgm_state_position(state, members[1], other, NULL);
    if (memcmp(first, other, sizeof first) != 0 || fabsf(first[0] - 0.75f) > 1e-6f) return 6;
    if (dgm_contact_force(touch.displacement, touch.d_max, 8, force, &error) != DGM_OK || force[0] != 1.0f) return 7;

    if (dgm_state_mesh_counts(state, &counts, &error) != DGM_OK) return fail("counts", &error);
    vertices = malloc(counts.vertices * 6 * sizeof(float));
    if (vertices == NULL) return 8;
    target.data = vertices;
    target.bytes = counts.vertices * 6 * sizeof(float);
    target.stride = 6 * sizeof(float);
    target.position_format = target.normal_format = DGM_VERTEX_FORMAT_F32;
    target.normal_offset = 3 * sizeof(float);
    target.uv_offset = DGM_NO_ATTRIBUTE;
    if (dgm_state_reconstruct(state, &target, NULL, 0, NULL, &error) != DGM_OK) return fail("reconstruct", &error);
    for (i = 0; i < 3; ++i)
        if (vertices[6 * sample + i] != first[i]) return 9;

    /* A level of detail as strips, a plane pushed through the whole, a snapshot of what is left. */
    if (dgm_state_mesh_counts_at(state, 4, DGM_TOPOLOGY_STRIPS, &counts, &error) != DGM_OK)
        return fail("counts at", &error);
    if (counts.indices == 0 || counts.indices >= 16 * 32 * 6) return 11;
    indices = malloc((size_t)counts.indices * sizeof *indices);
    if (indices == NULL) return 12;
    target.lod_stride = 4;
    target.strips = DGM_TOPOLOGY_STRIPS;
    if (dgm_state_reconstruct(state, &target, indices, (size_t)counts.indices, NULL, &error) != DGM_OK)
        return fail("strips", &error);
    free(indices);
    if (dgm_contact_solver_create(state, NULL, &solver, &error) != DGM_OK) return fail("solver", &error);
    plane.kind = DGM_OBSTACLE_KIND_PLANE;
    plane.normal[0] = -1; /* free where x <= 0.5 */
    plane.point[0] = 0.5f;
    contact.bulge = DGM_BULGE_EXACT;
    contact.max_depth = 0.01f;
    if (dgm_resolve_contact(state, solver, &plane, &contact, &report, &error) != DGM_OK) return fail("contact", &error);
    if (report.status != DGM_CONTACT_STATUS_RESTORED || !(report.deepest > 0.2f)) return 13;
    contact.max_depth = 0;
    if (dgm_resolve_contact(state, solver, &plane, &contact, &report, &error) != DGM_OK) return fail("contact", &error);
    if (report.status == DGM_CONTACT_STATUS_RESTORED || report.samples == 0) return 14;
    if (dgm_snapshots_create(state, NULL, NULL, &snapshots, &error) != DGM_OK) return fail("snapshots", &error);
    if (dgm_snapshots_publish(snapshots, state, 42, &frame, &error) != DGM_OK || frame != 1) return 15;
    if (dgm_snapshots_read(snapshots, vertices, NULL, 17 * 33 * 3, &shot, &error) != DGM_OK || shot.tag != 42)
        return fail("read", &error);
    for (i = 0; i < 17 * 33; ++i)
        if (vertices[i] > 0.5f + 1e-5f) return 16;
    if (dgm_state_get_usage(state, &usage, &error) != DGM_OK || usage.active_samples == 0) return 17;
    dgm_snapshots_destroy(snapshots);
    dgm_contact_solver_destroy(solver);
    printf("%u vertices, force %g\n", (unsigned)counts.vertices, (double)force[0]);
    free(vertices);
    dgm_table_destroy(table);
    dgm_state_destroy(state);
    return 0;
}
