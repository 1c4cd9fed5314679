// SPDX-License-Identifier: Apache-2.0
// All kernels, each of which uses the ones before it: the one list of them, which CMakeLists.txt
// reads to make the OpenCL text; words.h is made by cmake/Words.cmake. No guard: C++
// includes it once a precision and lane width.
// clang-format off
#include "kernels/lane.h"
#include "kernels/lane_math.h"
#include "kernels/lane_arc.h"
#include "kernels/fresnel.h"
#include "kernels/words.h"
#include "kernels/diffuse.h"
#include "kernels/smith.h"
#include "kernels/ggx.h"
#include "kernels/visible_lights.h"
#include "kernels/horizon_normals.h"
#include "kernels/integrand.h"
#include "kernels/batch.h"
#include "kernels/charlie.h"
#include "kernels/microfacet.h"
#include "kernels/parted_lights.h"
#include "kernels/ggx_lambert.h"
#include "kernels/sample_lobe.h"
#include "kernels/material.h"
#include "kernels/ray.h"
#include "kernels/quadrature.h"
#include "kernels/elevation.h"
#include "kernels/quadrature_lobe.h"
#include "kernels/quadrature_diffuse.h"
#include "kernels/lane_table.h"
#include "kernels/measured.h"
#include "kernels/measured_albedo.h"
// clang-format on
