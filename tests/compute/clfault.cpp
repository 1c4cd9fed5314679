// SPDX-License-Identifier: Apache-2.0
// Makes OpenCL calls fail: LD_PRELOAD=libclfault.so CLFAULT=function:nth:action[,…]
//   nth     1 = the first call, 0 = every call
//   action  a negative OpenCL code, hang, segv, abort, or nan (the first word that is read back
//   becomes NaN)
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

/// The action for this call of `function`, or "" when it may go through.
std::string action_for(const std::string& function, std::atomic<int>& calls) {
    const int call = ++calls;
    const char* text = std::getenv("CLFAULT");
    if (text == nullptr) return "";
    const std::string faults = std::string(text) + ",";
    for (std::size_t at = 0, end; (end = faults.find(',', at)) != std::string::npos; at = end + 1) {
        const std::string fault = faults.substr(at, end - at);
        const std::size_t first = fault.find(':'), second = fault.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos) continue;
        const int nth = std::atoi(fault.c_str() + first + 1);
        if (fault.substr(0, first) == function && (nth == 0 || nth == call))
            return fault.substr(second + 1);
    }
    return "";
}

/// Carries out an action; the code to return, or 0 when the call goes through after all.
cl_int act(const std::string& action) {
    if (action == "hang")
        for (;;) pause();
    if (action == "segv") std::raise(SIGSEGV);
    if (action == "abort") std::abort();
    return action.empty() ? CL_SUCCESS : static_cast<cl_int>(std::atoi(action.c_str()));
}

template <typename Function>
Function real_call(const char* name) {
    return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

#define FORWARD(name, parameters, ...)                                                 \
    extern "C" cl_int name parameters {                                                \
        static std::atomic<int> calls;                                                 \
        if (const cl_int code = act(action_for(#name, calls)); code != 0) return code; \
        return real_call<decltype(&name)>(#name)(__VA_ARGS__);                         \
    }

FORWARD(clGetPlatformIDs, (cl_uint n, cl_platform_id* ids, cl_uint* count), n, ids, count)
FORWARD(clGetDeviceIDs,
        (cl_platform_id p, cl_device_type t, cl_uint n, cl_device_id* ids, cl_uint* count), p, t, n,
        ids, count)
FORWARD(clBuildProgram,
        (cl_program p, cl_uint n, const cl_device_id* d, const char* o,
         void(CL_CALLBACK* f)(cl_program, void*), void* u),
        p, n, d, o, f, u)
FORWARD(clEnqueueNDRangeKernel,
        (cl_command_queue q, cl_kernel k, cl_uint d, const size_t* a, const size_t* b,
         const size_t* c, cl_uint n, const cl_event* w, cl_event* e),
        q, k, d, a, b, c, n, w, e)
FORWARD(clSetKernelArg, (cl_kernel k, cl_uint i, size_t s, const void* v), k, i, s, v)

extern "C" cl_int clEnqueueReadBuffer(cl_command_queue q, cl_mem m, cl_bool b, size_t o, size_t s,
                                      void* p, cl_uint n, const cl_event* w, cl_event* e) {
    static std::atomic<int> calls;
    const std::string action = action_for("clEnqueueReadBuffer", calls);
    if (action != "nan")
        if (const cl_int code = act(action); code != 0) return code;
    const cl_int status =
        real_call<decltype(&clEnqueueReadBuffer)>("clEnqueueReadBuffer")(q, m, b, o, s, p, n, w, e);
    const std::uint32_t nan = 0x7FC00000;
    if (action == "nan") std::memcpy(p, &nan, sizeof(nan));
    return status;
}

extern "C" cl_mem clCreateBuffer(cl_context c, cl_mem_flags f, size_t s, void* p, cl_int* status) {
    static std::atomic<int> calls;
    if (const cl_int code = act(action_for("clCreateBuffer", calls)); code != 0) {
        if (status != nullptr) *status = code;
        return nullptr;
    }
    return real_call<decltype(&clCreateBuffer)>("clCreateBuffer")(c, f, s, p, status);
}
