// list_gpu_programs FOLDER: every program that the library would compile on some GPUs, for tools/check_gpus. Writes the
// source of each kernel file to FOLDER, and to programs.tsv a line for each program of each GPU: the GPU, the kernel
// file, the work-group size, "default" where the options are the library's own, all options, with tabs between them.
//
// Needs any OpenCL device: it stands for the GPUs, whose facts it is given.
#include <fstream>
#include <iostream>
#include <map>
#include <tuple>

#include "catalog/builder_rows.hpp"
#include "catalog/device_configs.hpp"
#include "clbvh/catalog.hpp"
#include "clbvh/core/error.hpp"
#include "clbvh/device/device_tracer.hpp"
#include "device/build/batch.hpp"
#include "device/build/pipeline.hpp"
#include "device/opencl/kernel_source.hpp"
#include "device/opencl/language.hpp"
#include "device/trace/depth_first_layout.hpp"
#include "device/trace/trace.hpp"
#include "device/tree/device_optimizer_row.hpp"
#include "device/tree/refit.hpp"

namespace {

using namespace clbvh;
using device::LanguageFacts;
using device::ProgramSpec;
using device::Session;

struct Gpu {
    std::string name;
    std::uint32_t compute_units;  // as CL_DEVICE_MAX_COMPUTE_UNITS says, and so on
    std::size_t max_work_group_size;
    std::uint64_t local_memory_bytes;
    LanguageFacts language;
};

LanguageFacts nvidia(std::uint32_t major, std::uint32_t minor) {
    return {DeviceType::gpu, "OpenCL C 1.2 ", false, {}, major, minor, true};
}

LanguageFacts amd() {
    return {DeviceType::gpu, "OpenCL C 2.0 ", false, {}, 0, 0, true};
}

LanguageFacts intel() {
    return {DeviceType::gpu,
            "OpenCL C 1.2 ",
            true,
            {"__opencl_c_atomic_order_acq_rel", "__opencl_c_atomic_scope_device"},
            0,
            0,
            true};
}

std::vector<Gpu> gpus() {
    return {{"sm_90", 132, 1024, 49152, nvidia(9, 0)},
            {"sm_75", 40, 1024, 49152, nvidia(7, 5)},
            {"gfx90a", 104, 256, 65536, amd()},
            {"gfx1100", 48, 256, 65536, amd()},
            {"dg2", 512, 1024, 65536, intel()}};
}

DeviceInfo info_of(const Gpu& gpu) {
    DeviceInfo info = pick_device();
    info.name = gpu.name;
    info.platform = "a GPU's";
    info.type = DeviceType::gpu;
    info.compute_units = gpu.compute_units;
    info.max_work_group_size = gpu.max_work_group_size;
    info.local_memory_bytes = gpu.local_memory_bytes;
    info.int64_atomics = true;
    return info;
}

/// Each value of each option that kernels are compiled with, beside the defaults.
std::vector<BuildOptions> option_sets() {
    std::vector<BuildOptions> sets(9);
    sets[1].ploc.neighbour_search = NeighbourSearch::scan;
    sets[2].ploc.neighbour_encoding = NeighbourEncoding::bits64;
    sets[3].ploc.search_radius = 8;
    sets[4].device.code_bits = 63;
    sets[5].device.morton_code = MortonCode::extended;
    sets[6].hploc.leaf_size = 4;
    sets[7].hploc.search_radius = 8;
    sets[8].hploc.small_range = 256;
    return sets;
}

class ProgramList {
public:
    void add(const ProgramSpec& program, bool is_default) {
        programs_[{std::string(program.file), program.work_group_size, program.options}] |= is_default;
    }
    void add(const std::vector<ProgramSpec>& programs, bool is_default) {
        for (const ProgramSpec& program : programs)
            add(program, is_default);
    }
    void write(const Gpu& gpu, std::ostream& out) const {
        const std::string language = device::language_options(gpu.language);
        for (const auto& [program, is_default] : programs_) {
            const auto& [file, size, options] = program;
            out << gpu.name << '\t' << file << '\t' << size << '\t' << (is_default ? "default" : "") << '\t' << language
                << " -D WORK_GROUP_SIZE=" << size << options << '\n';
        }
    }

private:
    std::map<std::tuple<std::string, std::size_t, std::string>, bool> programs_;  // true: default
};

void add_builders(Session& session, ProgramList& list) {
    bool is_default = true;
    for (const BuildOptions& options : option_sets()) {
        for (const BuilderInfo& builder : builders()) {
            const BuilderRow& row = find_builder_row(builder.id);
            if (row.device_algorithm == nullptr) continue;
            const device::BuildSettings settings =
                device::resolve_settings(*row.device_algorithm, device_configs_for(builder.id, options), session);
            list.add(device::pipeline_programs(session, *row.device_algorithm, settings), is_default);
            if (builder.id == "plocpp" && settings.packed_keys() &&
                settings.configs.device.morton_code != MortonCode::extended) {
                list.add(device::batch_program(settings), is_default);
            }
        }
        is_default = false;
    }
}

void add_trees(Session& session, ProgramList& list) {
    device::OptimizeSettings optimize;
    static_cast<device::DeviceFit&>(optimize) = device::fit_to_device(session, Shape::automatic);
    list.add(device::kReinsert.programs(optimize), true);
    for (const std::uint32_t leaves : {7u, 8u}) {
        optimize.treelet_leaves = leaves;
        list.add(device::kTreelet.programs(optimize), leaves == 7);
    }
    list.add(device::refit_programs(device::resolve_refit_settings(session, Shape::automatic, {})), true);
}

void add_traces(Session& session, ProgramList& list) {
    const DeviceTracerOptions options_by_default;
    for (const TriangleTest test : {TriangleTest::watertight, TriangleTest::moller_trumbore}) {
        DeviceTracerOptions options;
        options.triangle_test = test;
        const device::TraceSettings settings = device::resolve_trace_settings(session, options);
        list.add(device::trace_program(settings), test == options_by_default.triangle_test);
        for (const device::WideKind kind :
             {device::WideKind::wide8, device::WideKind::wide4, device::WideKind::compressed8})
            list.add(device::wide_program(settings.layout, kind), test == options_by_default.triangle_test);
        list.add(device::depth_first_program(settings.layout), test == options_by_default.triangle_test);
    }
}

void list_programs(const std::string& folder) {
    std::ofstream list(folder + "/programs.tsv");
    ContextOptions options;
    options.use_profile = false;
    options.hand_over = HandOver::within_launch;
    for (const Gpu& gpu : gpus()) {
        Session session(info_of(gpu), options);
        ProgramList programs;
        add_builders(session, programs);
        add_trees(session, programs);
        add_traces(session, programs);
        programs.add({"hand_over_check.cl", 256, ""}, true);
        programs.write(gpu, list);
    }
    for (const device::KernelFile& file : std::span(device::kKernelFiles, device::kKernelFileCount)) {
        const std::string name = file.name;
        if (name.ends_with(".cl")) std::ofstream(folder + "/" + name) << device::kernel_source(name);
    }
    if (!list.flush()) throw Error(ErrorCode::io, "cannot write to " + folder);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::cerr << "usage: list_gpu_programs FOLDER\n";
        return 2;
    }
    try {
        list_programs(argv[1]);
    } catch (const Error& error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
    return 0;
}
