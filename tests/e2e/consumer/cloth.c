/* SPDX-License-Identifier: GPL-3.0-or-later */
/* tests/e2e/consumer/cloth.c: hangs a tube of cloth by its last row, lets it fall on a plane, presses a ball on it,
 * and asks for what must be refused. Exit 0 if all is as expected. */
#include <dgm/dgm.h>
#include <dgm/dgm_cloth.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define MOST_PINS 256

static int fail(const char* what, const dgm_error* error) {
    fprintf(stderr, "%s: %s: %s\n", what, dgm_code_name(error->code), error->message);
    return 1;
}

/* The least z of a state. */
static float lowest(const dgm_state* state) {
    const float* xyz[3];
    const size_t count = dgm_state_positions(state, xyz);
    float least = xyz[2][0];
    size_t k;
    for (k = 1; k < count; ++k)
        if (xyz[2][k] < least) least = xyz[2][k];
    return least;
}

/* Takes some frames. */
static dgm_code run(dgm_state* state, dgm_cloth* cloth, const dgm_cloth_step_options* how, int frames,
                    dgm_cloth_report* report, dgm_error* error) {
    dgm_code code = DGM_OK;
    report->struct_size = sizeof *report;
    while (frames-- > 0 && code == DGM_OK) code = dgm_cloth_step(state, cloth, how, NULL, 0, NULL, report, error);
    return code;
}

/* Two states with two cloths, with and without vectors: the same bits. Leaves the first ones to the caller. */
static int hang(const dgm_asset* asset, dgm_cloth_step_options* how, dgm_pin* pins, uint32_t first, dgm_state** state,
                dgm_cloth** cloth, dgm_error* error) {
    dgm_cloth_options options = {0};
    dgm_cloth_report report = {0};
    dgm_state* other = NULL;
    dgm_cloth* plain = NULL;
    const float *now[3], *then[3];
    float before;
    size_t count, k;
    int c, same = 1;

    options.struct_size = sizeof options;
    options.metres_per_unit = 0.1;
    options.warp = options.weft = 5;
    options.shear = 1;
    if (dgm_state_create(asset, 0, NULL, NULL, state, error) != DGM_OK ||
        dgm_state_create(asset, 0, NULL, NULL, &other, error) != DGM_OK)
        return fail("state", error);
    if (dgm_cloth_create(*state, &options, NULL, cloth, error) != DGM_OK) return fail("cloth", error);
    options.plain_loops = 1;
    if (dgm_cloth_create(other, &options, NULL, &plain, error) != DGM_OK) return fail("plain cloth", error);
    dgm_state_positions(*state, now);
    for (k = 0; k < how->pin_count; ++k) {
        pins[k].struct_size = sizeof pins[k];
        pins[k].sample = first + (uint32_t)k;
        for (c = 0; c < 3; ++c) pins[k].position[c] = now[c][first + k];
    }
    before = lowest(*state);
    if (run(*state, *cloth, how, 40, &report, error) != DGM_OK) return fail("step", error);
    if (report.clamped != 0 || !(report.kinetic >= 0) || !(report.elastic > 0)) return 20;
    if (!(lowest(*state) < before - 1e-2f)) return 21; /* it stretches */
    if (run(other, plain, how, 40, &report, error) != DGM_OK) return fail("plain step", error);
    count = dgm_state_positions(*state, now);
    dgm_state_positions(other, then);
    for (c = 0; c < 3; ++c) same = same && memcmp(now[c], then[c], count * sizeof(float)) == 0;
    if (!same) return 22;
    for (k = 0; k < how->pin_count; ++k)
        for (c = 0; c < 3; ++c)
            if (fabsf(now[c][first + k] - pins[k].position[c]) > 1e-6f) return 23; /* pins hold */
    dgm_cloth_destroy(plain);
    dgm_state_destroy(other);
    return 0;
}

/* Lets go of the pins over a plane, and presses a ball down on it. */
static int fall(dgm_state* state, dgm_cloth* cloth, dgm_cloth_step_options* how, dgm_error* error) {
    dgm_obstacle floor = {0};
    dgm_cloth_report report = {0};
    dgm_tool_input tool = {0};
    dgm_step_tool answer = {0};
    const float* xyz[3];
    size_t k, count, top = 0;

    floor.struct_size = sizeof floor;
    floor.kind = DGM_OBSTACLE_KIND_PLANE;
    floor.normal[2] = 1;
    floor.point[2] = lowest(state) - 0.2f;
    how->obstacles = &floor;
    how->obstacle_count = 1;
    how->pin_count = 0;
    if (run(state, cloth, how, 60, &report, error) != DGM_OK) return fail("fall", error);
    if (report.contacts == 0) return 30;
    if (lowest(state) < floor.point[2] - 1e-3f) return 31;
    count = dgm_state_positions(state, xyz);
    for (k = 1; k < count; ++k)
        if (xyz[2][k] > xyz[2][top]) top = k;
    tool.struct_size = sizeof tool;
    tool.kind = DGM_TOOL_KIND_TOUCH;
    for (k = 0; k < 3; ++k) tool.position[k] = xyz[k][top];
    tool.position[2] += 0.15f;
    how->tool_radius = 0.2f;
    answer.struct_size = sizeof answer;
    if (dgm_cloth_step(state, cloth, how, &tool, 1, &answer, &report, error) != DGM_OK) return fail("tool", error);
    if (answer.contacts == 0 || !(answer.force[2] > 0)) return 32; /* it pushes the ball up */
    return 0;
}

/* What is refused changes nothing. */
static int refuse(dgm_state* state, dgm_cloth* cloth, dgm_cloth_step_options* how, dgm_error* error) {
    dgm_cloth_options options = {0};
    dgm_cloth* none = NULL;
    const float* xyz[3];
    float before, after;

    options.struct_size = sizeof options;
    options.metres_per_unit = 0.1;
    options.density = -1;
    if (dgm_cloth_create(state, &options, NULL, &none, error) != DGM_BAD_ARGUMENT || none != NULL) return 40;
    options.density = 0;
    options.max_bytes = 1000;
    if (dgm_cloth_create(state, &options, NULL, &none, error) != DGM_LIMIT_EXCEEDED || none != NULL) return 41;
    if (dgm_cloth_create(NULL, NULL, NULL, &none, error) != DGM_BAD_ARGUMENT) return 42;
    dgm_state_positions(state, xyz);
    before = xyz[2][5];
    how->dt = -1;
    if (dgm_cloth_step(state, cloth, how, NULL, 0, NULL, NULL, error) != DGM_BAD_ARGUMENT) return 43;
    how->dt = 0;
    how->substeps = 1000;
    if (dgm_cloth_step(state, cloth, how, NULL, 0, NULL, NULL, error) != DGM_BAD_ARGUMENT) return 44;
    dgm_state_positions(state, xyz);
    after = xyz[2][5];
    how->substeps = 0;
    if (memcmp(&before, &after, sizeof before) != 0) return 45;
    if (dgm_cloth_take_shape(cloth, state, error) != DGM_OK) return fail("take shape", error);
    return 0;
}

int main(int argc, char** argv) {
    dgm_error error = {0};
    dgm_chart_info info = {0};
    dgm_asset* asset = NULL;
    dgm_state* state = NULL;
    dgm_cloth* cloth = NULL;
    dgm_cloth_step_options how = {0};
    dgm_pin pins[MOST_PINS];
    int code;

    error.struct_size = sizeof error;
    info.struct_size = sizeof info;
    how.struct_size = sizeof how;
    memset(pins, 0, sizeof pins);
    if (argc != 2 || dgm_abi_version() != DGM_ABI_VERSION) return 2;
    if (dgm_asset_open(argv[1], NULL, NULL, &asset, &error) != DGM_OK) return fail("open", &error);
    if (dgm_asset_chart(asset, 0, &info, &error) != DGM_OK) return fail("chart", &error);
    how.gravity[2] = -9.81f;
    how.pins = pins;
    how.pin_count = info.cols - 1; /* the last one of a row is the first one's copy */
    if (how.pin_count > MOST_PINS) return 3;
    code = hang(asset, &how, pins, (info.rows - 1) * info.cols, &state, &cloth, &error);
    if (code == 0) code = fall(state, cloth, &how, &error);
    if (code == 0) code = refuse(state, cloth, &how, &error);
    if (code != 0) fprintf(stderr, "cloth: %d\n", code);
    dgm_cloth_destroy(cloth);
    dgm_state_destroy(state);
    dgm_asset_close(asset);
    return code;
}
