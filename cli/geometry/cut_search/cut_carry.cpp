// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/cut_carry.cpp
#include "geometry/cut_search/cut_carry.h"

#include <algorithm>

namespace dgm::bake {
namespace {

class Network {
 public:
    Network(const CutGraph& coarse, std::span<const std::uint32_t> original, const CutGraph& fine)
        : positions_(fine.mesh().positions), at_(positions_.size()), on_border_(positions_.size(), 0) {
        const std::span<const Face> coarse_faces = coarse.mesh().faces, faces = fine.mesh().faces;
        for (std::uint32_t h = 0; h < coarse.opposite().size(); ++h)
            if (coarse.is_cut(h) && h < coarse.opposite()[h])
                add(original[origin(coarse_faces, h)], original[target(coarse_faces, h)]);
        for (std::uint32_t h = 0; h < fine.opposite().size(); ++h)
            if (fine.opposite()[h] == kNone) on_border_[origin(faces, h)] = 1;
    }

    void take_back(const Collapse& c, std::span<const std::uint32_t> link) {
        const std::vector<std::uint32_t> edges = at_[c.kept];
        if (edges.empty()) return;
        const std::size_t count = link.size();
        const auto k = static_cast<std::size_t>(std::find(link.begin(), link.end(), c.kept) - link.begin());
        // The two that see both ends of the edge; an open link ends where it begins.
        const std::uint32_t before = k > 0 ? link[k - 1] : c.closed ? link[count - 1] : kNone;
        const std::uint32_t after = k + 1 < count ? link[k + 1] : c.closed ? link[0] : kNone;
        std::vector<std::uint32_t> moved, either;
        for (const std::uint32_t w : edges) {
            if (w == before || w == after)
                either.push_back(w);
            else if (std::find(link.begin(), link.end(), w) != link.end())
                moved.push_back(w);
        }
        if (moved.empty()) return;
        const bool stays = moved.size() + either.size() < edges.size();
        const bool tip = edges.size() == 1;  // of a dead end: it was put there on purpose
        const bool joined = stays || tip || on_border_[c.kept];
        for (const std::uint32_t w : moved) move(w, c);
        for (const std::uint32_t w : either)
            if (!joined || distance(w, c.removed) < distance(w, c.kept)) move(w, c);
        if (joined && c.closed) add(c.kept, c.removed);
    }

    [[nodiscard]] std::vector<std::pair<std::uint32_t, std::uint32_t>> edges() const {
        std::vector<std::pair<std::uint32_t, std::uint32_t>> out;
        for (std::uint32_t v = 0; v < at_.size(); ++v)
            for (const std::uint32_t w : at_[v])
                if (v < w) out.emplace_back(v, w);
        std::sort(out.begin(), out.end());
        return out;
    }

 private:
    void add(std::uint32_t a, std::uint32_t b) {
        at_[a].push_back(b);
        at_[b].push_back(a);
    }
    void move(std::uint32_t w, const Collapse& c) {
        std::erase(at_[c.kept], w);
        std::replace(at_[w].begin(), at_[w].end(), c.kept, c.removed);
        at_[c.removed].push_back(w);
    }
    [[nodiscard]] double distance(std::uint32_t a, std::uint32_t b) const {
        return length(positions_[a] - positions_[b]);
    }

    std::span<const Vec3d> positions_;
    std::vector<std::vector<std::uint32_t>> at_;  // per vertex: the other ends of its edges
    std::vector<char> on_border_;
};

}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> carry_cut(const CutGraph& coarse,
                                                               std::span<const std::uint32_t> original,
                                                               const Simplified& simplified, const CutGraph& fine) {
    Network network(coarse, original, fine);
    for (std::size_t k = simplified.collapses.size(); k-- > 0;)
        network.take_back(simplified.collapses[k], simplified.link(simplified.collapses[k]));
    return network.edges();
}

}  // namespace dgm::bake
