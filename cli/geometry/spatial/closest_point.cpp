// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/spatial/closest_point.cpp
// Embree prunes with float boxes; every distance that decides is computed here, in double.
//
// Why the answer does not depend on the hierarchy: boxes are rounded outwards and the search radius upwards, so each
// face that could win or tie is visited; winners are chosen by (squared distance, face index) alone. Points on shared
// vertices and edges give the same bits from either face, because an edge is always walked from its lower vertex.
#include "geometry/spatial/closest_point.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <vector>

#include "geometry/mesh/infinity.h"
#include "math/portable.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {
using model::Face;
using model::Vec3d;

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// So few triangles are visited one by one: a hierarchy of them costs more, to build and to search.
constexpr std::size_t kFewTriangles = 48;

// Beyond this many diagonals from the centre, float boxes are useless (and their squares may overflow): search all
// faces.
constexpr double kFarDiagonals = 1e15;

// Rounding of the query point to float and of Embree's box distance: a few units of 2^-24, relative to the distance and
// to the coordinates.
constexpr double kFloatSlack = 16.0 / (1 << 24);

// Squared sine under which a triangle is treated as its three edges; the error is then below 1e-10 of its longest edge.
constexpr double kSliverSineSquared = 1e-20;

struct Triangle {
    Vec3d a, b, c;
    Vec3d normal;           // (b - a) x (c - a), not normalised; zero if the triangle is a sliver
    double normal_squared;  // 0 if the triangle is a sliver
    std::uint32_t face;
    bool swap_ab, swap_bc, swap_ca;  // the edge's second vertex has the lower index
};

struct Nearest {
    double squared = kInfinity;
    std::uint32_t face = kNone, triangle = kNone;
    Vec3d point;
    std::array<double, 3> barycentric{};
};

double box_diagonal_half(const Vec3d& half) {
    return math::hypot(half.x, half.y, half.z);
}

float round_down(double x) {
    const float f = static_cast<float>(x);
    return f <= x ? f : std::nextafter(f, -std::numeric_limits<float>::infinity());
}
float round_up(double x) {
    const float f = static_cast<float>(x);
    return f >= x ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}

/// Nearest point of segment (a, b), with t its parameter from a; walks from b if `swap`, so both users get equal bits.
double segment_distance(const Vec3d& p, const Vec3d& a, const Vec3d& b, bool swap, Vec3d& point, double& t) {
    const Vec3d& from = swap ? b : a;
    const Vec3d& to = swap ? a : b;
    const Vec3d edge = to - from;
    const double along = dot(p - from, edge), squared = dot(edge, edge);
    double s;
    if (!(along > 0)) {
        s = 0;
        point = from;
    } else if (along >= squared) {
        s = 1;
        point = to;
    } else {
        s = along / squared;
        point = from + edge * s;
    }
    t = swap ? 1 - s : s;
    const Vec3d d = p - point;
    return dot(d, d);
}

/// Squared distance from p to the triangle, with the nearest point and its barycentric coordinates.
///
/// The signs of the three edge sides decide the region, as in [Ericson 2005, section 5.1.5], but taken as
/// n . (edge x (p - corner)): their error is a lateral shift of about 1e-16 |p - corner|, whatever the triangle's size.
/// Outside, the nearest point lies on an edge that has p on its outer side.
double triangle_distance(const Triangle& tri, const Vec3d& p, Vec3d& point, std::array<double, 3>& bary) {
    bool test_ab = true, test_bc = true, test_ca = true;
    if (tri.normal_squared > 0) {
        const Vec3d ap = p - tri.a, bp = p - tri.b, cp = p - tri.c;
        const double side_ab = dot(tri.normal, cross(tri.b - tri.a, ap));
        const double side_bc = dot(tri.normal, cross(tri.c - tri.b, bp));
        const double side_ca = dot(tri.normal, cross(tri.a - tri.c, cp));
        if (side_ab >= 0 && side_bc >= 0 && side_ca >= 0) {
            const double sum = side_ab + side_bc + side_ca;
            if (sum > 0) {
                bary = {side_bc / sum, side_ca / sum, side_ab / sum};
                point = tri.a + (tri.b - tri.a) * bary[1] + (tri.c - tri.a) * bary[2];
                const Vec3d d = p - point;
                return dot(d, d);
            }
        } else {
            test_ab = side_ab < 0;
            test_bc = side_bc < 0;
            test_ca = side_ca < 0;
        }
    }
    double best = kInfinity;
    Vec3d q;
    double t = 0;
    if (test_ab) {
        best = segment_distance(p, tri.a, tri.b, tri.swap_ab, point, t);
        bary = {1 - t, t, 0};
    }
    if (test_bc) {
        const double squared = segment_distance(p, tri.b, tri.c, tri.swap_bc, q, t);
        if (squared < best) {
            best = squared;
            point = q;
            bary = {0, 1 - t, t};
        }
    }
    if (test_ca) {
        const double squared = segment_distance(p, tri.c, tri.a, tri.swap_ca, q, t);
        if (squared < best) {
            best = squared;
            point = q;
            bary = {t, 0, 1 - t};
        }
    }
    return best;
}

/// True if the plane alone shows that the triangle is farther than `squared`. The margin covers rounding.
bool plane_is_farther(const Triangle& tri, const Vec3d& p, double squared) {
    const double height = dot(tri.normal, p - tri.a);
    return height * height > squared * tri.normal_squared * (1 + 1e-4) + 1e-30 * tri.normal_squared &&
           tri.normal_squared > 0;
}

struct Piece;

struct Search {
    const Triangle* triangles = nullptr;
    const Piece* pieces = nullptr;
    Vec3d point;       // normalised frame
    double reach = 0;  // largest coordinate of point, at least 1: what the float slack is relative to
    Nearest nearest;
    const Vec3d* unit_normals = nullptr;  // null: every face may match
    Vec3d direction;
    double min_cosine = 0;

    /// Returns true if the triangle became the nearest.
    bool visit(std::uint32_t index) {
        const Triangle& tri = triangles[index];
        if (plane_is_farther(tri, point, nearest.squared)) return false;
        if (unit_normals != nullptr) {
            const Vec3d& n = unit_normals[index];
            if ((n.x == 0 && n.y == 0 && n.z == 0) || !(dot(n, direction) > min_cosine)) return false;
        }
        Vec3d q;
        std::array<double, 3> bary;
        const double squared = triangle_distance(tri, point, q, bary);
        if (!(squared < nearest.squared || (squared == nearest.squared && tri.face < nearest.face))) return false;
        nearest = {squared, tri.face, index, q, bary};
        return true;
    }

    [[nodiscard]] float radius() const {
        const double d = std::sqrt(nearest.squared);
        return round_up(d + kFloatSlack * (d + reach));
    }
};

/// The part of a triangle between two shares of its longest edge, seen at right angles to it: what the hierarchy holds.
/// A box around a whole needle is nearly empty, and where 10 000 of them meet a query would have to look at each.
struct Piece {
    std::uint32_t triangle = 0;
    float from = 0, to = 1;
};
constexpr double kNeedle = 32;      ///< length over height of a triangle that is taken to pieces
constexpr double kPieceLength = 8;  ///< of a piece, in heights
constexpr int kMaxPieces = 16;

/// The triangle's corners from the longest edge's start on.
std::array<Vec3d, 3> from_longest_edge(const Triangle& tri) {
    const double ab = length(tri.b - tri.a), bc = length(tri.c - tri.b), ca = length(tri.a - tri.c);
    if (ab >= bc && ab >= ca) return {tri.a, tri.b, tri.c};
    if (bc >= ca) return {tri.b, tri.c, tri.a};
    return {tri.c, tri.a, tri.b};
}

/// Number of pieces in which a triangle is stored.
int piece_count(const Triangle& tri) {
    const auto [p, q, r] = from_longest_edge(tri);
    const double edge = length(q - p);
    const double height = edge > 0 ? length(cross(q - p, r - p)) / edge : 0;
    if (!(edge > kNeedle * height)) return 1;
    return static_cast<int>(std::min<double>(kMaxPieces, std::ceil(edge / (kPieceLength * height))));
}

/// Data that the scene's functions see.
struct Held {
    const Triangle* triangles;
    const Piece* pieces;
};

bool on_candidate(RTCPointQueryFunctionArguments* args) {
    auto& search = *static_cast<Search*>(args->userPtr);
    if (!search.visit(search.pieces[args->primID].triangle)) return false;
    args->query->radius = std::min(args->query->radius, search.radius());
    return true;
}

void on_bounds(const RTCBoundsFunctionArguments* args) {
    const Held& held = *static_cast<const Held*>(args->geometryUserPtr);
    const Piece& piece = held.pieces[args->primID];
    const std::array<Vec3d, 3> from_edge = from_longest_edge(held.triangles[piece.triangle]);
    const Vec3d &p = from_edge[0], &q = from_edge[1], &r = from_edge[2];
    std::array<Vec3d, 5> corners{p, q, r, r, r};
    if (piece.from > 0 || piece.to < 1) {
        const Vec3d edge = q - p;
        const double apex = std::clamp(dot(r - p, edge) / dot(edge, edge), 0.0, 1.0);
        // Across from the share t of the longest edge, on the other two.
        const auto across = [&](double t) {
            return t < apex ? p + (r - p) * (t / apex) : t < 1 ? r + (q - r) * ((t - apex) / (1 - apex)) : q;
        };
        corners = {p + edge * piece.from, p + edge * piece.to, across(piece.from), across(piece.to),
                   p + edge * piece.to};
        if (piece.from < apex && apex < piece.to) corners[4] = r;
    }
    Vec3d low = corners[0], high = corners[0];
    for (const Vec3d& corner : corners)
        for (int k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], corner[k]);
            high[k] = std::max(high[k], corner[k]);
        }
    *args->bounds_o = {round_down(low.x), round_down(low.y), round_down(low.z), 0,
                       round_up(high.x),  round_up(high.y),  round_up(high.z),  0};
}

/// One device a process, until the process ends. Builds use the caller's TBB arena: "threads=1" would limit TBB for the
/// whole process.
RTCDevice device() {
    static RTCDevice instance = rtcNewDevice("set_affinity=0");
    if (instance == nullptr)
        throw model::Error(model::codes::kSystemBusy,
                           "Embree cannot start (error " + std::to_string(rtcGetDeviceError(nullptr)) + ")");
    return instance;
}
}  // namespace

struct ClosestPointIndex::Impl {
    std::vector<Triangle> triangles;
    std::vector<Vec3d> unit_normals;
    std::vector<Piece> pieces;
    Held held{};
    std::vector<std::uint32_t> triangle_of_face;  // kNone for faces left out
    Vec3d centre;
    double to_unit = 1, from_unit = 1;
    RTCScene scene = nullptr;

    Impl(std::span<const Vec3d> positions, std::span<const Face> faces) {
        fit_frame(positions, faces);
        add_triangles(positions, faces);
        if (triangles.size() > kFewTriangles) build();
    }
    ~Impl() {
        if (scene != nullptr) rtcReleaseScene(scene);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    static bool usable(std::span<const Vec3d> positions, const Face& f) {
        for (const std::uint32_t v : f)
            if (v >= positions.size() || !is_finite(positions[v])) return false;
        return true;
    }

    void fit_frame(std::span<const Vec3d> positions, std::span<const Face> faces) {
        Vec3d low{kInfinity, kInfinity, kInfinity}, high = -low;
        for (const Face& f : faces) {
            if (!usable(positions, f)) continue;
            for (const std::uint32_t v : f)
                for (int k = 0; k < 3; ++k) {
                    low[k] = std::min(low[k], positions[v][k]);
                    high[k] = std::max(high[k], positions[v][k]);
                }
        }
        if (!is_finite(low)) return;
        centre = low * 0.5 + high * 0.5;
        const double half = box_diagonal_half(high * 0.5 - low * 0.5);
        if (half > 0 && std::isfinite(0.5 / half)) {
            to_unit = 0.5 / half;
            from_unit = 2 * half;
        }
    }

    [[nodiscard]] Vec3d normalise(const Vec3d& p) const { return (p - centre) * to_unit; }

    void add_triangles(std::span<const Vec3d> positions, std::span<const Face> faces) {
        triangles.reserve(faces.size());
        unit_normals.reserve(faces.size());
        triangle_of_face.assign(faces.size(), kNone);
        for (std::size_t f = 0; f < faces.size(); ++f) {
            if (!usable(positions, faces[f])) continue;
            const auto [i, j, k] = faces[f];
            Triangle tri;
            tri.a = normalise(positions[i]);
            tri.b = normalise(positions[j]);
            tri.c = normalise(positions[k]);
            const Vec3d ab = tri.b - tri.a, ac = tri.c - tri.a, bc = tri.c - tri.b;
            const double longest = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
            tri.normal = cross(ab, ac);
            tri.normal_squared = dot(tri.normal, tri.normal);
            if (!(tri.normal_squared > kSliverSineSquared * longest * longest) ||
                !(tri.normal_squared > std::numeric_limits<double>::min())) {
                tri.normal = {};
                tri.normal_squared = 0;
            }
            tri.face = static_cast<std::uint32_t>(f);
            tri.swap_ab = j < i;
            tri.swap_bc = k < j;
            tri.swap_ca = i < k;
            triangle_of_face[f] = static_cast<std::uint32_t>(triangles.size());
            triangles.push_back(tri);
            unit_normals.push_back(normalized(cross(ab, ac), {}));
        }
    }

    void build() {
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            const int count = piece_count(triangles[t]);
            for (int k = 0; k < count; ++k)
                pieces.push_back({t, static_cast<float>(k) / static_cast<float>(count),
                                  static_cast<float>(k + 1) / static_cast<float>(count)});
        }
        held = {triangles.data(), pieces.data()};
        RTCDevice embree = device();
        scene = rtcNewScene(embree);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
        RTCGeometry geometry = rtcNewGeometry(embree, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(pieces.size()));
        rtcSetGeometryUserData(geometry, &held);
        rtcSetGeometryBoundsFunction(geometry, on_bounds, nullptr);
        rtcSetGeometryPointQueryFunction(geometry, on_candidate);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);
        const RTCError error = rtcGetDeviceError(embree);
        if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
        if (error != RTC_ERROR_NONE)
            throw model::Error(model::codes::kSystemBusy, "Embree cannot build a hierarchy over " +
                                                              std::to_string(triangles.size()) + " faces (error " +
                                                              std::to_string(error) + ")");
    }

    [[nodiscard]] ClosestPoint run(Search& search, const Vec3d& p, std::uint32_t hint) const {
        search.point = normalise(p);
        search.triangles = triangles.data();
        search.pieces = pieces.data();
        if (triangles.empty() || !is_finite(search.point)) return {};
        search.reach = std::max({std::abs(search.point.x), std::abs(search.point.y), std::abs(search.point.z), 1.0});
        if (hint < triangle_of_face.size() && triangle_of_face[hint] != kNone) search.visit(triangle_of_face[hint]);
        if (scene == nullptr || search.reach > kFarDiagonals) {
            for (std::uint32_t t = 0; t < triangles.size(); ++t) search.visit(t);
        } else {
            RTCPointQuery query{static_cast<float>(search.point.x), static_cast<float>(search.point.y),
                                static_cast<float>(search.point.z), 0, search.radius()};
            RTCPointQueryContext context;
            rtcInitPointQueryContext(&context);
            rtcPointQuery(scene, &query, &context, nullptr, &search);
        }
        const Nearest& found = search.nearest;
        if (found.face == kNone) return {};
        return {centre + found.point * from_unit,
                found.face,
                {found.barycentric[0], found.barycentric[1], found.barycentric[2]},
                std::sqrt(found.squared) * from_unit};
    }
};

ClosestPointIndex::ClosestPointIndex(std::span<const Vec3d> positions, std::span<const Face> faces)
    : impl_(std::make_unique<Impl>(positions, faces)) {}
ClosestPointIndex::~ClosestPointIndex() = default;
ClosestPointIndex::ClosestPointIndex(ClosestPointIndex&&) noexcept = default;
ClosestPointIndex& ClosestPointIndex::operator=(ClosestPointIndex&&) noexcept = default;

ClosestPoint ClosestPointIndex::query(const Vec3d& point, std::uint32_t hint) const {
    Search search;
    return impl_->run(search, point, hint);
}

ClosestPoint ClosestPointIndex::query_facing(const Vec3d& point, const Vec3d& normal, double min_cosine,
                                             std::uint32_t hint, double limit) const {
    Search search;
    // Wider by more than the rounding of the frame, so that the limit itself is found.
    const double reach = limit * impl_->to_unit * (1 + 1e-6) + 1e-12;
    search.nearest.squared = reach * reach;
    search.unit_normals = impl_->unit_normals.data();
    search.direction = normal;
    search.min_cosine = min_cosine;
    return impl_->run(search, point, hint);
}

Vec3d ClosestPointIndex::unit_normal(std::uint32_t face) const {
    const std::uint32_t triangle = impl_->triangle_of_face[face];
    return triangle == kNone ? Vec3d{} : impl_->unit_normals[triangle];
}

ClosestPoint ClosestPointIndex::query_preferring(const Vec3d& point, const Vec3d& normal, double slack,
                                                 std::uint32_t hint) const {
    constexpr double kMinCosine = 0.3;
    const ClosestPoint any = query(point, hint);
    if (any.face == kNoFace || dot(unit_normal(any.face), normal) > kMinCosine) return any;
    const double limit = 2 * any.distance + slack;
    const ClosestPoint same = query_facing(point, normal, kMinCosine, kNoFace, limit);
    return same.face != kNoFace && same.distance <= limit ? same : any;
}

}  // namespace dgm::bake
