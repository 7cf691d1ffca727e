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
#include <utility>
#include <vector>

#include "geometry/mesh/infinity.h"
#include "geometry/spatial/box_tree.h"
#include "geometry/spatial/triangles.h"
#include "geometry/spatial/without_parent.h"
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

double box_diagonal_half(const Vec3d& half) {
    return math::hypot(half.x, half.y, half.z);
}

/// A float that differs from f by one or two units in the last place: std::nextafter() takes longer than all the rest
/// of a box.
float step_of(float f) {
    return std::abs(f) * std::numeric_limits<float>::epsilon() + std::numeric_limits<float>::denorm_min();
}
float round_down(double x) {
    const float f = static_cast<float>(x);
    return f <= x ? f : f - step_of(f);
}
float round_up(double x) {
    const float f = static_cast<float>(x);
    return f >= x ? f : f + step_of(f);
}

/// The part of a triangle between two shares of its longest edge, seen at right angles to it: what the hierarchy holds.
/// A box around a whole needle is nearly empty. Or a crowd of tiny triangles or all needles, in a hierarchy of its own.
struct Piece {
    std::uint32_t triangle = 0;
    float from = 0, to = 1;
    std::uint32_t crowd = kNone;
};
constexpr double kNeedle = 32;      ///< length over height of a triangle that is taken to pieces
constexpr double kPieceLength = 8;  ///< of a piece, in heights
constexpr int kMaxPieces = 16;
// The border strip of a comb's free chart has half a million needles. A hierarchy of all their pieces would take
// gigabytes and most of the time: beyond so many triangles they get fewer.
constexpr std::size_t kMostPieces = 1'000'000;
// Of more, the hierarchy is one by Morton codes: 47 bytes each less, built in four fifths of the time; of a dense scan
// it answers a tenth more slowly.
constexpr std::size_t kManyPieces = 500'000;
// A polygon with 100 000 corners in line on one side is a fan of needles, and boxes of their pieces overlap in
// thousands. Where a point lies in so many on average, needles have a hierarchy of their own, whole.
constexpr double kManyOverlap = 400;
constexpr double kTiny = 1e-4;       ///< longest edge, in diagonals, of a triangle that may belong to a crowd
constexpr double kCrowdSide = 1e-3;  ///< of the cube that holds its middle, in diagonals
constexpr std::size_t kCrowd = 64;   ///< least triangles of one

// A face so low, in diagonals, has the normal that rounding gave it: what a split next to a corner leaves of a face.
constexpr double kNoHeight = 1e-13;

/// Zero for a triangle without area. Made anew for each that is asked about: stored, it would take 24 bytes a face.
Vec3d unit_normal_of(const Triangle& t) {
    const Vec3d p = t.b - t.a, q = t.c - t.a, area = cross(p, q);
    const double longest = std::max({dot(p, p), dot(q, q), dot(q - p, q - p)});
    return dot(area, area) > kNoHeight * kNoHeight * longest ? normalized(area, {}) : Vec3d{};
}

struct Search {
    const Triangles* triangles = nullptr;
    const Piece* pieces = nullptr;
    const BoxTree* crowds = nullptr;
    Vec3d point;       // normalised frame
    double reach = 0;  // largest coordinate of point, at least 1: what the float slack is relative to
    Nearest nearest;
    bool facing = false;  // else every face may match
    Vec3d direction;
    double min_cosine = 0;

    /// Returns true if the triangle became the nearest.
    bool visit(std::uint32_t index) {
        const Triangle tri = (*triangles)[index];
        if (plane_is_farther(tri, point, nearest.squared)) return false;
        if (facing) {
            const Vec3d n = unit_normal_of(tri);
            if ((n.x == 0 && n.y == 0 && n.z == 0) || !(dot(n, direction) > min_cosine)) return false;
        }
        Vec3d q;
        std::array<double, 3> bary{};
        const double squared = triangle_distance(tri, point, q, bary);
        if (!(squared < nearest.squared || (squared == nearest.squared && tri.face < nearest.face))) return false;
        nearest = {squared, tri.face, index, q, bary};
        return true;
    }

    /// Returns true if a triangle of the piece became the nearest.
    bool visit(const Piece& piece) {
        if (piece.crowd == kNone) return visit(piece.triangle);
        bool nearer = false;
        crowds[piece.crowd].search(point, reach, nearest, [&](std::uint32_t t) { nearer = visit(t) || nearer; });
        return nearer;
    }

    [[nodiscard]] float radius() const {
        const double d = std::sqrt(nearest.squared);
        return round_up(d + kFloatSlack * (d + reach));
    }
};

/// Number of pieces in which a triangle would be stored; 1 unless it is a needle.
std::uint8_t piece_count(const Triangle& tri) {
    const Vec3d normal = cross(tri.b - tri.a, tri.c - tri.a);
    const double squared = longest_edge_squared({tri.a, tri.b, tri.c}), area = length(normal);
    if (!(squared > kNeedle * area)) return 1;
    return static_cast<std::uint8_t>(std::min<double>(kMaxPieces, std::ceil(squared / (kPieceLength * area))));
}

void extend(Vec3d& low, Vec3d& high, std::span<const Vec3d> points) {
    for (const Vec3d& p : points)
        for (int k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], p[k]);
            high[k] = std::max(high[k], p[k]);
        }
}

/// The area of the largest side of a box.
double face_of_box(const Vec3d& size) {
    return std::max({size.x * size.y, size.y * size.z, size.z * size.x});
}

/// Data that the scene's functions see.
struct Held {
    const Triangles* triangles;
    const Piece* pieces;
    const BoxTree* crowds;
};

bool on_candidate(RTCPointQueryFunctionArguments* args) {
    auto& search = *static_cast<Search*>(args->userPtr);
    if (!search.visit(search.pieces[args->primID])) return false;
    args->query->radius = std::min(args->query->radius, search.radius());
    return true;
}

RTCBounds outward(const Vec3d& low, const Vec3d& high) {
    return {round_down(low.x), round_down(low.y), round_down(low.z), 0,
            round_up(high.x),  round_up(high.y),  round_up(high.z),  0};
}

/// Of a part of a needle with the longest edge from p to q.
std::array<Vec3d, 5> corners_of(const Piece& piece, const Vec3d& p, const Vec3d& q, const Vec3d& r) {
    const Vec3d edge = q - p;
    const double apex = std::clamp(dot(r - p, edge) / dot(edge, edge), 0.0, 1.0);
    // Across from the share t of the longest edge, on the other two.
    const auto across = [&](double t) {
        return t < apex ? p + (r - p) * (t / apex) : t < 1 ? r + (q - r) * ((t - apex) / (1 - apex)) : q;
    };
    std::array<Vec3d, 5> out{p + edge * piece.from, p + edge * piece.to, across(piece.from), across(piece.to),
                             p + edge * piece.to};
    if (piece.from < apex && apex < piece.to) out[4] = r;
    return out;
}

void on_bounds(const RTCBoundsFunctionArguments* args) {
    const Held& held = *static_cast<const Held*>(args->geometryUserPtr);
    const Piece& piece = held.pieces[args->primID];
    if (piece.crowd != kNone) {
        const auto& [low, high] = held.crowds[piece.crowd].bounds();
        *args->bounds_o = outward(low, high);
        return;
    }
    const Triangle triangle = (*held.triangles)[piece.triangle];
    Vec3d low = triangle.a, high = low;
    if (piece.from <= 0 && piece.to >= 1) {
        extend(low, high, std::array{triangle.b, triangle.c});
    } else {
        const auto [p, q, r] = from_longest_edge(triangle);
        const std::array<Vec3d, 5> corners = corners_of(piece, p, q, r);
        low = high = corners[0];
        extend(low, high, corners);
    }
    *args->bounds_o = outward(low, high);
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
    Triangles triangles;
    std::vector<Piece> pieces;
    std::vector<BoxTree> crowds;
    Held held{};
    std::vector<std::uint32_t> triangle_of_face;  // kNone for faces left out
    Vec3d centre;
    double to_unit = 1, from_unit = 1;
    RTCScene scene = nullptr;

    Impl(std::span<const Vec3d> positions, std::span<const Face> faces) {
        std::vector<std::uint32_t> used = used_vertices(positions, faces);
        fit_frame(positions, used);
        add_triangles(positions, faces, used);
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

    /// Per position, its number among those that faces use; kNone for the others.
    static std::vector<std::uint32_t> used_vertices(std::span<const Vec3d> positions, std::span<const Face> faces) {
        std::vector<std::uint32_t> number(positions.size(), kNone);
        for (const Face& f : faces)
            if (usable(positions, f))
                for (const std::uint32_t v : f) number[v] = 0;
        std::uint32_t count = 0;
        for (std::uint32_t& n : number)
            if (n != kNone) n = count++;
        return number;
    }

    void fit_frame(std::span<const Vec3d> positions, std::span<const std::uint32_t> used) {
        Vec3d low{kInfinity, kInfinity, kInfinity}, high = -low;
        for (std::size_t v = 0; v < used.size(); ++v)
            if (used[v] != kNone) extend(low, high, positions.subspan(v, 1));
        if (!is_finite(low)) return;
        centre = low * 0.5 + high * 0.5;
        const double half = box_diagonal_half(high * 0.5 - low * 0.5);
        if (half > 0 && std::isfinite(0.5 / half)) {
            to_unit = 0.5 / half;
            from_unit = 2 * half;
        }
    }

    [[nodiscard]] Vec3d normalise(const Vec3d& p) const { return (p - centre) * to_unit; }

    void add_triangles(std::span<const Vec3d> positions, std::span<const Face> faces,
                       std::span<const std::uint32_t> used) {
        std::vector<Vec3d> vertices;
        vertices.reserve(used.size());
        for (std::size_t v = 0; v < used.size(); ++v)
            if (used[v] != kNone) vertices.push_back(normalise(positions[v]));
        triangles = Triangles(std::move(vertices));
        triangles.reserve(faces.size());
        triangle_of_face.assign(faces.size(), kNone);
        for (std::size_t f = 0; f < faces.size(); ++f) {
            if (!usable(positions, faces[f])) continue;
            const auto [i, j, k] = faces[f];
            triangle_of_face[f] = static_cast<std::uint32_t>(triangles.size());
            triangles.add(used[i], used[j], used[k], static_cast<std::uint32_t>(f));
        }
    }

    /// Fills `crowds`, and `pieces` with one for each. Returns whether a triangle belongs to one.
    std::vector<char> gather_crowds() {
        std::vector<char> crowded(triangles.size(), 0);
        std::vector<std::pair<std::array<std::int64_t, 3>, std::uint32_t>> tiny;
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            const Triangle q = triangles[t];
            if (!(longest_edge_squared({q.a, q.b, q.c}) < kTiny * kTiny)) continue;
            std::array<std::int64_t, 3> cube{};
            for (int k = 0; k < 3; ++k)
                cube[k] = static_cast<std::int64_t>(std::floor((q.a[k] + q.b[k] + q.c[k]) / (3 * kCrowdSide)));
            tiny.emplace_back(cube, t);
        }
        std::sort(tiny.begin(), tiny.end());
        for (auto first = tiny.begin(); first != tiny.end();) {
            const auto last = std::find_if(first, tiny.end(), [&](const auto& e) { return e.first != first->first; });
            if (static_cast<std::size_t>(last - first) >= kCrowd) {
                std::vector<std::uint32_t> members;
                for (auto k = first; k != last; ++k) members.push_back(k->second);
                set_apart(std::move(members), BoxTree::Of::kCrowd, crowded);
            }
            first = last;
        }
        return crowded;
    }

    /// All needles, if too many of their pieces would overlap, but for those of `apart`, where it marks them.
    void gather_needles(int most, std::span<const std::uint8_t> counts, std::vector<char>& apart) {
        std::vector<std::uint32_t> needles;
        Vec3d low{kInfinity, kInfinity, kInfinity}, high = -low;
        extend(low, high, triangles.vertices());
        double covered = 0;
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            if (apart[t] || counts[t] == 1) continue;
            const Triangle q = triangles[t];
            Vec3d from = q.a, to = q.a;
            extend(from, to, std::array{q.b, q.c});
            needles.push_back(t);
            covered += face_of_box(to - from);
        }
        if (!(covered > kManyOverlap * most * face_of_box(high - low))) return;
        set_apart(std::move(needles), BoxTree::Of::kNeedles, apart);
    }

    /// Triangles in a hierarchy of their own, unless there are none.
    void set_apart(std::vector<std::uint32_t> members, BoxTree::Of of, std::vector<char>& apart) {
        if (members.empty()) return;
        for (const std::uint32_t t : members) apart[t] = 1;
        pieces.push_back({0, 0, 1, static_cast<std::uint32_t>(crowds.size())});
        crowds.emplace_back(triangles, std::move(members), of);
    }

    void build() {
        std::vector<char> apart = gather_crowds();
        const int most = std::clamp(static_cast<int>(kMostPieces / triangles.size()), 1, kMaxPieces);
        std::vector<std::uint8_t> counts(triangles.size());
        for (std::uint32_t t = 0; t < triangles.size(); ++t) counts[t] = piece_count(triangles[t]);
        gather_needles(most, counts, apart);
        set_apart(crossing_facets(triangles, apart), BoxTree::Of::kFacets, apart);
        pieces.reserve(pieces.size() + triangles.size());
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            if (apart[t]) continue;
            const int count = std::min<int>(most, counts[t]);
            for (int k = 0; k < count; ++k)
                pieces.push_back({t, static_cast<float>(k) / static_cast<float>(count),
                                  static_cast<float>(k + 1) / static_cast<float>(count), kNone});
        }
        held = {&triangles, pieces.data(), crowds.data()};
        RTCDevice embree = device();
        scene = rtcNewScene(embree);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        const bool many = pieces.size() > kManyPieces;
        rtcSetSceneBuildQuality(scene, many ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
        RTCGeometry geometry = rtcNewGeometry(embree, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(pieces.size()));
        rtcSetGeometryUserData(geometry, &held);
        rtcSetGeometryBoundsFunction(geometry, on_bounds, nullptr);
        rtcSetGeometryPointQueryFunction(geometry, on_candidate);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        without_parent([this] { rtcCommitScene(scene); });
        const RTCError error = rtcGetDeviceError(embree);
        if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
        if (error != RTC_ERROR_NONE)
            throw model::Error(model::codes::kSystemBusy, "Embree cannot build a hierarchy over " +
                                                              std::to_string(triangles.size()) + " faces (error " +
                                                              std::to_string(error) + ")");
    }

    [[nodiscard]] ClosestPoint run(Search& search, const Vec3d& p, std::uint32_t hint) const {
        search.point = normalise(p);
        search.triangles = &triangles;
        search.pieces = pieces.data();
        search.crowds = crowds.data();
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
    search.facing = true;
    search.direction = normal;
    search.min_cosine = min_cosine;
    return impl_->run(search, point, hint);
}

std::size_t ClosestPointIndex::pieces() const {
    return impl_->pieces.size();
}

double ClosestPointIndex::diagonal() const {
    return impl_->from_unit;
}

Vec3d ClosestPointIndex::unit_normal(std::uint32_t face) const {
    const std::uint32_t triangle = impl_->triangle_of_face[face];
    return triangle == kNone ? Vec3d{} : unit_normal_of(impl_->triangles[triangle]);
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
