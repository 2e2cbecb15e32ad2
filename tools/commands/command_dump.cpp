#include <CLI/CLI.hpp>
#include <clbvh/core/bvh.hpp>
#include <clbvh/core/error.hpp>
#include <clbvh/io/bvh_file.hpp>
#include <clbvh/io/layout_file.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "cli/exit_code.hpp"
#include "cli/layout_choice.hpp"
#include "cli/output_file.hpp"
#include "commands/command.hpp"
#include "report/layout_dump.hpp"
#include "report/tree_dump.hpp"

namespace clbvh::tool {
namespace {

constexpr const char* kDumpsToStandardOutput = "-";

struct DumpArguments {
    std::string tree;
    std::string json;  // empty where the other one was asked for
    std::string obj;
    std::uint32_t depth = kAnyDepth;
};

/// Read as a whole, so that what is shown is not that of a damaged file.
std::string layout_dump(const DumpArguments& arguments) {
    if (arguments.json.empty() || arguments.depth != kAnyDepth) {
        throw Error(ErrorCode::unsupported,
                    arguments.tree + " holds a layout, of which only --json shows something, without --depth");
    }
    const LayoutFileInfo info = read_layout_info(arguments.tree);
    with_layout(info.kind, [&](auto layout) { read_layout(arguments.tree, layout); });
    return layout_json(info);
}

std::string tree_dump(const DumpArguments& arguments) {
    const Bvh bvh = read_bvh(arguments.tree);
    return arguments.json.empty() ? tree_obj(bvh, arguments.depth) : tree_json(bvh, arguments.depth);
}

int run_dump(const DumpArguments& arguments) {
    const std::string& target = arguments.json.empty() ? arguments.obj : arguments.json;
    require_writable_target(target);
    write_target(target, is_layout_file(arguments.tree) ? layout_dump(arguments) : tree_dump(arguments));
    return kExitSuccess;
}

CLI::Option* add_dump_format(CLI::App& group, const std::string& name, std::string& target, const std::string& help) {
    return group.add_option(name, target, help + "; standard output where no FILE is given, or -")
        ->type_name("FILE")
        ->expected(0, 1)
        ->default_str(kDumpsToStandardOutput);
}

}  // namespace

Command add_dump_command(CLI::App& app) {
    CLI::App* command =
        app.add_subcommand("dump", "Show a tree or a layout that clbvh build has written, for people and scripts");
    command->footer("TREE goes before --json and --obj, which may take a file name. docs/dump.md lists the fields.");
    auto arguments = std::make_shared<DumpArguments>();
    command->add_option("tree", arguments->tree, "A file that clbvh build -o has written")
        ->type_name("TREE")
        ->required();
    CLI::App* format = command->add_option_group("Format", "One of them");
    add_dump_format(*format, "--json", arguments->json,
                    "Nodes with their boxes, children and primitives, one a line; kind, counts and bytes of a layout");
    add_dump_format(*format, "--obj", arguments->obj, "Boxes as lines, in a group for each depth");
    format->require_option(1);
    command->add_option("--depth", arguments->depth, "Leave out nodes more than N edges below the root")
        ->type_name("N");
    return {command, [arguments] { return run_dump(*arguments); }};
}

}  // namespace clbvh::tool
