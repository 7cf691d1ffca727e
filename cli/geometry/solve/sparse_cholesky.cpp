// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/solve/sparse_cholesky.cpp
// [Duff, Reid 1983] The multifrontal solution of indefinite sparse symmetric linear equations. ACM TOMS 9(3).
// [Liu 1990] The role of elimination trees in sparse factorization. SIAM J. Matrix Anal. 11(1).
// [Liu 1992] The multifrontal method for sparse matrix solution: theory and practice. SIAM Review 34(1).
// [Ashcraft, Grimes 1989] The influence of relaxed supernode partitions on the multifrontal method. ACM TOMS 15(4).
//
// Words: a node is a block of unknowns; columns are nodes in elimination order; a supernode is a run of columns whose
// columns of L have the same rows below the run; its front is the dense matrix over the run's rows and those below.
#include "geometry/solve/sparse_cholesky.h"

#include <iostream>  // MetisSupport writes to std::cerr and does not include it

#include <Eigen/MetisSupport>
#include <Eigen/OrderingMethods>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include "geometry/solve/rank_update.h"

namespace dgm::bake {
namespace {
using SparseMatrix = Eigen::SparseMatrix<double>;
using Index = std::int32_t;
using Wide = std::size_t;

constexpr Index kNone = -1;
constexpr Wide kPanel = 48;         // columns factorized before the rest of a front is updated
constexpr Wide kDenseUpdate = 128;  // rows from which the update of the rest is worth packing

/// Neighbours of each node, both directions, without itself.
struct Graph {
    std::vector<Index> first, neighbour;
};

Graph node_graph(const SparseMatrix& lower, Index block) {
    const Index nodes = static_cast<Index>(lower.rows()) / block;
    Graph g;
    g.first.assign(static_cast<Wide>(nodes) + 1, 0);
    std::vector<Index> last(static_cast<Wide>(nodes), kNone);
    const auto each_pair = [&](const auto& visit) {
        std::fill(last.begin(), last.end(), kNone);
        for (Index j = 0; j < nodes; ++j)
            for (Index c = j * block; c < (j + 1) * block; ++c)
                for (SparseMatrix::InnerIterator it(lower, c); it; ++it) {
                    const Index i = static_cast<Index>(it.row()) / block;
                    if (it.row() < c || i == j || last[static_cast<Wide>(i)] == j) continue;
                    last[static_cast<Wide>(i)] = j;
                    visit(static_cast<Wide>(i), static_cast<Wide>(j));
                }
    };
    each_pair([&](Wide i, Wide j) {
        ++g.first[i + 1];
        ++g.first[j + 1];
    });
    for (Wide k = 0; k < static_cast<Wide>(nodes); ++k) g.first[k + 1] += g.first[k];
    g.neighbour.resize(static_cast<Wide>(g.first.back()));
    std::vector<Index> fill(g.first.begin(), g.first.end() - 1);
    each_pair([&](Wide i, Wide j) {
        g.neighbour[static_cast<Wide>(fill[i]++)] = static_cast<Index>(j);
        g.neighbour[static_cast<Wide>(fill[j]++)] = static_cast<Index>(i);
    });
    return g;
}

/// Position of each node in the order of elimination.
std::vector<Index> order_nodes(const Graph& g, Ordering ordering) {
    const auto nodes = static_cast<Index>(g.first.size()) - 1;
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(g.neighbour.size() + static_cast<Wide>(nodes));
    for (Index j = 0; j < nodes; ++j) {
        entries.emplace_back(j, j, 1.0);
        for (Index e = g.first[static_cast<Wide>(j)]; e < g.first[static_cast<Wide>(j) + 1]; ++e)
            entries.emplace_back(g.neighbour[static_cast<Wide>(e)], j, 1.0);
    }
    SparseMatrix pattern(nodes, nodes);
    pattern.setFromTriplets(entries.begin(), entries.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    if (ordering == Ordering::kNestedDissection && nodes > 1) {
        // METIS draws from a generator with global state, which it seeds itself: one call at a time, always alike.
        static std::mutex one_at_a_time;
        const std::scoped_lock lock(one_at_a_time);
        Eigen::MetisOrdering<int>()(pattern, order);
    } else {
        Eigen::AMDOrdering<int>()(pattern, order);
    }
    std::vector<Index> position(static_cast<Wide>(nodes));
    for (Index k = 0; k < nodes; ++k) position[static_cast<Wide>(order.indices()[k])] = k;
    return position;
}

/// Elimination tree over columns; `lower_neighbours(j, visit)` names the earlier columns that column j touches.
template <typename LowerNeighbours>
std::vector<Index> elimination_tree(Index columns, const LowerNeighbours& lower_neighbours) {
    std::vector<Index> parent(static_cast<Wide>(columns), kNone), ancestor(static_cast<Wide>(columns), kNone);
    for (Index j = 0; j < columns; ++j)
        lower_neighbours(j, [&](Index i) {
            while (i != j) {
                const Index next = ancestor[static_cast<Wide>(i)];
                ancestor[static_cast<Wide>(i)] = j;
                if (next == kNone) parent[static_cast<Wide>(i)] = j;
                if (next == kNone) break;
                i = next;
            }
        });
    return parent;
}

/// New number of each column such that every subtree is a run of numbers.
std::vector<Index> postorder(const std::vector<Index>& parent) {
    const auto n = static_cast<Index>(parent.size());
    std::vector<Index> head(parent.size(), kNone), next(parent.size(), kNone), number(parent.size());
    for (Index j = n; j-- > 0;)
        if (const Index p = parent[static_cast<Wide>(j)]; p != kNone) {
            next[static_cast<Wide>(j)] = head[static_cast<Wide>(p)];
            head[static_cast<Wide>(p)] = j;
        }
    Index count = 0;
    std::vector<Index> stack;
    for (Index root = 0; root < n; ++root) {
        if (parent[static_cast<Wide>(root)] != kNone) continue;
        stack.push_back(root);
        while (!stack.empty()) {
            const auto j = static_cast<Wide>(stack.back());
            if (head[j] != kNone) {
                stack.push_back(head[j]);
                head[j] = next[static_cast<Wide>(head[j])];
            } else {
                number[j] = count++;
                stack.pop_back();
            }
        }
    }
    return number;
}

/// Columns [0, columns) of the lower trapezoid F (leading dimension n): L in place, and the rest of F less L L^T.
class Front {
 public:
    Front(double* values, Wide n, std::vector<double>& work) : f_(values), n_(n), work_(work) {}

    [[nodiscard]] bool factorize(Wide columns) {
        for (Wide begin = 0; begin < columns; begin += kPanel) {
            const Wide end = std::min(columns, begin + kPanel);
            for (Wide c = begin; c < end;) {
                const Wide stop = std::min(end, c + 4);
                for (Wide q = c; q < stop; ++q) {
                    for (Wide p = c; p < q; ++p) subtract_one(q, p);
                    if (!scale(q)) return false;
                }
                update(c, stop, stop, end);
                c = stop;
            }
            const Wide rest = n_ - end;
            if (rest >= kDenseUpdate && end - begin >= 16) {
                subtract_square(f_ + end * n_ + end, f_ + begin * n_ + end, rest, end - begin, n_, work_);
            } else {
                for (Wide c = begin; c < end; c += 4) update(c, std::min(end, c + 4), end, n_);
            }
        }
        return true;
    }

 private:
    [[nodiscard]] double* column(Wide c) const { return f_ + c * n_; }

    void subtract_one(Wide target, Wide source) {
        double* t = column(target);
        const double* s = column(source);
        const double factor = s[target];
        for (Wide i = target; i < n_; ++i) t[i] -= factor * s[i];
    }
    [[nodiscard]] bool scale(Wide c) {
        double* t = column(c);
        const double pivot = t[c];
        if (!(pivot > 0) || !std::isfinite(pivot)) return false;
        t[c] = std::sqrt(pivot);
        const double inverse = 1 / t[c];
        for (Wide i = c + 1; i < n_; ++i) t[i] *= inverse;
        return true;
    }
    /// Subtracts columns [from, to), at most four, from columns [begin, end).
    void update(Wide from, Wide to, Wide begin, Wide end) {
        if (to - from != 4) {
            for (Wide j = begin; j < end; ++j)
                for (Wide p = from; p < to; ++p) subtract_one(j, p);
            return;
        }
        const double* __restrict a = column(from);
        const double* __restrict b = column(from + 1);
        const double* __restrict c = column(from + 2);
        const double* __restrict d = column(from + 3);
        Wide j = begin;
        for (; j + 1 < end; j += 2) {
            double* __restrict s = column(j);
            double* __restrict t = column(j + 1);
            const double a0 = a[j], b0 = b[j], c0 = c[j], d0 = d[j];
            const double a1 = a[j + 1], b1 = b[j + 1], c1 = c[j + 1], d1 = d[j + 1];
            s[j] -= (a0 * a0 + b0 * b0) + (c0 * c0 + d0 * d0);
            for (Wide i = j + 1; i < n_; ++i) {
                s[i] -= (a0 * a[i] + b0 * b[i]) + (c0 * c[i] + d0 * d[i]);
                t[i] -= (a1 * a[i] + b1 * b[i]) + (c1 * c[i] + d1 * d[i]);
            }
        }
        if (j < end) {
            double* __restrict s = column(j);
            const double a0 = a[j], b0 = b[j], c0 = c[j], d0 = d[j];
            for (Wide i = j; i < n_; ++i) s[i] -= (a0 * a[i] + b0 * b[i]) + (c0 * c[i] + d0 * d[i]);
        }
    }

    double* f_;
    Wide n_;
    std::vector<double>& work_;
};
}  // namespace

struct SparseCholesky::State {
    struct Supernode {
        Index begin = 0, end = 0;  // columns
        Index parent = kNone;      // supernode
        Wide rows_at = 0;          // of its rows below, in `rows`
        Wide below = 0;            // how many
        Wide values_at = 0;        // of its part of L, in `values`: front rows x own columns, column by column
        Wide entries_at = 0;       // of what it takes from A, in `entry`
    };
    Index block = 1, columns = 0;
    std::vector<Index> position;  // node -> column
    std::vector<Supernode> nodes;
    std::vector<Index> rows;
    std::vector<std::pair<Index, Wide>> entry;  // entry of A, place in the front
    std::vector<double> values;
    Wide largest_front = 0, largest_stack = 0;
    std::vector<double> front_buffer, stack_buffer;  // of factorize(), kept: fresh pages cost as much as the sums

    [[nodiscard]] Wide own(const Supernode& s) const { return static_cast<Wide>(s.end - s.begin) * width(); }
    [[nodiscard]] Wide front(const Supernode& s) const { return own(s) + s.below * width(); }
    [[nodiscard]] Wide width() const { return static_cast<Wide>(block); }

    void find_supernodes(const std::vector<Index>& parent, const std::vector<Index>& count);
    void find_rows(const std::vector<Index>& parent, const Graph& graph, const std::vector<Index>& node_of);
    void place_entries(const SparseMatrix& lower);
    template <int kColumns>
    void substitute(double* x) const;
};

void SparseCholesky::State::find_supernodes(const std::vector<Index>& parent, const std::vector<Index>& count) {
    struct Run {
        Index begin, end;
        double entries;  // of L, without padding
    };
    const auto triangle = [](double c, double below) { return 0.5 * c * (c + 1) + c * below; };
    std::vector<Run> runs;
    const auto absorb = [&] {
        // Two neighbouring runs become one if the zeros that this stores are few [Ashcraft, Grimes 1989].
        while (runs.size() >= 2) {
            const Run &last = runs.back(), &before = runs[runs.size() - 2];
            const Index up = parent[static_cast<Wide>(before.end) - 1];
            if (up < last.begin || up >= last.end) return;
            const double c = last.end - before.begin;
            const double stored = triangle(c, count[static_cast<Wide>(last.end) - 1]);
            const double share = 1 - (before.entries + last.entries) / stored;
            if (!(c <= 4 || (c <= 16 && share < 0.5) || (c <= 48 && share < 0.15) || share < 0.05)) return;
            const Run both{before.begin, last.end, before.entries + last.entries};
            runs.pop_back();
            runs.back() = both;
        }
    };
    for (Index j = 0; j < columns;) {
        Index end = j + 1;
        double entries = count[static_cast<Wide>(j)] + 1.0;
        while (end < columns && parent[static_cast<Wide>(end) - 1] == end &&
               count[static_cast<Wide>(end) - 1] == count[static_cast<Wide>(end)] + 1)
            entries += count[static_cast<Wide>(end++)] + 1.0;
        runs.push_back({j, end, entries});
        j = end;
        absorb();
    }
    nodes.clear();
    for (const Run& r : runs) nodes.push_back({.begin = r.begin, .end = r.end});
}

void SparseCholesky::State::find_rows(const std::vector<Index>& parent, const Graph& graph,
                                      const std::vector<Index>& node_of) {
    std::vector<Index> run_of(static_cast<Wide>(columns)), mark(static_cast<Wide>(columns), kNone);
    for (Wide s = 0; s < nodes.size(); ++s)
        for (Index c = nodes[s].begin; c < nodes[s].end; ++c) run_of[static_cast<Wide>(c)] = static_cast<Index>(s);
    std::vector<std::vector<Index>> children(nodes.size());
    rows.clear();
    Wide stack = 0, total = 0;
    largest_front = largest_stack = 0;
    for (Wide s = 0; s < nodes.size(); ++s) {
        Supernode& node = nodes[s];
        node.rows_at = rows.size();
        const auto add = [&](Index row) {
            if (row < node.end || mark[static_cast<Wide>(row)] == static_cast<Index>(s)) return;
            mark[static_cast<Wide>(row)] = static_cast<Index>(s);
            rows.push_back(row);
        };
        for (Index c = node.begin; c < node.end; ++c) {
            const auto v = static_cast<Wide>(node_of[static_cast<Wide>(c)]);
            for (Index e = graph.first[v]; e < graph.first[v + 1]; ++e)
                add(position[static_cast<Wide>(graph.neighbour[static_cast<Wide>(e)])]);
        }
        for (const Index child : children[s]) {
            const Supernode& from = nodes[static_cast<Wide>(child)];
            for (Wide k = 0; k < from.below; ++k) add(rows[from.rows_at + k]);
            stack -= from.below * from.below;
        }
        std::sort(rows.begin() + static_cast<std::ptrdiff_t>(node.rows_at), rows.end());
        node.below = rows.size() - node.rows_at;
        const Index up = parent[static_cast<Wide>(node.end) - 1];
        if (up != kNone) {
            node.parent = run_of[static_cast<Wide>(up)];
            children[static_cast<Wide>(node.parent)].push_back(static_cast<Index>(s));
        }
        node.values_at = total;
        total += front(node) * own(node);
        stack += node.below * node.below;
        largest_stack = std::max(largest_stack, stack);
        largest_front = std::max(largest_front, front(node));
    }
    largest_stack *= width() * width();
    values.assign(total, 0.0);
}

void SparseCholesky::State::place_entries(const SparseMatrix& lower) {
    std::vector<Index> run_of(static_cast<Wide>(columns));
    for (Wide s = 0; s < nodes.size(); ++s)
        for (Index c = nodes[s].begin; c < nodes[s].end; ++c) run_of[static_cast<Wide>(c)] = static_cast<Index>(s);
    // Row and column of an entry of A in elimination order, the lower of both halves.
    const auto placed = [&](Index row, Index col) {
        std::array<Index, 2> at{position[static_cast<Wide>(row / block)] * block + row % block,
                                position[static_cast<Wide>(col / block)] * block + col % block};
        if (at[0] < at[1]) std::swap(at[0], at[1]);
        return at;
    };
    std::vector<Wide> count(nodes.size() + 1, 0);
    const auto each_entry = [&](const auto& visit) {
        for (Index c = 0; c < lower.cols(); ++c)
            for (Index k = lower.outerIndexPtr()[c]; k < lower.outerIndexPtr()[c + 1]; ++k) {
                const Index row = lower.innerIndexPtr()[k];
                if (row < c) continue;
                const auto at = placed(row, c);
                visit(k, at[0], at[1], static_cast<Wide>(run_of[static_cast<Wide>(at[1] / block)]));
            }
    };
    each_entry([&](Index, Index, Index, Wide s) { ++count[s + 1]; });
    for (Wide s = 0; s < nodes.size(); ++s) {
        count[s + 1] += count[s];
        nodes[s].entries_at = count[s];
    }
    entry.resize(count.back());
    each_entry([&](Index k, Index row, Index col, Wide s) {
        const Supernode& node = nodes[s];
        Wide local = static_cast<Wide>(row - node.begin * block);
        if (row / block >= node.end) {
            const auto begin = rows.begin() + static_cast<std::ptrdiff_t>(node.rows_at);
            const auto it = std::lower_bound(begin, begin + static_cast<std::ptrdiff_t>(node.below), row / block);
            local = own(node) + static_cast<Wide>(it - begin) * width() + static_cast<Wide>(row % block);
        }
        entry[count[s]++] = {k, static_cast<Wide>(col - node.begin * block) * front(node) + local};
    });
}

SparseCholesky::SparseCholesky() : state_(std::make_unique<State>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyze(const SparseMatrix& lower, Ordering ordering, int block) {
    State& s = *state_;
    s = State();
    s.block = block;
    s.columns = static_cast<Index>(lower.rows()) / block;
    if (s.columns == 0) return;
    const Graph graph = node_graph(lower, block);
    std::vector<Index> position = order_nodes(graph, ordering);
    const auto n = static_cast<Wide>(s.columns);
    std::vector<Index> node_of(n);
    const auto invert = [&] {
        for (Wide v = 0; v < n; ++v) node_of[static_cast<Wide>(position[v])] = static_cast<Index>(v);
    };
    const auto lower_neighbours = [&](Index j, const auto& visit) {
        const auto v = static_cast<Wide>(node_of[static_cast<Wide>(j)]);
        for (Index e = graph.first[v]; e < graph.first[v + 1]; ++e)
            if (const Index i = position[static_cast<Wide>(graph.neighbour[static_cast<Wide>(e)])]; i < j) visit(i);
    };
    invert();
    const std::vector<Index> tree = elimination_tree(s.columns, lower_neighbours);
    const std::vector<Index> number = postorder(tree);
    std::vector<Index> parent(n, kNone);
    for (Wide j = 0; j < n; ++j)
        if (tree[j] != kNone) parent[static_cast<Wide>(number[j])] = number[static_cast<Wide>(tree[j])];
    for (Index& p : position) p = number[static_cast<Wide>(p)];
    invert();
    // Entries below the diagonal of each column of L: row j has one in every column on the paths of the tree from the
    // columns it touches up to j [Liu 1990].
    std::vector<Index> count(n, 0), mark(n, kNone);
    for (Index j = 0; j < s.columns; ++j) {
        mark[static_cast<Wide>(j)] = j;
        lower_neighbours(j, [&](Index i) {
            for (; mark[static_cast<Wide>(i)] != j; i = parent[static_cast<Wide>(i)]) {
                mark[static_cast<Wide>(i)] = j;
                ++count[static_cast<Wide>(i)];
            }
        });
    }
    s.position = std::move(position);
    s.find_supernodes(parent, count);
    s.find_rows(parent, graph, node_of);
    s.place_entries(lower);
}

bool SparseCholesky::factorize(const SparseMatrix& lower) {
    State& s = *state_;
    const Wide width = s.width();
    std::vector<double>&front = s.front_buffer, &stack = s.stack_buffer;
    front.resize(s.largest_front * s.largest_front);
    stack.resize(s.largest_stack);
    std::vector<Wide> local(static_cast<Wide>(s.columns)), place;
    std::vector<double> work;
    std::vector<Index> waiting;  // supernodes whose update is on the stack
    Wide top = 0;
    for (Wide k = 0; k < s.nodes.size(); ++k) {
        const State::Supernode& node = s.nodes[k];
        const Wide own = s.own(node), n = s.front(node);
        double* f = front.data();
        for (Wide c = 0; c < n; ++c) std::fill(f + c * n + c, f + (c + 1) * n, 0.0);
        const Wide entries_end = k + 1 < s.nodes.size() ? s.nodes[k + 1].entries_at : s.entry.size();
        for (Wide e = node.entries_at; e < entries_end; ++e) f[s.entry[e].second] += lower.valuePtr()[s.entry[e].first];
        for (Index c = node.begin; c < node.end; ++c)
            local[static_cast<Wide>(c)] = static_cast<Wide>(c - node.begin) * width;
        for (Wide r = 0; r < node.below; ++r) local[static_cast<Wide>(s.rows[node.rows_at + r])] = own + r * width;
        while (!waiting.empty() && s.nodes[static_cast<Wide>(waiting.back())].parent == static_cast<Index>(k)) {
            const State::Supernode& child = s.nodes[static_cast<Wide>(waiting.back())];
            waiting.pop_back();
            const Wide rest = child.below * width;
            top -= rest * rest;
            const double* u = stack.data() + top;
            place.resize(rest);
            for (Wide r = 0; r < child.below; ++r)
                for (Wide b = 0; b < width; ++b)
                    place[r * width + b] = local[static_cast<Wide>(s.rows[child.rows_at + r])] + b;
            for (Wide c = 0; c < rest; ++c) {
                double* target = f + place[c] * n;
                for (Wide r = c; r < rest; ++r) target[place[r]] += u[c * rest + r];
            }
        }
        if (!Front(f, n, work).factorize(own)) return false;
        std::copy(f, f + own * n, s.values.begin() + static_cast<std::ptrdiff_t>(node.values_at));
        if (node.below > 0) {
            const Wide rest = n - own;
            for (Wide c = 0; c < rest; ++c)
                std::copy(f + (own + c) * n + own + c, f + (own + c + 1) * n, stack.data() + top + c * rest + c);
            top += rest * rest;
            waiting.push_back(static_cast<Index>(k));
        }
    }
    return true;
}

/// x: kColumns numbers a row, rows in elimination order.
template <int kColumns>
void SparseCholesky::State::substitute(double* x) const {
    constexpr auto kWidth = static_cast<Wide>(kColumns);
    std::vector<double> work(kWidth * largest_front);
    const auto gather_below = [&](const Supernode& node, bool scatter) {
        const Wide offset = own(node);
        for (Wide r = 0; r < node.below; ++r) {
            double* at = x + static_cast<Wide>(rows[node.rows_at + r]) * width() * kWidth;
            double* w = work.data() + (offset + r * width()) * kWidth;
            for (Wide b = 0; b < width() * kWidth; ++b)
                if (scatter)
                    at[b] += w[b];
                else
                    w[b] = at[b];
        }
    };
    for (const Supernode& node : nodes) {
        const Wide k = own(node), n = front(node);
        double* w = work.data();
        double* mine = x + static_cast<Wide>(node.begin) * width() * kWidth;
        std::copy(mine, mine + k * kWidth, w);
        std::fill(w + k * kWidth, w + n * kWidth, 0.0);
        const double* l = values.data() + node.values_at;
        for (Wide c = 0; c < k; ++c, l += n) {
            std::array<double, kWidth> v;
            for (Wide q = 0; q < kWidth; ++q) v[q] = w[c * kWidth + q] /= l[c];
            for (Wide i = c + 1; i < n; ++i)
                for (Wide q = 0; q < kWidth; ++q) w[i * kWidth + q] -= l[i] * v[q];
        }
        std::copy(w, w + k * kWidth, mine);
        gather_below(node, true);
    }
    for (Wide s = nodes.size(); s-- > 0;) {
        const Supernode& node = nodes[s];
        const Wide k = own(node), n = front(node);
        double* w = work.data();
        double* mine = x + static_cast<Wide>(node.begin) * width() * kWidth;
        std::copy(mine, mine + k * kWidth, w);
        gather_below(node, false);
        const double* l = values.data() + node.values_at + (k - 1) * n;
        for (Wide c = k; c-- > 0; l -= n) {
            std::array<double, kWidth> even{}, odd{};  // two sums each, to hide the latency of adding
            Wide i = c + 1;
            for (; i + 1 < n; i += 2)
                for (Wide q = 0; q < kWidth; ++q) {
                    even[q] += l[i] * w[i * kWidth + q];
                    odd[q] += l[i + 1] * w[(i + 1) * kWidth + q];
                }
            if (i < n)
                for (Wide q = 0; q < kWidth; ++q) even[q] += l[i] * w[i * kWidth + q];
            for (Wide q = 0; q < kWidth; ++q) w[c * kWidth + q] = (w[c * kWidth + q] - (even[q] + odd[q])) / l[c];
        }
        std::copy(w, w + k * kWidth, mine);
    }
}

void SparseCholesky::solve(std::span<double> columns) const {
    const State& s = *state_;
    const Wide n = rows(), width = s.width();
    if (n == 0) return;
    const Wide count = columns.size() / n;
    std::vector<double> x(n * 2);
    for (Wide first = 0; first < count; first += 2) {
        const Wide together = std::min<Wide>(2, count - first);
        const auto each = [&](const auto& visit) {
            for (Wide v = 0; v < static_cast<Wide>(s.columns); ++v)
                for (Wide b = 0; b < width; ++b)
                    for (Wide q = 0; q < together; ++q)
                        visit(columns[(first + q) * n + v * width + b],
                              x[(static_cast<Wide>(s.position[v]) * width + b) * together + q]);
        };
        each([](double& given, double& ordered) { ordered = given; });
        if (together == 2)
            s.substitute<2>(x.data());
        else
            s.substitute<1>(x.data());
        each([](double& given, double& ordered) { given = ordered; });
    }
}

std::size_t SparseCholesky::rows() const {
    return static_cast<Wide>(state_->columns) * state_->width();
}

std::size_t SparseCholesky::factor_entries() const {
    return state_->values.size();
}

}  // namespace dgm::bake
