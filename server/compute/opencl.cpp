// SPDX-License-Identifier: Apache-2.0
#include "server/compute/opencl.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <map>
#include <mutex>
#include <type_traits>

#include "server/base/error.h"
#include "server/compute/kernel_digest.h"
#include "server/compute/measured_trial.h"
#include "server/compute/opencl_api.h"
#include "server/compute/quadrature.h"

namespace kiln {

namespace {

/// A specialisation's kernel, with what the trial launch found. It keeps its program alive.
struct Built {
    cl::Kernel kernel;
    std::string numerics;
};

/// The device's memory for sums: kept from one launch to the next, since fresh pages cost more than
/// what is written there. Never the host's own memory: after a call that failed, nobody knows what
/// still runs and writes.
struct Room {
    cl::Buffer buffer;
    std::size_t bytes = 0;
};

/// Options come from closed sets alone: no text of a user can reach the compiler.
using Definitions = std::vector<std::pair<const char*, int>>;

std::string build_options(const Definitions& definitions, Precision precision, std::size_t lanes,
                          const cl::Device& device) {
    // -w: PoCL's compiler counts its warnings on the terminal, one for each function of vectors
    // that are wider than the registers.
    std::string options = "-cl-std=CL1.2 -w";
    if (device.correctly_rounded) options += " -cl-fp32-correctly-rounded-divide-sqrt";
    const auto define = [&](const char* name, int value) {
        options += std::string(" -D") + name + "=" + std::to_string(value);
    };
    define("KILN_DOUBLE", precision == Precision::float64 ? 1 : 0);
    define("KILN_LANES", static_cast<int>(lanes));
    if (!device.cpu) define("KILN_GPU", 1);
    for (const auto& [name, value] : definitions) define(name, value);
    return options;
}

/// Registers of a real on CPUs. Of two, what all lanes share is read once for both and each fills
/// the other's waits: .5 to .95 of the time (AVX2). Lobes of Beckmann and Charlie run out of
/// registers and took 1.2 to 1.8 times as long, measured ones were not tried.
std::size_t registers(const Specialisation& what) {
    const bool spills = what.material.distribution != static_cast<int>(Distribution::ggx);
    return spills || what.material.general == kAnyMaterial ? 1 : 2;
}
std::size_t registers(const QuadratureKind&) { return 2; }
std::size_t registers(const MeasuredKind&) { return 1; }

const char* entry_of(const Specialisation&) { return "tables"; }
Definitions definitions_of(const Specialisation& what) {
    const KernelMaterial& material = what.material;
    if (material.general == kAnyMaterial) return {{"KILN_GENERAL", 1}, {"KILN_ANY_MATERIAL", 1}};
    return {{"KILN_DISTRIBUTION", material.distribution}, {"KILN_MASKING", material.masking},
            {"KILN_IMPORTANCE", material.importance},     {"KILN_TERMS", material.terms},
            {"KILN_AVERAGED", material.averaged},         {"KILN_FRESNEL", material.fresnel},
            {"KILN_DIFFUSE", material.diffuse},           {"KILN_GENERAL", material.general}};
}

const char* entry_of(const QuadratureKind&) { return "quadrature_table"; }
Definitions definitions_of(const QuadratureKind& what) {
    const auto of = [](const auto& rule) -> Definitions {
        using What = std::decay_t<decltype(rule)>;
        if constexpr (std::is_same_v<What, SmithRule>)
            return {{"KILN_QUADRATURE", 1},
                    {"KILN_MASKING", static_cast<int>(rule.masking)},
                    {"KILN_FRESNEL", rule.fresnel}};
        else if constexpr (std::is_same_v<What, DiffuseRule>)
            return {{"KILN_QUADRATURE", 2},
                    {"KILN_DIFFUSE", rule.diffuse},
                    {"KILN_FRESNEL", rule.fresnel}};
        else
            return {{"KILN_QUADRATURE", 3},
                    {"KILN_DISTRIBUTION", rule.distribution},
                    {"KILN_MASKING", rule.masking},
                    {"KILN_FRESNEL", rule.fresnel},
                    {"KILN_TOTAL", rule.total_reflection ? 1 : 0}};
    };
    return std::visit(of, what.rule);
}

const char* entry_of(const MeasuredKind&) { return "measured_table"; }
Definitions definitions_of(const MeasuredKind& what) {
    return {{"KILN_MEASURED", static_cast<int>(what.operation)}};
}

/// Texels of the trial launches: an even grid of NoV and roughness.
template <typename Scalar>
std::vector<Scalar> trial_texels(std::size_t side) {
    const std::size_t stride = side * side;
    std::vector<Scalar> texels(2 * stride);
    const auto cells = static_cast<double>(side);
    for (std::size_t i = 0; i < stride; ++i) {
        texels[i] = static_cast<Scalar>((static_cast<double>(i % side) + 0.5) / cells);
        const double roughness = (static_cast<double>(i / side) + 0.5) / cells;
        texels[stride + i] = static_cast<Scalar>(roughness * roughness);
    }
    return texels;
}

}  // namespace

struct OpenClBackend::State {
    Backend& oracle;
    cl::Device device;
    cl::Context context;
    cl::Queue queue;
    mutable std::mutex mutex;  // of `kernels`
    std::map<KernelKind, Built> kernels;
    std::mutex building;
    std::map<std::string, cl::Program> programs;  // by their options
    Room sums;                                    // of run()

    explicit State(Backend& native) : oracle(native) {
        auto devices = cl::enumerate();
        std::erase_if(devices, [](const cl::Device& d) { return !d.usable; });
        if (devices.empty()) throw Error("device_unavailable", "no OpenCL device is usable");
        device = *std::ranges::min_element(devices, {}, &cl::Device::cpu);
        cl_int status = CL_SUCCESS;
        context = cl::Context(clCreateContext(nullptr, 1, &device.id, nullptr, nullptr, &status));
        cl::check(status, "clCreateContext");
        queue = cl::Queue(clCreateCommandQueue(context.get(), device.id, 0, &status));
        cl::check(status, "clCreateCommandQueue");
    }

    template <typename What>
    std::size_t lanes(const What& what) const {
        if (!device.cpu) return 1;
        const std::size_t floats = device.float_lanes <= 4 ? 4 : device.float_lanes <= 8 ? 8 : 16;
        const std::size_t wide = std::min(floats * registers(what), kLanesMax);
        return what.precision == Precision::float64 ? wide / 2 : wide;
    }

    const Built& find(const KernelKind& what) const {
        const std::lock_guard lock(mutex);
        const auto at = kernels.find(what);
        if (at == kernels.end()) throw Error("device_failed", "the OpenCL program is not built");
        return at->second;
    }

    /// What differs in arguments alone shares a program.
    const cl::Program& compile(const std::string& options) {
        cl::Program& program = programs[options];
        if (program) return program;
        const std::string_view text = kernel_text();
        const char* source = text.data();
        const std::size_t length = text.size();
        cl_int status = CL_SUCCESS;
        cl::Program made(clCreateProgramWithSource(context.get(), 1, &source, &length, &status));
        cl::check(status, "clCreateProgramWithSource");
        cl::check(clBuildProgram(made.get(), 1, &device.id, options.c_str(), nullptr, nullptr),
                  "clBuildProgram");
        return program = std::move(made);
    }

    cl::Buffer buffer(cl_mem_flags flags, std::size_t bytes, const void* data) const {
        cl_int status = CL_SUCCESS;
        cl::Buffer made(
            clCreateBuffer(context.get(), flags, bytes, const_cast<void*>(data), &status));
        cl::check(status, "clCreateBuffer");
        return made;
    }

    template <typename T>
    cl::Buffer copy(std::span<const T> data) const {
        return buffer(CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, data.size_bytes(), data.data());
    }

    /// Sets the arguments in turn, runs one work-item a lane group, and reads `out` back.
    template <typename Scalar>
    void enqueue(const Built& program, std::size_t work_items, std::span<Scalar> out, Room& room,
                 std::initializer_list<std::pair<std::size_t, const void*>> arguments) const {
        cl_uint index = 0;
        const auto argument = [&](std::size_t size, const void* value) {
            cl::check(clSetKernelArg(program.kernel.get(), index++, size, value), "clSetKernelArg");
        };
        for (const auto& [size, value] : arguments) argument(size, value);
        if (room.bytes < out.size_bytes())
            room = {buffer(CL_MEM_WRITE_ONLY, out.size_bytes(), nullptr), out.size_bytes()};
        argument(sizeof(cl_mem), room.buffer.address());
        const std::size_t local = 1;  // CPUs: a work-item already fills the vector unit
        cl::check(clEnqueueNDRangeKernel(queue.get(), program.kernel.get(), 1, nullptr, &work_items,
                                         device.cpu ? &local : nullptr, 0, nullptr, nullptr),
                  "clEnqueueNDRangeKernel");
        // Waits for the kernel as well. To wait for each of the two costs a table of many small
        // launches, as quadrature's to a loose bound, an eighth of its time.
        cl::check(clEnqueueReadBuffer(queue.get(), room.buffer.get(), CL_TRUE, 0, out.size_bytes(),
                                      out.data(), 0, nullptr, nullptr),
                  "clEnqueueReadBuffer");
    }

    template <typename Scalar>
    void launch(const Built& program, const Launch<Scalar>& launch, Room& room) const {
        const cl::Buffer texels = copy(launch.texels), points = copy(launch.points),
                         parameters = copy(launch.parameters), batches = copy(launch.batches);
        const auto batch_count = static_cast<cl_uint>(launch.batches.size());
        const auto stride = static_cast<cl_uint>(launch.texel_stride);
        // Material of kernels/material.h has the same members, but for the last.
        const KernelMaterial& material = launch.what.material;
        constexpr std::size_t material_bytes = offsetof(KernelMaterial, general);
        enqueue(program, launch.texel_stride / lanes(launch.what), launch.sums, room,
                {{sizeof(cl_mem), texels.address()},
                 {sizeof(cl_mem), points.address()},
                 {sizeof(cl_mem), parameters.address()},
                 {sizeof(cl_mem), batches.address()},
                 {sizeof(batch_count), &batch_count},
                 {sizeof(stride), &stride},
                 {material_bytes, &material}});
    }

    template <typename Scalar>
    void launch(const Built& program, const QuadratureLaunch<Scalar>& launch, Room& room) const {
        const cl::Buffer texels = copy(launch.texels), nodes = copy(launch.nodes),
                         parameters = copy(launch.parameters);
        const cl_uint order = launch.order.elevation, azimuths = launch.order.azimuth;
        const auto stride = static_cast<cl_uint>(launch.texel_stride);
        enqueue(program, launch.texel_stride / lanes(launch.what), launch.values, room,
                {{sizeof(cl_mem), texels.address()},
                 {sizeof(cl_mem), nodes.address()},
                 {sizeof(cl_mem), parameters.address()},
                 {sizeof(order), &order},
                 {sizeof(azimuths), &azimuths},
                 {sizeof(stride), &stride}});
    }

    template <typename Scalar>
    void launch(const Built& program, const MeasuredLaunch<Scalar>& launch, Room& room) const {
        const Scalar none[4] = {};  // a buffer has at least a byte
        const BatchRange no_batch[1] = {};
        const auto points = launch.points.empty() ? std::span<const Scalar>(none) : launch.points;
        const auto ranges =
            launch.batches.empty() ? std::span<const BatchRange>(no_batch) : launch.batches;
        const cl::Buffer nodes = copy(launch.nodes), curves = copy(launch.curves),
                         places = copy(launch.places), rule = copy(points), batches = copy(ranges);
        const auto batch_count = static_cast<cl_uint>(launch.batches.size());
        const auto stride = static_cast<cl_uint>(launch.stride);
        const MeasuredShape& shape = launch.shape;
        static_assert(sizeof(unsigned) == sizeof(cl_uint));
        enqueue(program, launch.stride / lanes(launch.what), launch.values, room,
                {{sizeof(cl_mem), nodes.address()},
                 {sizeof(cl_mem), curves.address()},
                 {sizeof(cl_uint), &shape.lobes},
                 {sizeof(cl_uint), &shape.rings},
                 {sizeof(cl_uint), &shape.spokes},
                 {sizeof(cl_uint), &shape.reciprocal_beyond},
                 {sizeof(cl_uint), &shape.symmetric},
                 {sizeof(cl_mem), places.address()},
                 {sizeof(cl_mem), rule.address()},
                 {sizeof(cl_mem), batches.address()},
                 {sizeof(batch_count), &batch_count},
                 {sizeof(stride), &stride}});
    }

    /// A launch small enough to be free and wide enough to show a contraction or a rounding of its
    /// own: a device whose sums equal the oracle's bits belongs to its numerics class.
    template <typename Scalar>
    bool equals_oracle(const Built& program, const Specialisation& what) const {
        constexpr std::size_t kStride = 64, kPoints = 64;
        const std::vector<Scalar> texels = trial_texels<Scalar>(8);
        const auto parameters = any_parameters<Scalar>();
        const PointSet set =
            make_points(Sampler::sobol_owen, point_kind(what.material), 0, kPoints);
        const std::vector<Scalar> points(set.values.begin(), set.values.end());
        const std::size_t planes = static_cast<std::size_t>(
            __builtin_popcount(static_cast<unsigned>(what.material.terms)));
        std::vector<Scalar> mine(set.batches.size() * planes * kStride), wanted(mine.size());
        Room room;
        Launch<Scalar> trial{what, kStride, texels, points, parameters, set.batches, mine};
        launch(program, trial, room);
        trial.sums = wanted;
        oracle.run(trial);
        return std::memcmp(mine.data(), wanted.data(), mine.size() * sizeof(Scalar)) == 0;
    }

    template <typename Scalar>
    bool equals_oracle(const Built& program, const QuadratureKind& what) const {
        constexpr std::size_t kStride = 64;
        constexpr QuadratureOrder kOrder{14, 14};
        const std::vector<Scalar> texels = trial_texels<Scalar>(8);
        const std::vector<double> rule = quadrature_nodes(what, kOrder);
        const std::vector<Scalar> nodes(rule.begin(), rule.end());
        std::vector<Scalar> mine(quadrature_planes(what) * kStride), wanted(mine.size());
        const QuadratureParameters numbers = any_quadrature_parameters(what);
        const std::vector<Scalar> parameters(numbers.begin(), numbers.end());
        Room room;
        QuadratureLaunch<Scalar> trial{what, kStride, texels, nodes, parameters, kOrder, mine};
        launch(program, trial, room);
        trial.values = wanted;
        oracle.run(trial);
        return std::memcmp(mine.data(), wanted.data(), mine.size() * sizeof(Scalar)) == 0;
    }

    template <typename Scalar>
    bool equals_oracle(const Built& program, const MeasuredKind& what) const {
        MeasuredTrial<Scalar> trial(what.operation);
        std::vector<Scalar> wanted(trial.values.size());
        Room room;
        MeasuredLaunch<Scalar> mine = trial.launch(what);
        launch(program, mine, room);
        mine.values = wanted;
        oracle.run(mine);
        return std::memcmp(trial.values.data(), wanted.data(), wanted.size() * sizeof(Scalar)) == 0;
    }

    template <typename What>
    Built build(const What& what) {
        if (what.precision == Precision::float64 && !device.doubles)
            throw Error("device_unavailable", device.name + " has no double precision");
        const std::lock_guard lock(building);
        const std::string options =
            build_options(definitions_of(what), what.precision, lanes(what), device);
        cl_int status = CL_SUCCESS;
        Built made{cl::Kernel(clCreateKernel(compile(options).get(), entry_of(what), &status)), {}};
        cl::check(status, "clCreateKernel");
        const bool strict = what.precision == Precision::float64 ? equals_oracle<double>(made, what)
                                                                 : equals_oracle<float>(made, what);
        made.numerics = strict ? kStrictNumerics : "opencl/" + device.name + "/" + device.driver;
        return made;
    }
};

OpenClBackend::OpenClBackend(Backend& oracle) : state_(std::make_unique<State>(oracle)) {}
OpenClBackend::~OpenClBackend() = default;

void OpenClBackend::build(const KernelKind& what) {
    if (built(what)) return;
    Built made = std::visit([this](const auto& kind) { return state_->build(kind); }, what);
    const std::lock_guard lock(state_->mutex);
    state_->kernels.emplace(what, std::move(made));
}

bool OpenClBackend::built(const KernelKind& what) const {
    const std::lock_guard lock(state_->mutex);
    return state_->kernels.contains(what);
}

// A launch costs a CPU's driver some 0.2 ms more than native; a GPU needs more work-items than a
// CPU has lanes, and is faster by more than that.
std::size_t OpenClBackend::block_places() const {
    return state_->device.cpu ? 4 * state_->oracle.block_places() : 65536;
}

void OpenClBackend::run(const Launch<float>& launch) {
    state_->launch(state_->find(launch.what), launch, state_->sums);
}
void OpenClBackend::run(const Launch<double>& launch) {
    state_->launch(state_->find(launch.what), launch, state_->sums);
}
void OpenClBackend::run(const QuadratureLaunch<float>& launch) {
    state_->launch(state_->find(launch.what), launch, state_->sums);
}
void OpenClBackend::run(const QuadratureLaunch<double>& launch) {
    state_->launch(state_->find(launch.what), launch, state_->sums);
}
void OpenClBackend::run(const MeasuredLaunch<float>& launch) {
    state_->launch(state_->find(launch.what), launch, state_->sums);
}
void OpenClBackend::run(const MeasuredLaunch<double>& launch) {
    state_->launch(state_->find(launch.what), launch, state_->sums);
}

std::string OpenClBackend::name() const { return state_->device.name; }
std::string OpenClBackend::numerics(const KernelKind& what) const {
    return state_->find(what).numerics;
}

std::vector<DeviceInfo> opencl_devices() {
    std::vector<DeviceInfo> infos;
    for (const cl::Device& device : cl::enumerate()) {
        DeviceInfo info;
        info.backend = "opencl";
        info.name = device.name;
        info.vendor = device.vendor;
        info.version = device.version;
        info.numerics =
            device.correctly_rounded ? "decided by a trial launch, per program" : "of its own";
        info.compute_units = device.compute_units;
        info.usable = device.usable;
        info.detail = device.detail;
        infos.push_back(std::move(info));
    }
    return infos;
}

}  // namespace kiln
