// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <set>
#include <string>
#include <string_view>

namespace kiln::measured {

struct Understood;

/// The order in which an instrument wrote the views of each direction of light: ring after ring,
/// one angle at rest while the other goes on. It shows where a file was cut off whose format has
/// neither counts nor a closing mark.
class ScanOrder {
  public:
    /// `names` of the two angles, for messages.
    explicit ScanOrder(std::array<std::string_view, 2> names) : names_(names) {}
    void start_section();  ///< another direction of light
    void add(double first, double second);
    bool section_is_empty() const { return section_points_ == 0; }

    struct Cut {
        /// What the rest of the file proves wrong about its end; else what is odd about it.
        std::string proof, suspicion;
    };
    Cut look() const;

  private:
    /// One of the two angles at rest.
    struct Nesting {
        bool ordered = true;
        int direction = 0;  ///< of the outer angle
        double outer = 0, inner = 0;
        std::size_t ring_points = 0, section_rings = 0;
        std::size_t rings = 0;       ///< ended ones of several points
        std::set<double> ring_ends;  ///< inner angles, up to one more than a rule has
        double ring_min = 0, ring_max = 0, inner_min = 0, inner_max = 0;  ///< of this and of all
        std::size_t sections = 0;                                         ///< ended ones
        std::size_t section_rings_min = 0;
        double end_min = 0, end_max = 0;  ///< outer angles where sections end

        void add(double at_rest, double moving);
        void end_ring();
        void end_section();
        /// Whether the last ring stops where others went on; at_pole: it may have one point.
        bool ends_inside_ring(bool at_pole) const;
        bool ends_before_others() const;
    };
    std::array<std::string_view, 2> names_;
    std::array<Nesting, 2> nestings_;
    std::size_t section_points_ = 0;
};

/// Proof and suspicion alike, for a format whose rows may come in any order.
void warn_of_cut(const ScanOrder& order, Understood& account);

}  // namespace kiln::measured
