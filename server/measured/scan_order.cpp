// SPDX-License-Identifier: Apache-2.0
#include "server/measured/scan_order.h"

#include <algorithm>
#include <utility>

#include "server/measured/reader.h"

namespace kiln::measured {
namespace {

/// What the last ring of a file can break: rings end at few angles, each of several rings.
constexpr std::size_t kEndsOfARule = 4, kRingsOfAnEnd = 4;

}  // namespace

void ScanOrder::Nesting::add(double at_rest, double moving) {
    if (ring_points > 0 && at_rest != outer) {
        const int step = at_rest > outer ? 1 : -1;
        ordered = ordered && (direction == 0 || step == direction);
        direction = step;
        end_ring();
    }
    outer = at_rest;
    inner = moving;
    ring_min = ring_points == 0 ? inner : std::min(ring_min, inner);
    ring_max = ring_points == 0 ? inner : std::max(ring_max, inner);
    ++ring_points;
}

void ScanOrder::Nesting::end_ring() {
    if (ring_points > 1) {
        inner_min = rings == 0 ? ring_min : std::min(inner_min, ring_min);
        inner_max = rings == 0 ? ring_max : std::max(inner_max, ring_max);
        ++rings;
        if (ring_ends.size() <= kEndsOfARule) ring_ends.insert(inner);
    }
    ring_points = 0;
    ++section_rings;
}

void ScanOrder::Nesting::end_section() {
    end_ring();
    end_min = sections == 0 ? outer : std::min(end_min, outer);
    end_max = sections == 0 ? outer : std::max(end_max, outer);
    section_rings_min = sections == 0 ? section_rings : std::min(section_rings_min, section_rings);
    section_rings = 0;
    ++sections;
}

bool ScanOrder::Nesting::ends_inside_ring(bool at_pole) const {
    const bool rule =
        rings > 0 && ring_ends.size() <= kEndsOfARule && rings >= kRingsOfAnEnd * ring_ends.size();
    return rule && !(at_pole && ring_points == 1) && !ring_ends.contains(inner) &&
           inner >= inner_min && inner <= inner_max;
}

bool ScanOrder::Nesting::ends_before_others() const {
    return sections > 0 && section_rings_min > 1 &&
           (direction > 0 ? outer < end_min : outer > end_max);
}

void ScanOrder::start_section() {
    if (section_points_ > 0)
        for (Nesting& one : nestings_) one.end_section();
    section_points_ = 0;
}

void ScanOrder::add(double first, double second) {
    nestings_[0].add(first, second);
    nestings_[1].add(second, first);
    ++section_points_;
}

ScanOrder::Cut ScanOrder::look() const {
    Cut cut;
    for (std::size_t n = 0; n < nestings_.size(); ++n) {
        const Nesting& scan = nestings_[n];
        if (!scan.ordered || scan.direction == 0) continue;
        const std::string outer(names_[n]), inner(names_[1 - n]);
        const bool inside = scan.ends_inside_ring(n == 0 && scan.outer == 0);
        const bool before = scan.ends_before_others();
        if (!inside && !before) continue;
        std::string what = "the rows end at " + outer + " " + in_words(scan.outer) + ", " + inner +
                           " " + in_words(scan.inner);
        if (inside) {
            what += ", but all " + std::to_string(scan.rings) + " others of one " + outer +
                    " end at " + inner;
            const char* joint = " ";
            for (const double end : scan.ring_ends)
                what += std::exchange(joint, " or ") + in_words(end);
        }
        if (before) {
            what += std::string(inside ? " and" : ",") +
                    " those of the other directions of light (" + std::to_string(scan.sections) +
                    ") at " + outer + " " + in_words(scan.end_min);
            if (scan.end_min != scan.end_max) what += " to " + in_words(scan.end_max);
        }
        // An arm may hide the end of a ring, or all rings of a section from one on: not both.
        (inside && before && scan.ring_points > 1 ? cut.proof : cut.suspicion) = what;
    }
    return cut;
}

void warn_of_cut(const ScanOrder& order, Understood& account) {
    const ScanOrder::Cut cut = order.look();
    const std::string& what = cut.proof.empty() ? cut.suspicion : cut.proof;
    if (!what.empty()) account.warn("the file may have been cut off: " + what);
}

}  // namespace kiln::measured
