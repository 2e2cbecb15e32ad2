#include "rays/tracer_arguments.hpp"

#include <CLI/CLI.hpp>
#include <utility>

#include "measure/build_result.hpp"

namespace clbvh::tool {

void TracerArguments::add_options(CLI::App& command) {
    command
        .add_option_function<std::string>(
            "--tracer", [this](const std::string& name) { on_device = name == "device"; },
            "Where rays are traced: the host, or the OpenCL device of --device")
        ->check(CLI::IsMember({"host", "device"}))
        ->type_name("NAME")
        ->default_str("host");
    add_triangle_test(command);
}

void TracerArguments::add_triangle_test(CLI::App& command) {
    command
        .add_option_function<std::string>(
            "--triangle-test",
            [this](const std::string& name) {
                triangle_test = name == "watertight" ? TriangleTest::watertight : TriangleTest::moller_trumbore;
            },
            "How rays are tested against triangles")
        ->check(CLI::IsMember({"watertight", "moller-trumbore"}))
        ->type_name("NAME")
        ->default_str("watertight");
}

std::optional<Context> TracerArguments::context(std::optional<Context> context, std::string_view selector) const {
    if (!on_device || context) return context;
    return Context::open(selector);
}

std::unique_ptr<RayEngine> TracerArguments::engine(const Bvh& bvh, const Mesh& mesh, const BuildOptions& options,
                                                   const std::optional<Context>& context) const {
    if (on_device) return make_device_engine(context.value(), bvh, mesh, triangle_test);
    return make_host_engine(bvh, mesh, {triangle_test, options.thread_count});
}

std::string TracerArguments::place(const std::optional<Context>& context) const {
    return on_device ? context->device().name : "host";
}

std::uint32_t TracerArguments::threads(const BuildOptions& options) const {
    return on_device ? 0 : host_threads(options);
}

}  // namespace clbvh::tool
