#include "device/opencl/session.hpp"
#include "core/own_group.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "clbvh/core/error.hpp"
#include "device/opencl/device_info.hpp"
#include "device/opencl/hand_over_check.hpp"
#include "device/opencl/kernel_dump.hpp"
#include "device/opencl/kernel_source.hpp"
#include "device/opencl/lane_shape_check.hpp"
#include "device/opencl/language.hpp"
#include "device/opencl/user_folder.hpp"

namespace clbvh::device {
namespace {

/// What CLBVH_HAND_OVER says; automatic where it is unset.
HandOver hand_over_variable() {
    const std::string_view value = environment("CLBVH_HAND_OVER");
    if (value.empty()) return HandOver::automatic;
    for (const HandOver each : {HandOver::automatic, HandOver::within_launch, HandOver::between_launches}) {
        if (value == to_string(each)) return each;
    }
    throw Error(ErrorCode::invalid_input,
                "CLBVH_HAND_OVER is '" + std::string(value) + "'; use auto, within or between");
}

std::string key_of(std::string_view file, const std::string& options) {
    return std::string(file) + " " + options;
}

std::string names_of(const std::vector<std::string_view>& files) {
    std::string names;
    for (const std::string_view file : files)
        names += (names.empty() ? "" : ", ") + std::string(kernel_path(file));
    return names;
}

}  // namespace

Session::Session(const DeviceInfo& info, const ContextOptions& options) : info_(info) {
    with_opencl_errors(info.name, [&] {
        device_ = cl::Device(static_cast<cl_device_id>(info.id), true);
        context_ = cl::Context(device_);
        queue_ = cl::CommandQueue(context_, device_, CL_QUEUE_PROFILING_ENABLE);
    });
    load_settings(options);
}

Session::Session(cl_command_queue queue, const ContextOptions& options) {
    with_opencl_errors("adopting a queue", [&] {
        queue_ = cl::CommandQueue(queue, true);
        context_ = queue_.getInfo<CL_QUEUE_CONTEXT>();
        device_ = queue_.getInfo<CL_QUEUE_DEVICE>();
        const cl_command_queue_properties properties = queue_.getInfo<CL_QUEUE_PROPERTIES>();
        profiles_ = (properties & CL_QUEUE_PROFILING_ENABLE) != 0;
        info_ = describe_device(device_);
        for (const DeviceInfo& listed : list_devices()) {
            if (listed.id == info_.id) {
                info_.index = listed.index;
            }
        }
    });
    load_settings(options);
}

void Session::load_settings(const ContextOptions& options) {
    program_cache_ = ProgramCache(info_, program_store_for(info_, options.program_caching));
    if (options.use_profile) profile_ = find_profile(info_);
    language_options_ = with_opencl_errors("asking for a device's language",
                                           [&] { return language_options(language_facts(device_, info_.type)); });
    hand_over_ = options.hand_over != HandOver::automatic ? options.hand_over : hand_over_variable();
    if (hand_over_ == HandOver::automatic && profile_.profile) hand_over_ = profile_.profile->hand_over;
}

std::string Session::all_options(const ProgramSpec& program) const {
    return language_options_ + " -D WORK_GROUP_SIZE=" + std::to_string(program.work_group_size) + program.options;
}

std::vector<Session::Batch> Session::batches_of(std::initializer_list<std::span<const ProgramSpec>> groups) const {
    std::vector<Batch> batches;
    for (const std::span<const ProgramSpec> group : groups) {
        const auto group_begin = static_cast<std::ptrdiff_t>(batches.size());
        for (const ProgramSpec& program : group) {
            const std::string options = all_options(program);
            if (programs_.contains(key_of(program.file, options))) continue;
            const auto same = joins_programs()
                                  ? std::find_if(batches.begin() + group_begin, batches.end(),
                                                 [&](const Batch& batch) { return batch.options == options; })
                                  : batches.end();
            if (same == batches.end()) {
                batches.push_back({{program.file}, options});
            } else {
                same->files.push_back(program.file);
            }
        }
    }
    return batches;
}

cl::Program Session::build_program(const Batch& batch) const {
    const std::string source = kernel_source(batch.files);
    dump_kernels(names_of(batch.files), batch.options, source);
    if (std::optional<cl::Program> kept = program_cache_.load(context_, device_, source, batch.options)) {
        return *std::move(kept);
    }
    return with_opencl_errors(names_of(batch.files), [&] {
        cl::Program program(context_, source);
        try {
            program.build(device_, batch.options.c_str());
        } catch (const cl::Error& error) {
            throw_opencl_error(error, names_of(batch.files) + " with options '" + batch.options + "' on " + info_.name +
                                          ":\n" + program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device_));
        }
        program_cache_.store(program, device_, source, batch.options);
        return program;
    });
}

void Session::prepare(std::initializer_list<std::span<const ProgramSpec>> groups) {
    const std::vector<Batch> batches = batches_of(groups);
    std::vector<cl::Program> built(batches.size());
    const auto build = [&](std::size_t i) { built[i] = build_program(batches[i]); };
    if (info_.platform == "Oclgrind") {  // which crashes where two threads build, in version 21.10
        for (std::size_t i = 0; i < batches.size(); ++i)
            build(i);
    } else {
        in_own_group([&] { tbb::parallel_for(std::size_t{0}, batches.size(), build); });
    }
    program_count_ += built.size();
    for (std::size_t i = 0; i < batches.size(); ++i) {
        for (const std::string_view file : batches[i].files)
            programs_.emplace(key_of(file, batches[i].options), built[i]);
    }
}

Kernel& Session::kernel(const ProgramSpec& program, std::string_view name) {
    const std::string program_key = key_of(program.file, all_options(program));
    const std::string kernel_key = std::string(name) + " " + program_key;
    if (const auto known = kernels_.find(kernel_key); known != kernels_.end()) {
        return known->second;
    }
    if (!programs_.contains(program_key)) prepare({std::span(&program, 1)});
    return with_opencl_errors("kernel " + std::string(name) + " of " + std::string(kernel_path(program.file)),
                              [&]() -> Kernel& {
                                  Kernel kernel{cl::Kernel(programs_.at(program_key), std::string(name).c_str()),
                                                std::string(name), program.work_group_size};
                                  return kernels_.emplace(kernel_key, std::move(kernel)).first->second;
                              });
}

bool Session::joins_programs() const noexcept {
    // PoCL takes 24 ms for a program that it has in its cache, however short, and compiles one at a time.
    return info_.platform == kPoclPlatform;
}

HandOver Session::hand_over() {
    if (hand_over_ == HandOver::automatic) {
        const bool works = info_.type == DeviceType::cpu || hand_over_passes_check(*this);
        hand_over_ = works ? HandOver::within_launch : HandOver::between_launches;
    }
    return hand_over_;
}

bool Session::may_prefer_lane_shape() const noexcept {
    // Mesa's rusticl (22.3) ends the process where a kernel asks for a prefetch, the self-test's too.
    const bool survives_self_test = info_.platform != "rusticl";
    return info_.type == DeviceType::cpu && survives_self_test && lane_shape_works_.value_or(true);
}

bool Session::prefers_lane_shape() {
    if (!may_prefer_lane_shape()) {
        return false;
    }
    if (!lane_shape_works_) {
        lane_shape_works_ = lane_shape_passes_check(*this);
    }
    return *lane_shape_works_;
}

}  // namespace clbvh::device
