// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kiln::measured {

/// A Delaunay triangulation of points in the square [-1, 1]^2 by exact integer arithmetic:
/// coordinates are rounded to multiples of 2^-24, points that round alike are one node. Equal
/// input gives equal triangles.
class Triangulation {
  public:
    static constexpr std::uint32_t kNone = 0xffffffff;

    struct Point {
        double x = 0, y = 0;
    };
    /// Counter-clockwise nodes; across[k] is the triangle beyond the edge opposite to node[k].
    struct Triangle {
        std::array<std::uint32_t, 3> node{kNone, kNone, kNone};
        std::array<std::uint32_t, 3> across{kNone, kNone, kNone};
    };
    struct Place {
        std::uint32_t triangle = kNone;  ///< kNone outside of the points' hull
        std::array<double, 3> weight{};  ///< barycentric, of the triangle's nodes
    };

    /// O(n log n) for points in any order.
    explicit Triangulation(const std::vector<Point>& points);

    /// node_of()[n] is the node of point n.
    const std::vector<std::uint32_t>& node_of() const { return node_of_; }
    std::size_t node_count() const { return nodes_.size() - 3; }
    Point position(std::uint32_t node) const;
    /// Indices of triangles that have none of the three outer helpers as a corner.
    std::vector<std::uint32_t> inner() const;
    const Triangle& triangle(std::uint32_t index) const { return triangles_[index]; }
    double area(std::uint32_t index) const;

    /// The triangle around a place, walking from `hint`, which is updated; kNone starts near by.
    Place locate(Point at, std::uint32_t& hint) const;

  private:
    struct Node {
        std::int64_t x = 0, y = 0;
    };
    static Node rounded(Point at);
    std::int64_t orientation(std::uint32_t a, std::uint32_t b, const Node& c) const;
    bool in_circle(const Triangle& around, const Node& d) const;
    std::uint32_t walk(const Node& at, std::uint32_t from) const;
    void insert(std::uint32_t node);
    void find_starts();
    std::size_t start_cell(const Node& at) const;
    void split(std::uint32_t triangle, std::uint32_t node);
    void split_edge(std::uint32_t triangle, int corner, std::uint32_t node);
    void legalise(std::uint32_t node);
    void link(std::uint32_t triangle, std::uint32_t old_neighbour, std::uint32_t now);
    bool helper(std::uint32_t node) const { return node < 3; }

    std::vector<Node> nodes_;  ///< the first three are the helpers far outside
    std::vector<std::uint32_t> node_of_;
    std::vector<Triangle> triangles_;
    std::vector<std::uint32_t> stack_;
    std::uint32_t last_ = 0;
    std::size_t start_side_ = 1;
    std::vector<std::uint32_t> starts_;  ///< a triangle near each cell of a grid over the square
};

}  // namespace kiln::measured
