// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/bump_normals.cpp
//
// [Blinn 1978] Simulation of wrinkled surfaces. SIGGRAPH 1978.
// [Max 1999] Weights for computing vertex normals from facet normals. Journal of Graphics Tools 4(2).
#include "geometry/metrics/bump_normals.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <variant>

#include "geometry/metrics/grid_point.h"
#include "model/element.h"
#include "model/layer_names.h"

namespace dgm::bake {
namespace {
using model::Chart;
using model::Layer;
using model::Vec3d;

/// Vertex normals of a rows x cols lattice; `valid` points alone take part, `classes` are summed together.
std::vector<Vec3d> lattice_normals(const std::vector<Vec3d>& points, const std::vector<char>& valid, std::uint32_t rows,
                                   std::uint32_t cols, std::span<const std::uint32_t> classes,
                                   std::span<const std::uint8_t> reversed) {
    const auto facing = [&](std::uint32_t k, const Vec3d& v) { return reversed.empty() || !reversed[k] ? v : -v; };
    std::vector<Vec3d> sum(points.size(), Vec3d{});
    for (std::uint32_t i = 0; i + 1 < rows; ++i)
        for (std::uint32_t j = 0; j + 1 < cols; ++j) {
            const std::uint32_t a = i * cols + j;
            const std::uint32_t corner[4] = {a, a + cols, a + cols + 1, a + 1};  // counter-clockwise
            if (!(valid[corner[0]] && valid[corner[1]] && valid[corner[2]] && valid[corner[3]])) continue;
            for (int k = 0; k < 4; ++k) {
                const Vec3d next = points[corner[(k + 1) % 4]] - points[corner[k]];
                const Vec3d last = points[corner[(k + 3) % 4]] - points[corner[k]];
                const double squares = dot(next, next) * dot(last, last);
                if (squares > 0) sum[classes[corner[k]]] += facing(corner[k], cross(next, last) / squares);
            }
        }
    std::vector<Vec3d> out(points.size());
    for (std::uint32_t k = 0; k < out.size(); ++k) out[k] = facing(k, normalized(sum[classes[k]], Vec3d{}));
    return out;
}
}  // namespace

std::vector<std::uint32_t> texel_classes(std::uint32_t m, std::uint32_t n, std::uint32_t rows, std::uint32_t cols,
                                         std::span<const std::uint32_t> sample_class,
                                         std::span<const std::uint8_t> sample_reversed,
                                         std::vector<std::uint8_t>* reversed) {
    if (!sample_reversed.empty()) reversed->assign(std::size_t{rows} * cols, 0);
    std::vector<std::uint32_t> classes(std::size_t{rows} * cols);
    for (std::uint32_t t = 0; t < classes.size(); ++t) classes[t] = t;
    if (rows < m || cols < n || (rows - 1) % (m - 1) != 0 || (cols - 1) % (n - 1) != 0) return classes;
    const std::uint32_t down = (rows - 1) / (m - 1), across = (cols - 1) / (n - 1);
    // A border texel is known by the classes of the samples on both sides and its share of the way.
    struct Lowest {
        std::uint32_t texel;
        std::uint8_t turned;
    };
    std::map<std::tuple<std::uint32_t, std::uint32_t, long>, Lowest> first;
    for (std::uint32_t t = 0; t < classes.size(); ++t) {
        const std::uint32_t i = t / cols, j = t % cols;
        if (i != 0 && j != 0 && i + 1 != rows && j + 1 != cols) continue;
        std::uint32_t from = i / down * n + j / across, to = from;
        std::uint32_t a = sample_class[from], b = a;
        double share = 0;
        if (i % down != 0) {
            to = from + n;
            b = sample_class[to];
            share = static_cast<double>(i % down) / down;
        }
        if (j % across != 0) {
            to = from + 1;
            b = sample_class[to];
            share = static_cast<double>(j % across) / across;
        }
        if (b < a) std::swap(a, b), std::swap(from, to), share = 1 - share;
        const std::uint8_t turned = sample_reversed.empty() ? 0 : sample_reversed[from];
        const auto& lowest = first.try_emplace({a, b, std::lround(share * 1e6)}, Lowest{t, turned}).first->second;
        classes[t] = lowest.texel;
        if (!sample_reversed.empty()) (*reversed)[t] = turned ^ lowest.turned;
    }
    return classes;
}

BumpNormals::BumpNormals(const Chart& chart, const Reconstruction& surface)
    : surface_(surface), m_(chart.rows), n_(chart.cols) {
    const Layer& bump = *chart.find(model::layers::kBump);
    const Layer* diagonals = chart.find(model::layers::kDiagonals);
    const Layer* mask = chart.find(model::layers::kMask);
    rows_ = static_cast<std::uint32_t>(bump.shape[0]);
    cols_ = static_cast<std::uint32_t>(bump.shape[1]);
    const auto number = [&](const char* name, double otherwise) {
        const auto found = bump.attributes.find(name);
        if (found == bump.attributes.end()) return otherwise;
        const auto* values = std::get_if<std::vector<double>>(&found->second);
        return values == nullptr || values->empty() ? otherwise : values->front();
    };
    const double scale = number("scale", 1);
    weight_ = std::clamp(number("shading", 0), 0.0, 1.0);
    const auto height = [&](std::size_t t) {
        return scale * model::half_value(model::element<std::uint16_t>(bump, t));
    };
    const auto on_surface = [&](std::uint32_t s) {
        return mask == nullptr || model::element<std::uint8_t>(*mask, s) != 0;
    };
    const auto has_quad = [&](std::uint32_t i, std::uint32_t j) {
        const std::uint32_t a = i * n_ + j;
        return on_surface(a) && on_surface(a + 1) && on_surface(a + n_) && on_surface(a + n_ + 1);
    };
    const auto diagonal = [&](std::uint32_t i, std::uint32_t j) -> unsigned {
        return diagonals == nullptr ? 0u : model::element<std::uint8_t>(*diagonals, std::size_t{i} * (n_ - 1) + j);
    };

    // Local coordinates: an offset far away must not cost the differences below their digits.
    const Vec3d offset{chart.offset[0], chart.offset[1], chart.offset[2]};
    std::vector<Vec3d> normals(std::size_t{m_} * n_, Vec3d{});
    const model::TriMesh& mesh = surface.mesh;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k)
            if (mesh.faces[f][k] < normals.size()) normals[mesh.faces[f][k]] = mesh.corner_normals[3 * f + k];

    const double to_x = static_cast<double>(m_ - 1) / (rows_ - 1), to_y = static_cast<double>(n_ - 1) / (cols_ - 1);
    std::vector<Vec3d> fine(std::size_t{rows_} * cols_);
    std::vector<char> valid(fine.size(), 0);
    stored_.resize(fine.size());
    for (std::uint32_t t = 0; t < fine.size(); ++t) {
        const auto p = grid_point(t / cols_ * to_x, t % cols_ * to_y, m_, n_, has_quad, diagonal);
        if (!p) continue;
        valid[t] = 1;
        Vec3d normal;
        for (int k = 0; k < 3; ++k) {
            fine[t] += (mesh.positions[p->sample[k]] - offset) * p->b[k];
            normal += normals[p->sample[k]] * p->b[k];
        }
        stored_[t] = normalized(normal, Vec3d{});
        fine[t] += stored_[t] * height(t);
    }
    fine_ = fine_normals(fine, valid);
}

std::vector<Vec3d> BumpNormals::fine_normals(const std::vector<Vec3d>& fine, const std::vector<char>& valid) const {
    std::vector<std::uint32_t> own(surface_.weld.begin(), surface_.weld.begin() + m_ * n_);
    // A class whose representative is a border sample is summed at its lowest grid sample.
    std::map<std::uint32_t, std::uint32_t> lowest;
    for (std::uint32_t s = 0; s < own.size(); ++s) own[s] = lowest.try_emplace(own[s], s).first->second;
    std::vector<std::uint8_t> reversed;
    const std::vector<std::uint32_t> classes = texel_classes(m_, n_, rows_, cols_, own, surface_.reversed, &reversed);
    return lattice_normals(fine, valid, rows_, cols_, classes, reversed);
}

std::optional<BumpNormals> BumpNormals::of(const Chart& chart, const Reconstruction& surface) {
    const Layer* bump = chart.find(model::layers::kBump);
    if (bump == nullptr || bump->shape.size() != 2 || bump->shape[0] < 2 || bump->shape[1] < 2 || chart.rows < 2 ||
        chart.cols < 2 || surface.mesh.corner_normals.size() != 3 * surface.mesh.faces.size())
        return std::nullopt;
    return BumpNormals(chart, surface);
}

BumpNormals::Both BumpNormals::both(std::uint32_t face, const double (&barycentric)[3]) const {
    const model::Face& f = surface_.mesh.faces[face];
    Both out;
    double x = 0, y = 0;
    bool strip = false;
    for (std::size_t k = 0; k < 3; ++k) {
        out.stored += surface_.mesh.corner_normals[3 * face + k] * barycentric[k];
        strip = strip || f[k] >= m_ * n_;
        x += barycentric[k] * (f[k] / n_);
        y += barycentric[k] * (f[k] % n_);
    }
    out.stored = normalized(out.stored, Vec3d{});
    if (strip || out.stored == Vec3d{}) return out;
    const TexelTaps taps = texel_taps(x * (rows_ - 1) / (m_ - 1), y * (cols_ - 1) / (n_ - 1), rows_, cols_);
    for (int k = 0; k < 4; ++k) out.fine += fine_[taps.texel[k]] * taps.weight[k];
    out.fine = normalized(out.fine, Vec3d{});
    return out;
}

Vec3d BumpNormals::at(std::uint32_t face, const double (&barycentric)[3]) const {
    return blend(both(face, barycentric));
}

Vec3d BumpNormals::at_texel(std::size_t texel) const {
    return blend({stored_[texel], fine_[texel]});
}

Vec3d BumpNormals::blend(const Both& n) const {
    if (n.fine == Vec3d{}) return n.stored;
    return normalized(n.stored * (1 - weight_) + n.fine * weight_, n.stored);
}

}  // namespace dgm::bake
