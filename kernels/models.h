// SPDX-License-Identifier: Apache-2.0
// The part of kernels.h that samples models: server/study/wide.cpp reads it in long double, over
// mathematics of its own. words.h is made by cmake/Words.cmake.
// clang-format off
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
// clang-format on
