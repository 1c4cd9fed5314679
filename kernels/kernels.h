// SPDX-License-Identifier: Apache-2.0
// All kernels, each of which uses the ones before it: the one list of them, with models.h, which
// CMakeLists.txt reads to make the OpenCL text. No guard: C++ includes it once a precision and lane
// width.
// clang-format off
#include "kernels/lane.h"
#include "kernels/lane_math.h"
#include "kernels/lane_arc.h"
#include "kernels/models.h"
#include "kernels/ray.h"
#include "kernels/quadrature.h"
#include "kernels/elevation.h"
#include "kernels/quadrature_lobe.h"
#include "kernels/quadrature_diffuse.h"
#include "kernels/lane_table.h"
#include "kernels/measured.h"
#include "kernels/measured_albedo.h"
// clang-format on
