// SPDX-License-Identifier: MIT
// libdgm/src/rows/patch_rows_impl.h
// Bodies of rows.h that make and press patches. Included after rows_impl.h, under the same rules.

/// Bits of the samples of a row that are there.
static DGM_INLINE std::uint64_t row_bits(std::uint64_t bits, std::uint32_t row) {
    return bits >> (8 * row) & 255;
}

// Single operations, none fused: every variant and every copy of a seam sample gets the same bits.
ChordResult chords(const ChordJob& job, float* d2) noexcept {
    const ChordJob j = job;
    const Floats far = Floats{} + __builtin_inff();
    const float cx = j.centre[0], cy = j.centre[1], cz = j.centre[2];
    const float ax = j.axis[0], ay = j.axis[1], az = j.axis[2];
    Ints lane = {};
    for (int k = 0; k < DGM_LANES; ++k) lane[k] = k;
    Floats doubtful = far;
    Ints steep = {};
    std::uint64_t reach = 0;
    for (std::uint32_t row = 0; row < j.cell.height; ++row)
        for (std::uint32_t first = 0; first < 8; first += DGM_LANES) {
            const std::size_t k = j.cell.first + static_cast<std::size_t>(row) * j.cols + first;
            const Floats x = load<Floats>(j.at.x + k) - cx, y = load<Floats>(j.at.y + k) - cy,
                         z = load<Floats>(j.at.z + k) - cz;
            const Floats nx = load<Floats>(j.normal.x + k), ny = load<Floats>(j.normal.y + k),
                         nz = load<Floats>(j.normal.z + k);
            const Floats c2 = x * x + y * y + z * z;
            const Floats h1 = x * nx + y * ny + z * nz, h0 = j.sharp ? -h1 : x * ax + y * ay + z * az, h12 = h1 * h1;
            const Floats length2 = c2 + (h0 * h0 + h12 + (h0 * h0 + h12 - h0 * h1)) * (1.0f / 15);
            const Floats slant = h12 + load<Floats>(j.rough + k) * c2;
            const Ints in = static_cast<Ints>(length2 < j.reach2) & (lane < static_cast<int>(j.cell.width - first));
            doubtful = (in & static_cast<Ints>(slant > j.slant2 * c2)) != 0 ? lower(doubtful, c2) : doubtful;
            steep |= in & (static_cast<Ints>(slant > kSteep * kSteep * c2) |
                           static_cast<Ints>(nx * ax + ny * ay + nz * az < kTurned));
            store<Floats>(d2 + 8 * static_cast<std::size_t>(row) + first, length2);
            reach |= static_cast<std::uint64_t>(sign_bits(in)) << (8 * row + first);
        }
    return {reach, extreme_lane<false>(doubtful), any(steep)};
}

void profile(const ProfileJob& job, float* values) noexcept {
    const ProfileJob j = job;
    const float last = static_cast<float>(j.last);
    Ints bit = {};
    for (int k = 0; k < DGM_LANES; ++k) bit[k] = 1 << k;
    for (std::uint32_t row = 0; row < 8; ++row) {
        const auto bits = static_cast<int>(row_bits(j.reach, row));
        for (int first = 0; first < 8; first += DGM_LANES) {
            float* at = values + 8 * static_cast<std::size_t>(row) + first;
            if ((bits >> first & ((1 << DGM_LANES) - 1)) == 0) {
                store<Floats>(at, Floats{});
                continue;
            }
            const Floats d = root(load<Floats>(at)) * j.per_step, place = d / j.spacing;
            const Ints in =
                static_cast<Ints>(d < j.end) & static_cast<Ints>(place < last) & ((bit & (bits >> first)) != 0);
            const Ints k = in & __builtin_convertvector(in != 0 ? place : Floats{}, Ints);
            const Floats share = place - __builtin_convertvector(k, Floats), low = gather(j.entries, k);
            const Floats weight = low + share * (gather(j.entries + 1, k) - low);
            store<Floats>(at, in != 0 ? weight : Floats{});
        }
    }
}

template <int k>
struct Bit {
    static constexpr int kBit = k;
};
/// A polygon's edge or diagonal, and the difference of the weights of its ends.
template <class F>
struct Weighted {
    Vector<F> v;
    F w;
};
template <class F>
static DGM_INLINE Weighted<F> operator-(const Weighted<F>& a, const Weighted<F>& b) {
    return {a.v - b.v, a.w - b.w};
}
template <class F>
struct RingForm {
    Vector<F> area, slope;
};
/// sum += a x b, slope += a.w b - b.w a.
template <class F>
static DGM_INLINE void add_form(RingForm<F>& sum, const Weighted<F>& a, const Weighted<F>& b) {
    add_cross(sum.area, a.v, b.v);
    sum.slope.x = subtract_product(multiply_add(a.w, b.v.x, sum.slope.x), b.w, a.v.x);
    sum.slope.y = subtract_product(multiply_add(a.w, b.v.y, sum.slope.y), b.w, a.v.y);
    sum.slope.z = subtract_product(multiply_add(a.w, b.v.z, sum.slope.z), b.w, a.v.z);
}

template <class F, class I>
static DGM_INLINE RingForm<F> ring_form(const RingJob& j, std::ptrdiff_t k) {
    const auto near = [&](std::ptrdiff_t s) {
        return Weighted<F>{{load<F>(j.at.x + s), load<F>(j.at.y + s), load<F>(j.at.z + s)}, load<F>(j.weight + s)};
    };
    const std::ptrdiff_t n = j.cols;
    const Weighted<F> n0 = near(k + n), n1 = near(k + 1), n2 = near(k - n), n3 = near(k - 1);
    RingForm<F> sum{};
    const I ring = widen(j.ring + k, I{});
    const auto corner_of = [&](const Weighted<F>& in, const Weighted<F>& edge, auto bit) {
        return Weighted<F>{corner<F, I, decltype(bit)::kBit>(ring, in.v, edge.v),
                           choose_bit<decltype(bit)::kBit>(ring, in.w, edge.w)};
    };
    const Weighted<F> c1 = corner_of(near(k - n + 1), n1, Bit<1>{});
    add_form(sum, n1 - n0, c1 - corner_of(near(k + n + 1), n0, Bit<0>{}));
    add_form(sum, corner_of(near(k - n - 1), n2, Bit<2>{}) - c1, n3 - n2);
    add_form(sum, n3 - n0, corner_of(near(k + n - 1), n3, Bit<3>{}) - c1);
    return sum;
}

void rings(const RingJob& job) noexcept {
    const RingJob j = job;
    for (std::uint32_t r = 0; r < j.count; ++r) {
        const PatchRow row = j.rows[r];
        if (row.first < j.first || row.first >= j.last) continue;
        for (std::uint32_t k = 0; k < row.width; k += DGM_LANES) {
            const RingForm<Floats> form = ring_form<Floats, Ints>(j, static_cast<std::ptrdiff_t>(row.first + k));
            float* to = j.forms + kFormFloats * static_cast<std::size_t>(r) + k;
            store<Floats>(to, form.area.x * j.scale);
            store<Floats>(to + 8, form.area.y * j.scale);
            store<Floats>(to + 16, form.area.z * j.scale);
            store<Floats>(to + 24, form.slope.x * j.scale);
            store<Floats>(to + 32, form.slope.y * j.scale);
            store<Floats>(to + 40, form.slope.z * j.scale);
        }
    }
}
/// Samples k on, with the weights at w.
template <class F>
static DGM_INLINE void patch_block(const PatchJob& j, std::size_t k, const float* w) {
    const F weight = load<F>(w), x = load<F>(j.from.x + k), y = load<F>(j.from.y + k), z = load<F>(j.from.z + k);
    const auto moves = weight != 0;  // adding 0 would turn -0 into 0
    store<F>(j.to.x + k, moves ? x + weight * j.d[0] : x);
    store<F>(j.to.y + k, moves ? y + weight * j.d[1] : y);
    store<F>(j.to.z + k, moves ? z + weight * j.d[2] : z);
}
void move_patch(const PatchJob& job) noexcept {
    const PatchJob j = job;
    const float* w = j.weight;
    for (std::uint32_t r = 0; r < j.count; ++r, w += 8) {
        const PatchRow row = j.rows[r];
        if (row.width == 8)
            for (std::uint32_t k = 0; k < 8; k += DGM_LANES) patch_block<Floats>(j, row.first + k, w + k);
        else
            for (std::uint32_t k = 0; k < row.width; ++k) patch_block<float>(j, row.first + k, w + k);
    }
}

/// Normals of samples k on, whose forms and saved normals are at `form` and `saved`. Those of `keep` are the saved
/// ones.
/// @return which are good.
template <class F, class I>
static DGM_INLINE I press_block(const PressJob& j, std::size_t k, const float* form, const float* saved,
                                const I& keep) {
    const F ax = load<F>(form), ay = load<F>(form + 8), az = load<F>(form + 16);
    const F gx = load<F>(form + 24), gy = load<F>(form + 32), gz = load<F>(form + 40);
    const F dx = F{} + j.move.d[0], dy = F{} + j.move.d[1], dz = F{} + j.move.d[2];
    const F tx = multiply_subtract(dy, gz, dz * gy), ty = multiply_subtract(dz, gx, dx * gz),
            tz = multiply_subtract(dx, gy, dy * gx);
    const F x = ax + tx, y = ay + ty, z = az + tz;
    const F square = multiply_add(z, z, multiply_add(y, y, x * x));
    // Where the two nearly cancel, so do the digits.
    const F parts =
        multiply_add(az, az, multiply_add(ay, ay, ax * ax)) + multiply_add(tz, tz, multiply_add(ty, ty, tx * tx));
    const I good =
        static_cast<I>(square > 1e-24f) & static_cast<I>(square < 1e24f) & static_cast<I>(square > 1e-2f * parts);
    const F inverse = good ? inverse_root(square) : F{};
    store<F>(j.normal.x + k, keep ? load<F>(saved) : x * inverse);
    store<F>(j.normal.y + k, keep ? load<F>(saved + 8) : y * inverse);
    store<F>(j.normal.z + k, keep ? load<F>(saved + 16) : z * inverse);
    return good | keep;
}

bool press(const PressJob& job) noexcept {
    const PressJob j = job;
    Ints good = ~Ints{}, bits = {};
    for (int k = 0; k < DGM_LANES; ++k) bits[k] = 1 << k;
    int good_one = -1;
    const float *w = j.move.weight, *form = j.forms, *saved = j.saved;
    for (std::uint32_t r = 0; r < j.move.count; ++r, w += 8, form += kFormFloats, saved += kSavedFloats) {
        const PatchRow row = j.move.rows[r];
        if (row.width == 8)
            for (std::uint32_t k = 0; k < 8; k += DGM_LANES) {
                patch_block<Floats>(j.move, row.first + k, w + k);
                const Ints keep = ((Ints{} + (row.keep >> k)) & bits) != 0;
                good &= press_block<Floats, Ints>(j, row.first + k, form + k, saved + k, keep);
            }
        else
            for (std::uint32_t k = 0; k < row.width; ++k) {
                patch_block<float>(j.move, row.first + k, w + k);
                const int keep = -(row.keep >> k & 1);
                good_one &= press_block<float, int>(j, row.first + k, form + k, saved + k, keep);
            }
    }
    return good_one != 0 && !any(~good);
}
