// SPDX-License-Identifier: Apache-2.0
#pragma once
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <string>
#include <utility>
#include <vector>

namespace kiln::cl {

/// Throws Error("device_failed") naming the call and the code's name unless `status` is CL_SUCCESS.
void check(cl_int status, const char* call);

/// An OpenCL object, released when it goes.
template <typename Object, cl_int (*release)(Object)>
class Handle {
  public:
    Handle() = default;
    explicit Handle(Object object) : object_(object) {}
    Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
    Handle& operator=(Handle&& other) noexcept {
        std::swap(object_, other.object_);
        return *this;
    }
    ~Handle() {
        if (object_) release(object_);
    }
    Object get() const { return object_; }
    const Object* address() const { return &object_; }
    explicit operator bool() const { return object_ != nullptr; }

  private:
    Object object_ = nullptr;
};

using Context = Handle<cl_context, clReleaseContext>;
using Queue = Handle<cl_command_queue, clReleaseCommandQueue>;
using Program = Handle<cl_program, clReleaseProgram>;
using Kernel = Handle<cl_kernel, clReleaseKernel>;
using Buffer = Handle<cl_mem, clReleaseMemObject>;

struct Device {
    cl_device_id id = nullptr;
    std::string name, vendor, version, driver;
    unsigned compute_units = 0;
    unsigned float_lanes = 1;  ///< of a vector that suits the device
    bool cpu = false;
    bool doubles = false;
    bool correctly_rounded = false;  ///< float ÷ and √
    bool usable = true;
    std::string detail;
};

/// Every device of every platform; a platform that fails to answer is passed over. Throws
/// Error("device_unavailable") with the reason when there is none.
std::vector<Device> enumerate();

}  // namespace kiln::cl
