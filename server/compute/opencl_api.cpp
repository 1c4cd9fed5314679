// SPDX-License-Identifier: Apache-2.0
#include "server/compute/opencl_api.h"

#include <mutex>

#include "server/base/error.h"

namespace kiln::cl {

namespace {

const char* name_of(cl_int status) {
    switch (status) {
        case CL_DEVICE_NOT_FOUND:
            return "CL_DEVICE_NOT_FOUND";
        case CL_DEVICE_NOT_AVAILABLE:
            return "CL_DEVICE_NOT_AVAILABLE";
        case CL_MEM_OBJECT_ALLOCATION_FAILURE:
            return "CL_MEM_OBJECT_ALLOCATION_FAILURE";
        case CL_OUT_OF_RESOURCES:
            return "CL_OUT_OF_RESOURCES";
        case CL_OUT_OF_HOST_MEMORY:
            return "CL_OUT_OF_HOST_MEMORY";
        case CL_BUILD_PROGRAM_FAILURE:
            return "CL_BUILD_PROGRAM_FAILURE";
        case CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST:
            return "CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST";
        case CL_INVALID_VALUE:
            return "CL_INVALID_VALUE";
        case CL_INVALID_DEVICE:
            return "CL_INVALID_DEVICE";
        case CL_INVALID_CONTEXT:
            return "CL_INVALID_CONTEXT";
        case CL_INVALID_COMMAND_QUEUE:
            return "CL_INVALID_COMMAND_QUEUE";
        case CL_INVALID_BUFFER_SIZE:
            return "CL_INVALID_BUFFER_SIZE";
        case CL_INVALID_WORK_GROUP_SIZE:
            return "CL_INVALID_WORK_GROUP_SIZE";
        case -1001:
            return "CL_PLATFORM_NOT_FOUND_KHR";
        default:
            return "see CL/cl.h";
    }
}

std::string text_of(cl_device_id device, cl_device_info what) {
    std::size_t size = 0;
    if (clGetDeviceInfo(device, what, 0, nullptr, &size) != CL_SUCCESS || size == 0) return "";
    std::string text(size, '\0');
    if (clGetDeviceInfo(device, what, size, text.data(), nullptr) != CL_SUCCESS) return "";
    text.resize(text.find('\0') == std::string::npos ? text.size() : text.find('\0'));
    return text;
}

template <typename Value>
Value value_of(cl_device_id device, cl_device_info what) {
    Value value{};
    check(clGetDeviceInfo(device, what, sizeof(value), &value, nullptr), "clGetDeviceInfo");
    return value;
}

Device describe(cl_device_id id) {
    Device device;
    device.id = id;
    device.name = text_of(id, CL_DEVICE_NAME);
    device.vendor = text_of(id, CL_DEVICE_VENDOR);
    device.version = text_of(id, CL_DEVICE_VERSION);
    device.driver = text_of(id, CL_DRIVER_VERSION);
    device.compute_units = value_of<cl_uint>(id, CL_DEVICE_MAX_COMPUTE_UNITS);
    device.float_lanes = value_of<cl_uint>(id, CL_DEVICE_PREFERRED_VECTOR_WIDTH_FLOAT);
    device.cpu = (value_of<cl_device_type>(id, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_CPU) != 0;
    device.doubles = value_of<cl_device_fp_config>(id, CL_DEVICE_DOUBLE_FP_CONFIG) != 0;
    device.correctly_rounded = (value_of<cl_device_fp_config>(id, CL_DEVICE_SINGLE_FP_CONFIG) &
                                CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
    if (!value_of<cl_bool>(id, CL_DEVICE_AVAILABLE) ||
        !value_of<cl_bool>(id, CL_DEVICE_COMPILER_AVAILABLE)) {
        device.usable = false;
        device.detail = "the device or its compiler is not available";
    }
    return device;
}

}  // namespace

void check(cl_int status, const char* call) {
    if (status == CL_SUCCESS) return;
    throw Error("device_failed", std::string(call) + " failed with " + std::to_string(status) +
                                     " (" + name_of(status) + ")");
}

std::vector<Device> enumerate() {
    // PoCL 3.1 crashes when its first calls come from two threads at once.
    static std::mutex first_call;
    const std::lock_guard lock(first_call);
    cl_uint count = 0;
    const cl_int status = clGetPlatformIDs(0, nullptr, &count);
    if (status != CL_SUCCESS || count == 0)
        throw Error("device_unavailable", "no OpenCL platform: clGetPlatformIDs gave " +
                                              std::to_string(status) + " (" + name_of(status) +
                                              "), " + std::to_string(count) + " platforms");
    std::vector<cl_platform_id> platforms(count);
    check(clGetPlatformIDs(count, platforms.data(), nullptr), "clGetPlatformIDs");
    std::vector<Device> devices;
    std::string refusals;
    for (cl_platform_id platform : platforms) {
        cl_uint device_count = 0;
        const cl_int found =
            clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &device_count);
        if (found != CL_SUCCESS || device_count == 0) {
            refusals +=
                ", clGetDeviceIDs gave " + std::to_string(found) + " (" + name_of(found) + ")";
            continue;
        }
        std::vector<cl_device_id> ids(device_count);
        check(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, device_count, ids.data(), nullptr),
              "clGetDeviceIDs");
        for (cl_device_id id : ids) devices.push_back(describe(id));
    }
    if (devices.empty())
        throw Error("device_unavailable",
                    "no OpenCL device on " + std::to_string(count) + " platform(s)" + refusals);
    return devices;
}

}  // namespace kiln::cl
