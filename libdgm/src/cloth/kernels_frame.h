// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels_frame.h
// Loops of a substep outside the solver. Included by kernels_impl.h.

static DGM_INLINE Doubles eight_of(const double* from) {
    Doubles v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
}
static double start(const StartJob& job) noexcept {
    Doubles sum{};
    for (std::size_t s = 0; s < job.count; s += 8) {
        const Doubles free = eight_at(job.free + s), fall = eight_at(job.fall + s);
        Doubles square{};
        for (int c = 0; c < 3; ++c) {
            const Doubles at = eight_of(job.at[c] + s), go = job.h * eight_at(job.velocity.p[c] + s);
            const double drop = job.h * job.h * job.gravity[c];
            const Doubles to = at + free * (go + drop * fall), led = free * (go + drop);
            __builtin_memcpy(job.was[c] + s, &at, sizeof at);
            __builtin_memcpy(job.at[c] + s, &to, sizeof to);
            put_eight(job.inertial.p[c] + s, free * (drop * (fall - 1)));
            square += led * led;
        }
        sum += eight_at(job.mass + s) * square;
    }
    return sum_of(sum);
}
static void finish(FinishJob& job) noexcept {
    Doubles kinetic{}, moment[3] = {};
    for (std::size_t s = 0; s < job.count; s += 8) {
        const Doubles mass = eight_at(job.mass + s);
        Doubles fell{};
        for (int c = 0; c < 3; ++c) {
            const Doubles at = eight_of(job.at[c] + s), v = job.by_h * (at - eight_of(job.was[c] + s));
            fell += job.direction[c] * (v - eight_at(job.velocity.p[c] + s));
            const Doubles now = job.slow * v;
            put_eight(job.velocity.p[c] + s, now);
            kinetic += mass * (now * now);
            moment[c] += mass * at;
        }
        const Doubles none{}, one = none + 1;
        fell = fell > 0 ? fell : none;
        put_eight(job.fall + s, fell < 1 ? fell : one);
    }
    job.kinetic = 0.5 * sum_of(kinetic);
    for (int c = 0; c < 3; ++c) job.moment[c] = sum_of(moment[c]);
}
static void move(const MoveJob& job) noexcept {
    for (int c = 0; c < 3; ++c)
        for (std::size_t s = 0; s < job.count; s += 8) {
            const Doubles to = eight_of(job.at[c] + s) + job.by * eight_at(job.way.p[c] + s);
            __builtin_memcpy(job.at[c] + s, &to, sizeof to);
        }
}
static void shape(const ShapeJob& job) noexcept {
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t i = 0; i < job.rows; ++i) {
            const double* from = job.at[c] + i * job.pitch;
            float* to = job.to[c] + std::size_t{i} * job.cols;
            std::uint32_t j = 0;
            for (; j + 8 <= job.cols; j += 8) put_eight(to + j, job.by * eight_of(from + j));
            for (; j < job.cols; ++j) to[j] = static_cast<float>(job.by * from[j]);
        }
}
