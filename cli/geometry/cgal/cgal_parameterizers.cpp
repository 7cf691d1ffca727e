// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cgal/cgal_parameterizers.cpp
// CGAL's parameterizers with our border, our solver and our handling of flips. One translation unit: CGAL compiles
// slowly.
#include "geometry/cgal/cgal_parameterizers.h"

#include <CGAL/Eigen_solver_traits.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_parameterization/Barycentric_mapping_parameterizer_3.h>
#include <CGAL/Surface_mesh_parameterization/Discrete_authalic_parameterizer_3.h>
#include <CGAL/Surface_mesh_parameterization/Discrete_conformal_map_parameterizer_3.h>
#include <CGAL/Surface_mesh_parameterization/Mean_value_coordinates_parameterizer_3.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "geometry/parameterize/check_disk.h"
#include "geometry/parameterize/slim.h"

namespace dgm::bake {
namespace {
namespace smp = CGAL::Surface_mesh_parameterization;

/// A kernel of our own makes a mesh type of our own, whose specialisations below cannot meet anybody else's.
struct DiskKernel : CGAL::Type_equality_wrapper<CGAL::Cartesian_base_no_ref_count<double, DiskKernel>, DiskKernel> {};
using DiskMesh = CGAL::Surface_mesh<DiskKernel::Point_3>;
using Vertex = DiskMesh::Vertex_index;
using UvMap = DiskMesh::Property_map<Vertex, DiskKernel::Point_2>;
[[noreturn]] void fail(const std::string& what) {
    throw model::Error(model::codes::kMapInvalid, what);
}

/// Model of CGAL's SparseLinearAlgebraTraits_d over FactorOnce. Copies share one solver.
class SolverTraits {
 public:
    using NT = double;
    using Matrix = CGAL::Eigen_sparse_matrix<double>;
    using Vector = CGAL::Eigen_vector<double>;

    SolverTraits() : solver_(std::make_shared<FactorOnce>()) {}
    SolverTraits(std::string_view stage, double expected_solves, const model::Progress& progress)
        : solver_(std::make_shared<FactorOnce>()),
          stage_(stage),
          expected_solves_(expected_solves),
          progress_(&progress) {}

    bool linear_solver(const Matrix& A, const Vector& B, Vector& X, NT& D) {
        D = 1;
        if (progress_ != nullptr)
            progress_->update(stage_, std::min(1.0, static_cast<double>(statistics().solves) / expected_solves_));
        return solver_->solve(A.eigen_object(), B, X);
    }
    [[nodiscard]] const SolveStatistics& statistics() const { return solver_->statistics(); }

 private:
    std::shared_ptr<FactorOnce> solver_;
    std::string_view stage_;
    double expected_solves_ = 1;
    const model::Progress* progress_ = nullptr;
};

/// Model of CGAL's border parameterizers: hands over the points of the caller.
class GivenBorder {
 public:
    GivenBorder() = default;
    GivenBorder(std::span<const std::uint32_t> border, std::span<const Vec2d> points)
        : border_(border), points_(points) {}

    template <typename VertexUvMap, typename IndexMap, typename ParameterizedMap>
    smp::Error_code parameterize(const DiskMesh&, DiskMesh::Halfedge_index, VertexUvMap uvmap, IndexMap,
                                 ParameterizedMap vpmap) const {
        for (std::size_t k = 0; k < border_.size(); ++k) {
            put(uvmap, Vertex(border_[k]), DiskKernel::Point_2(points_[k].x, points_[k].y));
            put(vpmap, Vertex(border_[k]), true);
        }
        return smp::OK;
    }
    [[nodiscard]] bool is_border_convex() const { return true; }

 private:
    std::span<const std::uint32_t> border_;
    std::span<const Vec2d> points_;
};

/// Tangent of half the angle between two vectors, from their products alone: CGAL's goes through acos and tan, which
/// the C library rounds as the processor likes. A right angle if one of them is zero.
double half_tangent(const Vec3d& a, const Vec3d& b) {
    constexpr double kStraight = 1e16;  // about what a tangent in doubles gives for 90 degrees
    const double lengths = length(a) * length(b), cosine = dot(a, b), sine = length(cross(a, b));
    if (!(lengths > 0)) return 1;
    return std::min(kStraight, cosine > 0 ? sine / (lengths + cosine) : (lengths - cosine) / sine);
}

/// Weight of the edge from `centre` to `at` between the edges to `before` and `after` [Floater 2003].
double mean_value_weight(const DiskMesh& mesh, Vertex centre, Vertex before, Vertex at, Vertex after) {
    const auto from_centre = [&](Vertex v) {
        const auto p = mesh.point(v) - mesh.point(centre);
        return Vec3d{p.x(), p.y(), p.z()};
    };
    const Vec3d edge = from_centre(at);
    const double far = length(edge);
    return far > 0 ? (half_tangent(from_centre(before), edge) + half_tangent(edge, from_centre(after))) / far : 0;
}

/// CGAL's frame with our weights.
class MeanValue : public smp::Mean_value_coordinates_parameterizer_3<DiskMesh, GivenBorder, SolverTraits> {
    using Base = smp::Mean_value_coordinates_parameterizer_3<DiskMesh, GivenBorder, SolverTraits>;

 public:
    using Base::Base;

 protected:
    double compute_w_ij(const DiskMesh& mesh, Vertex i,
                        CGAL::Vertex_around_target_circulator<DiskMesh> j) const override {
        auto before = j, after = j;
        return mean_value_weight(mesh, i, *--before, *j, *++after);
    }
};

/// A fixed-border method whose rows can be made positive. `Base` supplies the published weights.
template <typename Base>
class GuardedWeights : public Base {
 public:
    GuardedWeights(const GivenBorder& border, const SolverTraits& solver, bool force_positive)
        : Base(border, solver), force_positive_(force_positive) {}

    /// True if a row had a weight that is not finite or not positive.
    [[nodiscard]] bool met_bad_row() const { return met_bad_row_; }

 protected:
    using Circulator = CGAL::Vertex_around_target_circulator<DiskMesh>;

    /// CGAL asks for the neighbours of one vertex after the other, each time around from its half-edge.
    double compute_w_ij(const DiskMesh& mesh, Vertex i, Circulator j) const override {
        if (i != row_vertex_ || next_ == row_.size()) fill_row(mesh, i);
        if (neighbours_[next_] != *j)
            next_ =
                static_cast<std::size_t>(std::find(neighbours_.begin(), neighbours_.end(), *j) - neighbours_.begin());
        return row_[next_++];
    }

 private:
    void fill_row(const DiskMesh& mesh, Vertex i) const {
        row_vertex_ = i;
        next_ = 0;
        row_.clear();
        neighbours_.clear();
        const auto visit = [&](const auto& weight) {
            Circulator j(mesh.halfedge(i), mesh);
            const Circulator end = j;
            do row_.push_back(weight(j));
            while (++j != end);
        };
        visit([&](const Circulator& j) {
            neighbours_.push_back(*j);
            return Base::compute_w_ij(mesh, i, j);
        });
        if (is_positive()) return;
        met_bad_row_ = true;
        const bool finite = std::all_of(row_.begin(), row_.end(), [](double w) { return std::isfinite(w); });
        if (!force_positive_ && finite) return;
        row_.clear();
        visit([&](Circulator j) {
            Circulator before = j, after = j;
            return mean_value_weight(mesh, i, *--before, *j, *++after);
        });
        if (!is_positive()) row_.assign(row_.size(), 1.0);
    }
    [[nodiscard]] bool is_positive() const {
        double sum = 0;
        for (const double w : row_) {
            if (!(w > 0)) return false;
            sum += w;
        }
        return std::isfinite(sum);
    }

    bool force_positive_;
    mutable bool met_bad_row_ = false;
    mutable Vertex row_vertex_;
    mutable std::vector<double> row_;
    mutable std::vector<Vertex> neighbours_;
    mutable std::size_t next_ = 0;
};

using Tutte = smp::Barycentric_mapping_parameterizer_3<DiskMesh, GivenBorder, SolverTraits>;
using Authalic = smp::Discrete_authalic_parameterizer_3<DiskMesh, GivenBorder, SolverTraits>;
using Conformal = smp::Discrete_conformal_map_parameterizer_3<DiskMesh, GivenBorder, SolverTraits>;

struct Mesh {
    DiskMesh mesh;
    DiskMesh::Halfedge_index border;
    UvMap uv;
    DiskMesh::Property_map<Vertex, bool> parameterized;
    DiskMesh::Property_map<Vertex, int> index;
};

/// Vertices and faces in the order of the view, so that indices are the same on both sides.
Mesh make_mesh(const DiskView& disk) {
    Mesh out;
    DiskMesh& m = out.mesh;
    const auto n = static_cast<DiskMesh::size_type>(disk.positions.size());
    const auto faces = static_cast<DiskMesh::size_type>(disk.faces.size());
    m.reserve(n, n + faces, faces);
    for (const Vec3d& p : disk.positions) m.add_vertex(DiskKernel::Point_3(p.x, p.y, p.z));
    for (const Face& f : disk.faces)
        if (m.add_face(Vertex(f[0]), Vertex(f[1]), Vertex(f[2])) == DiskMesh::null_face())
            fail("the disk is not manifold");
    std::size_t border_edges = 0;
    for (const auto h : m.halfedges())
        if (m.is_border(h)) {
            if (border_edges++ == 0) out.border = h;
        }
    const std::size_t k = disk.border.size();
    bool matches = border_edges == k;
    for (std::size_t b = 0; matches && b < k; ++b) {
        const std::uint32_t from = disk.border[b], to = disk.border[(b + 1) % k];
        if (from >= n || to >= n) fail("the border names a vertex that does not exist");
        const auto h = m.halfedge(Vertex(from), Vertex(to));
        matches = h != DiskMesh::null_halfedge() && !m.is_border(h) && m.is_border(m.opposite(h));
    }
    if (!matches) fail("the border cycle is not the border of the faces, surface on its left");
    out.uv = m.add_property_map<Vertex, DiskKernel::Point_2>("v:dgm_uv", DiskKernel::Point_2(0, 0)).first;
    out.parameterized = m.add_property_map<Vertex, bool>("v:dgm_parameterized", false).first;
    out.index = m.add_property_map<Vertex, int>("v:dgm_index", 0).first;
    for (const Vertex v : m.vertices()) out.index[v] = static_cast<int>(v.idx());
    return out;
}

std::vector<Vec2d> points_of(const Mesh& m) {
    std::vector<Vec2d> out;
    out.reserve(m.mesh.number_of_vertices());
    for (const Vertex v : m.mesh.vertices()) out.push_back({m.uv[v].x(), m.uv[v].y()});
    return out;
}

bool all_finite(const std::vector<Vec2d>& uv) {
    return std::all_of(uv.begin(), uv.end(), [](Vec2d p) { return std::isfinite(p.x) && std::isfinite(p.y); });
}

void add(SolveStatistics* total, const SolveStatistics& part) {
    if (total == nullptr) return;
    total->factorizations += part.factorizations;
    total->solves += part.solves;
    total->unsymmetric += part.unsymmetric;
}

/// One run of a CGAL parameterizer; nothing if it reports an error or its result is not finite.
template <typename Method>
std::optional<std::vector<Vec2d>> run(Method& method, const DiskView& disk) {
    Mesh m = make_mesh(disk);
    if (method.parameterize(m.mesh, m.border, m.uv, m.index, m.parameterized) != smp::OK) return std::nullopt;
    std::vector<Vec2d> uv = points_of(m);
    if (!all_finite(uv)) return std::nullopt;
    return uv;
}

/// Published weights; where they were at fault and the map has flips, or none came out, positive ones.
template <typename Base>
std::optional<std::vector<Vec2d>> solve_fixed(const DiskView& disk, std::span<const Vec2d> border_points,
                                              std::string_view stage, SolveStatistics* statistics,
                                              const model::Progress& progress) {
    const GivenBorder border(disk.border, border_points);
    const SolverTraits solver(stage, 2, progress);
    GuardedWeights<Base> published(border, solver, false);
    std::optional<std::vector<Vec2d>> uv = run(published, disk);
    add(statistics, solver.statistics());
    const std::size_t flips = uv ? count_not_positive(disk.faces, *uv) : disk.faces.size() + 1;
    if (flips == 0 || (uv && !published.met_bad_row())) return uv;

    const SolverTraits again(stage, 2, progress);
    GuardedWeights<Base> positive(border, again, true);
    std::optional<std::vector<Vec2d>> second = run(positive, disk);
    add(statistics, again.statistics());
    if (second && count_not_positive(disk.faces, *second) < flips) return second;
    return uv;
}

enum class Method { kTutte, kMvc, kAuthalic, kConformal };

class CgalParameterizer final : public Parameterizer {
 public:
    CgalParameterizer(Method method, std::string_view name, SolveStatistics* statistics)
        : method_(method), name_(name), statistics_(statistics) {}

    [[nodiscard]] std::string_view name() const override { return name_; }
    [[nodiscard]] bool fixed_border() const override { return true; }

    [[nodiscard]] std::vector<Vec2d> solve(const DiskView& disk, const model::Progress& progress) const override {
        progress.update(name_, 0);
        try {
            check_disk(disk, true);
            std::vector<Vec2d> uv = solve_in_square(disk, progress);
            progress.update(name_, 1);
            return uv;
        } catch (const model::Error&) { throw; } catch (const std::bad_alloc&) {
            throw model::Error(model::codes::kWorkerMemory, std::string(name_) + " ran out of memory");
        } catch (const std::exception& e) { fail(std::string(name_) + ": CGAL failed: " + e.what()); }
    }

 private:
    [[nodiscard]] std::vector<Vec2d> solve_in_square(const DiskView& disk, const model::Progress& progress) const {
        std::optional<std::vector<Vec2d>> uv;
        const auto points = disk.border_uv;
        switch (method_) {
            case Method::kMvc:
                uv = solve_fixed<MeanValue>(disk, points, name_, statistics_, progress);
                break;
            case Method::kAuthalic:
                uv = solve_fixed<Authalic>(disk, points, name_, statistics_, progress);
                break;
            case Method::kConformal:
                uv = solve_fixed<Conformal>(disk, points, name_, statistics_, progress);
                break;
            default:
                uv = solve_fixed<Tutte>(disk, points, name_, statistics_, progress);
                break;
        }
        if (!uv) fail(std::string(name_) + ": the linear system could not be solved");
        // Means of points of the square, up to rounding.
        for (Vec2d& p : *uv) p = {std::clamp(p.x, 0.0, 1.0), std::clamp(p.y, 0.0, 1.0)};
        return std::move(*uv);
    }

    Method method_;
    std::string_view name_;
    SolveStatistics* statistics_;
};
}  // namespace

std::unique_ptr<Parameterizer> make_cgal_parameterizer(std::string_view method, SolveStatistics* statistics) {
    constexpr struct {
        std::string_view name;
        Method method;
    } kMethods[] = {{"tutte", Method::kTutte},
                    {"mvc", Method::kMvc},
                    {"authalic", Method::kAuthalic},
                    {"conformal", Method::kConformal}};
    for (const auto& [name, id] : kMethods)
        if (name == method) return std::make_unique<CgalParameterizer>(id, name, statistics);
    return nullptr;
}

}  // namespace dgm::bake
