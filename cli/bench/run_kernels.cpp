// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/run_kernels.cpp
// Values of eq. 7 over the paper's 21 x 21 window: exp itself against tables of several sizes and the library's own.
#include <dgm/deform.h>
#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "bench/columns.h"
#include "bench/repeat.h"
#include "bench/run_sweep.h"
#include "bench/runtime_error.h"

namespace dgm::bench {
namespace {

constexpr int kReach = 11;
constexpr float kSigma = 16;

using Window = std::vector<float>;

/// weight(i, j) at every offset of the window.
template <class Weight>
void fill(Window& out, Weight weight) {
    std::size_t k = 0;
    for (int i = 1 - kReach; i < kReach; ++i)
        for (int j = 1 - kReach; j < kReach; ++j) out[k++] = weight(i, j);
}

Window exact_window() {
    Window out((2 * kReach - 1) * (2 * kReach - 1));
    fill(out, [](int i, int j) { return static_cast<float>(std::exp(-(double(i) * i + double(j) * j) / kSigma)); });
    return out;
}

/// exp(-r^2 / sigma) at equal steps of r from 0 to the window's corner.
class Table1d {
 public:
    explicit Table1d(int entries) {
        const double corner = std::sqrt(2.0) * kReach;
        for (int k = 0; k < entries; ++k) {
            const double r = corner * k / (entries - 1);
            values_.push_back(static_cast<float>(std::exp(-r * r / kSigma)));
        }
        per_step_ = static_cast<float>((entries - 1) / corner);
    }
    [[nodiscard]] float nearest(float r) const {
        // NOLINTNEXTLINE(bugprone-incorrect-roundings): what a runtime would do, and r is not negative
        return values_[static_cast<std::size_t>(r * per_step_ + 0.5f)];
    }
    [[nodiscard]] float linear(float r) const {
        const float at = r * per_step_;
        const auto k = static_cast<std::size_t>(at);
        return values_[k] + (at - static_cast<float>(k)) * (values_[k + 1] - values_[k]);
    }

 private:
    std::vector<float> values_;
    float per_step_ = 0;
};

float radius(int i, int j) {
    return std::sqrt(static_cast<float>(i * i + j * j));
}

template <class Weight>
void add_row(Table& table, const std::string& way, int entries, Weight weight) {
    static const Window exact = exact_window();
    Window window(exact.size());
    fill(window, weight);
    double worst = 0;
    for (std::size_t k = 0; k < exact.size(); ++k) worst = std::max(worst, double(std::fabs(window[k] - exact[k])));
    volatile float sink = 0;
    const Figure seconds = time_of_call([&] {
        fill(window, weight);
        sink = window[window.size() / 2];
    });
    RowBuilder row(table);
    row.set("way", way);
    row.set("entries", entries > 0 ? std::to_string(entries) : std::string());
    row.set("ns", scaled(seconds, 1e9 / static_cast<double>(window.size())));
    row.set("error", exactly(worst));
    table.rows.push_back(row.row());
}

}  // namespace

Table kernel_table() {
    Table t;
    t.key = "kernels";
    t.title = "Values of the kernel";
    t.note =
        "Eq. 7 at the 441 offsets of a window with b = 11, sigma = 16. 'Library' reads DeformTable::weight and profile "
        "one "
        "by one; whole footprints are copied row by row and cost less than that.";
    t.columns = {key_column("way", "way"), key_column("entries", "entries"), time_column("ns", "a value", "ns"),
                 exact_column("error", "largest error", "", Sense::kLower, 1e-3)};
    t.plots = {{"Error of the kernel against time", "ns", "error", "way", "", false}};
    add_row(t, "exp, double", 0,
            [](int i, int j) { return static_cast<float>(std::exp(-double(i * i + j * j) / kSigma)); });
    add_row(t, "exp, float", 0, [](int i, int j) { return std::exp(-static_cast<float>(i * i + j * j) / kSigma); });
    for (const int entries : {64, 256, 1024, 4096}) {
        const Table1d table(entries);
        add_row(t, "table, nearest", entries, [&](int i, int j) { return table.nearest(radius(i, j)); });
        add_row(t, "table, linear", entries, [&](int i, int j) { return table.linear(radius(i, j)); });
    }
    KernelOptions kernel;
    kernel.sigma = kSigma;
    kernel.reach = kReach;
    const DeformTable library = take(DeformTable::create(kernel));
    add_row(t, "library, weight", 0,
            [&](int i, int j) { return library.weight(static_cast<float>(i), static_cast<float>(j)); });
    add_row(t, "library, profile", 0, [&](int i, int j) { return library.profile(radius(i, j)); });
    return t;
}

}  // namespace dgm::bench
