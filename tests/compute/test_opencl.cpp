// SPDX-License-Identifier: Apache-2.0
// OpenCL as it comes: every CPU class gives the native bits, and every failing call ends on native.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

namespace {

const std::string kBin = KILN_BINARY_DIR "/bin/";

/// A kernel cache of its own, so that no test sees another's programs.
class OpenCl : public ::testing::Test {
  protected:
    void SetUp() override {
        std::string name = KILN_BINARY_DIR "/opencl-XXXXXX";
        ASSERT_NE(mkdtemp(name.data()), nullptr);
        folder_ = name;
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    /// The line that table_digest prints for the job, run under `environment`.
    std::string digest(const std::string& environment, const std::string& job) {
        const std::string command = "env POCL_CACHE_DIR=" + folder_ + " " + environment + " " +
                                    kBin + "table_digest '" + job + "' 2>" + folder_ + "/messages";
        FILE* pipe = popen(command.c_str(), "r");
        std::array<char, 4096> line{};
        const bool read = std::fgets(line.data(), line.size(), pipe) != nullptr;
        pclose(pipe);
        return read ? std::string(line.data()) : std::string();
    }

    std::string folder_;
};

std::string job(const std::string& device, const std::string& rest) {
    return R"({"resolution":[32,16],"device":")" + device + "\"," + rest + "}";
}

/// A case for each path through the kernels.
const std::array<std::string, 4> kJobs = {
    R"("quantities":["split_sum_scale","split_sum_bias","multiscatter_albedo"],"sample_count":256)",
    R"("quantities":["split_sum_bias","multiscatter_albedo"],"importance":"ndf","sampler":"hammersley","microfacet":{"masking":"smith_separable"},"sample_count":256)",
    R"("quantities":["average_albedo"],"sampler":"lattice","sample_count":256)",
    R"("quantities":["split_sum_scale"],"precision":"float64","sampler":"random","sample_count":4096)",
};

bool opencl_is_here(const std::string& line) { return line.find(" opencl ") != std::string::npos; }

TEST_F(OpenCl, EveryCpuClassGivesTheBitsOfNative) {
    if (!opencl_is_here(digest("", job("auto", kJobs[0]))))
        GTEST_SKIP() << "no OpenCL device on this machine";
    for (const std::string& what : kJobs) {
        const std::string native = digest("", job("native", what)).substr(0, 64);
        for (const std::string cpu : {"sse2", "sse41", "avx", "avx2", "avx512"}) {
            const std::string line = digest("POCL_KERNELLIB_NAME=" + cpu, job("opencl", what));
            EXPECT_TRUE(opencl_is_here(line)) << line;
            EXPECT_EQ(line.substr(0, 64), native) << cpu << " on " << what;
        }
    }
}

TEST_F(OpenCl, NoPlatformEndsOnNativeWithTheReason) {
    const std::string line = digest("OCL_ICD_VENDORS=/nonexistent", job("auto", kJobs[0]));
    EXPECT_NE(line.find(" native no OpenCL platform"), std::string::npos) << line;
    EXPECT_EQ(line.substr(0, 64), digest("", job("native", kJobs[0])).substr(0, 64));
}

TEST_F(OpenCl, OpenClByNameFailsWithoutAPlatform) {
    const std::string line = digest("OCL_ICD_VENDORS=/nonexistent", job("opencl", kJobs[0]));
    EXPECT_EQ(line.rfind("error device_unavailable no OpenCL platform", 0), 0u) << line;
}

// What has been said of accuracy on native holds on OpenCL bit for bit: where log-uniform tangents
// have the deficit, and where texels stop by themselves.
TEST_F(OpenCl, StopsWhereNativeStops) {
    const auto adaptive = [](const std::string& device) {
        return R"({"resolution":[40,24],"quantities":["specular_albedo","split_sum_scale",)"
               R"("multiscatter_albedo","average_albedo"],"fresnel":{"model":"dielectric"},)"
               R"("target_error":3e-3,"output":{"pixel":"float"},"device":")" +
               device + "\"}";
    };
    const std::string line = digest("", adaptive("auto"));
    if (!opencl_is_here(line)) GTEST_SKIP() << "no OpenCL device on this machine";
    EXPECT_EQ(line.substr(0, 64), digest("", adaptive("native")).substr(0, 64));
}

class OpenClFault : public OpenCl, public ::testing::WithParamInterface<const char*> {};

TEST_P(OpenClFault, EndsOnNativeWithTheReason) {
    static const bool is_here = opencl_is_here(digest("", job("auto", kJobs[0])));
    static const std::string native = digest("", job("native", kJobs[0])).substr(0, 64);
    if (!is_here) GTEST_SKIP() << "no OpenCL device on this machine";
    const std::string preload =
        std::string("LD_PRELOAD=") + KILN_BINARY_DIR "/tests/compute/libclfault.so ";
    const std::string line = digest(preload + "CLFAULT=" + GetParam(), job("auto", kJobs[0]));
    EXPECT_EQ(line.substr(0, 64), native);
    const std::string function =
        std::string(GetParam()).substr(0, std::string(GetParam()).find(':'));
    EXPECT_NE(line.find(" native "), std::string::npos) << line;
    const std::string reason =
        std::string(GetParam()).find("nan") != std::string::npos ? "not finite" : function;
    EXPECT_NE(line.find(reason), std::string::npos) << line;
}

// The first launch of each of the two programs is its trial, so the third and later calls are the
// job's own.
INSTANTIATE_TEST_SUITE_P(Calls, OpenClFault,
                         ::testing::Values("clGetPlatformIDs:0:-1001", "clGetDeviceIDs:0:-1",
                                           "clBuildProgram:1:-11", "clEnqueueNDRangeKernel:1:-5",
                                           "clEnqueueNDRangeKernel:3:-5",
                                           "clEnqueueReadBuffer:1:-36", "clEnqueueReadBuffer:3:-14",
                                           "clEnqueueReadBuffer:3:nan", "clCreateBuffer:1:-4",
                                           "clCreateBuffer:6:-4"));

}  // namespace
