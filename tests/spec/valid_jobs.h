// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

namespace kiln::test {

/// The job document that the contract was agreed on, with every field at its default.
inline const std::string kContractExample = R"({
  "kind": "lut",
  "quantities": ["split_sum_scale", "split_sum_bias"],
  "resolution": [256, 256],
  "layout": "kiln",
  "sample_count": 1024,
  "sampler": "sobol_owen",
  "importance": "vndf",
  "integrator": "monte_carlo",
  "target_error": null,
  "time_budget_s": null,
  "microfacet": {"distribution": "ggx", "masking": "smith_correlated"},
  "fresnel": {"model": "schlick"},
  "diffuse": {"model": "lambert"},
  "coupling": "none",
  "multiscatter": "none",
  "precision": "float32",
  "device": "auto",
  "seed": 0,
  "output": {"format": "exr", "pixel": "half"}
})";

/// Documents that must be accepted, limits among them.
inline const std::vector<std::string> kValidJobs = {
    R"({"quantities":["specular_albedo"],"resolution":[2,2,3],"fresnel":{"model":"dielectric"},)"
    R"("layout":{"x":{"parameter":"NoV"},"y":{"parameter":"roughness"},)"
    R"("z":{"parameter":"ior","range":[0.5,2]}}})",
    R"({"quantities":["specular_albedo"],"resolution":[2,2,4],"fresnel":{"model":"dielectric"},)"
    R"("layout":{"x":{"parameter":"NoV"},"y":{"parameter":"roughness"},)"
    R"("z":{"parameter":"ior","values":[0.4,1,1,2.5]}}})",
    R"({"quantities":["compensated_albedo"],"resolution":[2,2,3],"multiscatter":"turquin",)"
    R"("fresnel":{"model":"f82_tint","f82":0.5},"layout":{"x":{"parameter":"NoV"},)"
    R"("y":{"parameter":"roughness"},"z":{"parameter":"f0"}}})",
    kContractExample,
    R"({"quantities":["split_sum_scale"]})",
    " \r\n\t{\"quantities\":[\"split_sum_scale\"]}\n",
    R"({"quantities":["average_albedo"],"resolution":[64]})",
    R"({"kind":"slices","measured":{"data":
        "sha256:0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef"}})",
    R"({"kind":"slices","measured":[
        "sha256:0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef"],
        "resolution":[2,2],"output":{"format":"png","pixel":"rgb9e5"}})",
    R"({"kind":"atlas","measured":{"data":[
        "sha256:0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef",
        {"data":"sha256:0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef",
         "name":"Ä \"q\"","extrapolation":{"p":-0}}],
        "theta_in":[-0,45.5,90],"gutter":64,"extrapolation":{"theta_in":"clamp"}},
        "output":{"pixel":"rgb9e5"}})",
    R"({"kind":"lobe_view","measured":{"data":
        "sha256:0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef",
        "theta_in":[89]}})",
    R"({"kind":"sphere_view","resolution":[64,2048],"measured":[
        "sha256:0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef"]})",
    R"({"kind":"companion","resolution":[2],"output":{"format":"png"},"measured":{"data":
        "sha256:0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef",
        "conserve":true}})",
    R"({"kind":"sampling","resolution":[4,1024],"output":{"pixel":"float"},"measured":{"data":
        "sha256:0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef"}})",
    R"({"kind":"furnace"})",
    R"({"kind":"furnace","coupling":"kelemen","importance":"ndf","sample_count":64,"seed":3})",
    R"({"kind":"stability","device":"native"})",
    R"({"kind":"convergence","quantities":["split_sum_scale"],"sample_count":64})",
    R"({"kind":"convergence","quantities":["average_albedo"],"resolution":[16]})",
    R"({"quantities":["average_albedo"],"resolution":[1],"layout":{"x":{"parameter":"alpha"}}})",
    R"({"quantities":["average_albedo"],"output":{"format":"png"}})",
    R"({"quantities":["average_albedo"],"output":{"format":"png","pixel":"uint8"}})",
    R"({"quantities":["average_albedo"],"output":{"pixel":"float"}})",
    R"({"quantities":["average_albedo"],"output":{},"fresnel":{},"diffuse":{},"microfacet":{}})",
    R"({"quantities":["split_sum_scale","split_sum_bias","directional_albedo","average_albedo",
        "multiscatter_albedo"]})",
    R"({"quantities":["split_sum_scale","split_sum_bias","directional_albedo","average_albedo"],
        "output":{"format":"png"}})",
    R"({"quantities":["multiscatter_albedo"],"resolution":[1,4096],"sample_count":1})",
    R"({"quantities":["split_sum_bias"],"resolution":[1,1],"sample_count":1048576})",
    R"({"quantities":["split_sum_bias"],"resolution":[4096,4096],"sample_count":1024})",
    R"({"quantities":["split_sum_bias"],"resolution":[4096,4096],"sample_count":1192})",
    R"({"quantities":["split_sum_bias"],"seed":9007199254740991,
        "importance":"ndf","device":"native"})",
    R"({"quantities":["split_sum_bias"],"seed":-0})",
    R"({"quantities":["split_sum_bias"],"layout":{"x":{"parameter":"roughness","range":[0,5e-324]},
        "y":{"parameter":"NoV","mapping":"square","grid":"node","flip":true,"range":[0.999,1]}}})",
    R"({"quantities":["directional_albedo"],"layout":{"x":{"parameter":"alpha","mapping":"sqrt"},
        "y":{"parameter":"NoV"}},"precision":"float64","sampler":"random"})",
    R"({"quantities":["split_sum_bias"],"target_error":1e-9})",
    R"({"quantities":["split_sum_bias"],"target_error":1,"sample_count":1})",
    R"({"quantities":["split_sum_bias"],"resolution":[4096,4096],"time_budget_s":0.001})",
    R"({"quantities":["split_sum_bias"],"time_budget_s":3600,"target_error":null})",
    R"({"quantities":["directional_albedo"],"s\u0065ed":3,"sampler":"lat\u0074ice"})",
};

}  // namespace kiln::test
