// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/measured/reader.h"

/// What each format's file gives to the table in readers.cpp; nobody else includes this.
namespace kiln::measured {

bool is_merl(std::string_view bytes);
Reading read_merl(std::string_view bytes, const ReadOptions& options);
/// Sizes of the table that a file may have; the format's, whose files have 35 MB, unless a test
/// wants them smaller.
struct MerlSizes {
    std::size_t theta_h = 90, theta_d = 90, half_turn = 180;
};
Reading read_merl_of(std::string_view bytes, const MerlSizes& sizes);
bool is_rgl(std::string_view bytes);
Reading read_rgl(std::string_view bytes, const ReadOptions& options);
bool is_zemax(std::string_view bytes);
Reading read_zemax(std::string_view bytes, const ReadOptions& options);
bool is_lighttools(std::string_view bytes);
Reading read_lighttools(std::string_view bytes, const ReadOptions& options);
bool is_fred(std::string_view bytes);
Reading read_fred(std::string_view bytes, const ReadOptions& options);
bool is_astm(std::string_view bytes);
Reading read_astm(std::string_view bytes, const ReadOptions& options);
bool is_lbnl_xml(std::string_view bytes);
Reading read_lbnl_xml(std::string_view bytes, const ReadOptions& options);
bool is_bird_json(std::string_view bytes);
Reading read_bird_json(std::string_view bytes, const ReadOptions& options);
bool is_csv(std::string_view bytes);
Reading read_csv(std::string_view bytes, const ReadOptions& options);

/// Throws Error("unreadable_measurement") with the reason for a file of a kind that is known and
/// not read.
void refuse_known(std::string_view bytes);

}  // namespace kiln::measured
