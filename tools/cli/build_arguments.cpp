#include "cli/build_arguments.hpp"
#include "cli/complain.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <clbvh/catalog.hpp>
#include <clbvh/core/error.hpp>
#include <cstdint>
#include <system_error>

namespace clbvh::tool {
namespace {

template <typename Number>
bool is_a(const std::string& value) {
    Number number{};
    const char* const end = value.data() + value.size();
    const auto [rest, error] = std::from_chars(value.data(), end, number);
    return error == std::errc{} && rest == end;
}

/// Refuses what is not a number, an error of usage; the library refuses numbers out of range.
std::string refuse_whole(const std::string& value) {
    if (value.empty()) return "needs a number";
    return is_a<std::uint32_t>(value) ? "" : "'" + value + "' is not a whole number";
}
std::string refuse_real(const std::string& value) {
    if (value.empty()) return "needs a number";
    return is_a<float>(value) ? "" : "'" + value + "' is not a number";
}

bool is_switch(const OptionInfo& option) {
    return option.type == OptionType::boolean && option.default_value == "off";
}

std::string type_name(const OptionInfo& option) {
    switch (option.type) {
        case OptionType::whole: return option.implied.empty() ? "N" : "[N]";
        case OptionType::real: return option.implied.empty() ? "X" : "[X]";
        case OptionType::boolean:
        case OptionType::choice: return "NAME";
        case OptionType::text: break;
    }
    return "A,B,C";
}

/// The help of the first of them, then which values they take, and whose they are unless all builders' of their group.
std::string help_text(const std::vector<const OptionInfo*>& rows) {
    const OptionInfo& first = *rows.front();
    std::vector<std::string> notes;
    const bool is_number = first.type == OptionType::whole || first.type == OptionType::real;
    if (is_number) notes.push_back(first.values);
    std::string readers;
    for (const OptionInfo* row : rows) {
        if (readers.find(row->readers) == std::string::npos)
            readers += (readers.empty() ? "" : ", ") + std::string(row->readers);
    }
    if (readers != "all" && readers != "device") notes.push_back(readers);
    return std::string(first.help) + (notes.empty() ? "" : fmt::format(" ({})", fmt::join(notes, "; ")));
}

}  // namespace

void BuildArguments::set(const Rows& rows, const std::string& value) {
    given_.push_back(rows);
    try {
        for (const OptionInfo* row : rows)
            set_option(options, row->name, value);
    } catch (const Error& error) {
        if (refusal_.empty()) refusal_ = std::string(rows.front()->flag) + ": " + error.what();
    }
}

void BuildArguments::add_rows(CLI::App& command, const Rows& rows) {
    const OptionInfo& first = *rows.front();
    const std::string flag(first.flag);
    const std::string help = help_text(rows);
    if (is_switch(first)) {
        command
            .add_flag_callback(
                flag, [this, rows] { set(rows, "on"); }, help)
            ->group(std::string(first.group));
        return;
    }
    CLI::Option* const option = command.add_option_function<std::string>(
        flag, [this, rows](const std::string& value) { set(rows, value); }, help);
    option->group(std::string(first.group))->type_name(type_name(first));
    option->default_str(get_option(options, first.name));
    if (!first.implied.empty()) option->expected(0, 1)->default_str(std::string(first.implied));
    if (first.type == OptionType::whole) option->check(refuse_whole);
    if (first.type == OptionType::real) option->check(refuse_real);
    if (first.type == OptionType::boolean) option->check(CLI::IsMember({"on", "off"}));
    if (first.type == OptionType::choice)
        option->check(CLI::IsMember(std::vector<std::string>(first.choices.begin(), first.choices.end())));
}

void BuildArguments::add_options(CLI::App& command) {
    std::vector<Rows> flags;
    for (const OptionInfo& row : clbvh::options()) {
        const auto same = std::ranges::find(flags, row.flag, [](const Rows& rows) { return rows.front()->flag; });
        if (same != flags.end()) {
            same->push_back(&row);
        } else {
            flags.push_back({&row});
        }
    }
    for (const Rows& rows : flags)
        add_rows(command, rows);
    command.add_option("--device", device, "Index, type (gpu, cpu, accelerator) or part of a name; see clbvh devices")
        ->group("Device builders")
        ->type_name("D");
}

void BuildArguments::check() const {
    if (!refusal_.empty()) throw Error(ErrorCode::invalid_input, refusal_);
    check_options(options);
}

void BuildArguments::note_unread(std::span<const std::string> builders) const {
    for (const Rows& rows : given_) {
        const auto is_read = [&](const OptionInfo* row) {
            return std::ranges::any_of(builders, [&](const auto& id) { return reads_option(id, row->name); });
        };
        if (std::ranges::any_of(rows, is_read)) continue;
        complain(fmt::format("note: {} changes nothing here, none of these builders reads it; see clbvh options",
                             rows.front()->flag));
    }
}

}  // namespace clbvh::tool
