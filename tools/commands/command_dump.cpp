#include <CLI/CLI.hpp>
#include <clbvh/core/bvh.hpp>
#include <clbvh/io/bvh_file.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "cli/exit_code.hpp"
#include "cli/output_file.hpp"
#include "commands/command.hpp"
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

int run_dump(const DumpArguments& arguments) {
    const bool is_json = !arguments.json.empty();
    const std::string& target = is_json ? arguments.json : arguments.obj;
    require_writable_target(target);
    const Bvh bvh = read_bvh(arguments.tree);
    write_target(target, is_json ? tree_json(bvh, arguments.depth) : tree_obj(bvh, arguments.depth));
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
    CLI::App* command = app.add_subcommand("dump", "Show a tree that clbvh build has written, for people and scripts");
    command->footer("TREE goes before --json and --obj, which may take a file name. docs/dump.md lists the fields.");
    auto arguments = std::make_shared<DumpArguments>();
    command->add_option("tree", arguments->tree, "A file that clbvh build -o has written")
        ->type_name("TREE")
        ->required();
    CLI::App* format = command->add_option_group("Format", "One of them");
    add_dump_format(*format, "--json", arguments->json, "Nodes with their boxes, children and primitives, one a line");
    add_dump_format(*format, "--obj", arguments->obj, "Boxes as lines, in a group for each depth");
    format->require_option(1);
    command->add_option("--depth", arguments->depth, "Leave out nodes more than N edges below the root")
        ->type_name("N");
    return {command, [arguments] { return run_dump(*arguments); }};
}

}  // namespace clbvh::tool
