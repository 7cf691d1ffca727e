// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/solve/sparse_lu.cpp
//
// [Gilbert, Peierls 1988] Gilbert, Peierls. Sparse partial pivoting in time proportional to arithmetic operations.
// SIAM J. Sci. Stat. Comput. 9(5).
// [Davis, Palamadai 2010] Davis, Palamadai Natarajan. Algorithm 907: KLU, a direct sparse solver for circuit simulation
// problems. ACM TOMS 37(3): the threshold of the diagonal pivot.
#include "geometry/solve/sparse_lu.h"

#include <Eigen/OrderingMethods>
#include <cmath>
#include <vector>

namespace dgm::bake {
namespace {
using SparseMatrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;

constexpr double kDiagonalAtLeast = 0.001;  // of the largest candidate, as in KLU; callers refine their solutions

/// Columns of a triangular factor, one after the other.
struct Columns {
    std::vector<std::size_t> start{0};
    std::vector<int> index;
    std::vector<double> value;

    void add(int i, double v) {
        index.push_back(i);
        value.push_back(v);
    }
    void end_column() { start.push_back(index.size()); }
};
}  // namespace

struct SparseLu::State {
    Columns L;                      // below the unit diagonal; rows as in A
    Columns U;                      // above the diagonal; rows by position
    std::vector<double> diagonal;   // of U
    std::vector<int> column_at;     // Q: position -> column of A
    std::vector<int> row_at;        // P: position -> row of A
    std::vector<int> position;      // row of A -> position, -1 while it is no pivot
    std::vector<double> x;          // the column in work, by rows of A; zero outside of `reached`
    std::vector<int> mark;          // row of A -> the last column that reached it
    std::vector<int> reached;       // rows with an entry, each after all rows that depend on it
    std::vector<int> stack;         // path of the depth-first search
    std::vector<std::size_t> next;  // where the search goes on, for each row of the path

    void reset(std::size_t n) {
        L = {};
        U = {};
        diagonal.clear();
        row_at.clear();
        position.assign(n, -1);
        x.assign(n, 0);
        mark.assign(n, -1);
        stack.resize(n);
        next.resize(n);
    }

    /// Adds `root` and all rows that elimination fills from it to `reached`, dependent rows first.
    void search(int root, int k) {
        std::size_t depth = 0;
        const auto enter = [&](int row) {
            mark[static_cast<std::size_t>(row)] = k;
            const int p = position[static_cast<std::size_t>(row)];
            stack[depth] = row;
            next[depth] = p < 0 ? 0 : L.start[static_cast<std::size_t>(p)];
            ++depth;
        };
        enter(root);
        while (depth > 0) {
            const int row = stack[depth - 1];
            const int p = position[static_cast<std::size_t>(row)];
            const std::size_t end = p < 0 ? 0 : L.start[static_cast<std::size_t>(p) + 1];
            std::size_t& at = next[depth - 1];
            while (at < end && mark[static_cast<std::size_t>(L.index[at])] == k) ++at;
            if (at < end) {
                enter(L.index[at++]);
            } else {
                reached.push_back(row);
                --depth;
            }
        }
    }

    /// x = L^-1 A(:, column), with the part of L that is there.
    void eliminate(const SparseMatrix& A, int column, int k) {
        reached.clear();
        for (SparseMatrix::InnerIterator it(A, column); it; ++it) {
            if (mark[static_cast<std::size_t>(it.row())] != k) search(static_cast<int>(it.row()), k);
            x[static_cast<std::size_t>(it.row())] = it.value();
        }
        for (std::size_t r = reached.size(); r-- > 0;) {
            const auto row = static_cast<std::size_t>(reached[r]);
            if (position[row] < 0) continue;
            const auto p = static_cast<std::size_t>(position[row]);
            const double factor = x[row];
            for (std::size_t at = L.start[p]; at < L.start[p + 1]; ++at)
                x[static_cast<std::size_t>(L.index[at])] -= L.value[at] * factor;
        }
    }

    /// The row of the pivot of `column`; -1 if there is none.
    [[nodiscard]] int choose_pivot(int column) const {
        int best = -1;
        double largest = 0;
        for (const int row : reached) {
            const auto r = static_cast<std::size_t>(row);
            if (!std::isfinite(x[r])) return -1;
            if (position[r] < 0 && std::abs(x[r]) > largest) {
                largest = std::abs(x[r]);
                best = row;
            }
        }
        const auto d = static_cast<std::size_t>(column);
        const bool diagonal_will_do = best >= 0 && position[d] < 0 && std::abs(x[d]) >= kDiagonalAtLeast * largest;
        return diagonal_will_do ? column : best;
    }

    /// Column k of L and U from x, which is zero again afterwards.
    void store(int pivot, int k) {
        const double divisor = x[static_cast<std::size_t>(pivot)];
        for (const int row : reached) {
            const auto r = static_cast<std::size_t>(row);
            if (position[r] >= 0) {
                U.add(position[r], x[r]);
            } else if (row != pivot) {
                L.add(row, x[r] / divisor);
            }
            x[r] = 0;
        }
        L.end_column();
        U.end_column();
        diagonal.push_back(divisor);
        row_at.push_back(pivot);
        position[static_cast<std::size_t>(pivot)] = k;
    }
};

SparseLu::SparseLu() : state_(std::make_unique<State>()) {}
SparseLu::~SparseLu() = default;
SparseLu::SparseLu(SparseLu&&) noexcept = default;
SparseLu& SparseLu::operator=(SparseLu&&) noexcept = default;

bool SparseLu::factorize(const SparseMatrix& A) {
    State& s = *state_;
    const auto n = static_cast<std::size_t>(A.rows());
    s.reset(n);
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    Eigen::AMDOrdering<int>{}(A, order);
    s.column_at.assign(order.indices().data(), order.indices().data() + n);
    for (std::size_t k = 0; k < n; ++k) {
        const int column = s.column_at[k];
        s.eliminate(A, column, static_cast<int>(k));
        const int pivot = s.choose_pivot(column);
        if (pivot < 0) return false;
        s.store(pivot, static_cast<int>(k));
    }
    return true;
}

Vector SparseLu::solve(const Vector& b) const {
    const State& s = *state_;
    const std::size_t n = s.row_at.size();
    std::vector<double> by_row(b.data(), b.data() + n), z(n);
    for (std::size_t k = 0; k < n; ++k) {
        z[k] = by_row[static_cast<std::size_t>(s.row_at[k])];
        for (std::size_t at = s.L.start[k]; at < s.L.start[k + 1]; ++at)
            by_row[static_cast<std::size_t>(s.L.index[at])] -= s.L.value[at] * z[k];
    }
    Vector out(static_cast<Eigen::Index>(n));
    for (std::size_t k = n; k-- > 0;) {
        z[k] /= s.diagonal[k];
        for (std::size_t at = s.U.start[k]; at < s.U.start[k + 1]; ++at)
            z[static_cast<std::size_t>(s.U.index[at])] -= s.U.value[at] * z[k];
        out[s.column_at[k]] = z[k];
    }
    return out;
}

}  // namespace dgm::bake
