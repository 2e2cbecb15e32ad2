#include "clbvh/options.hpp"

#include <algorithm>
#include <iterator>

#include "catalog/option_rows.hpp"
#include "clbvh/catalog.hpp"
#include "clbvh/core/error.hpp"
#include "core/memory_errors.hpp"

namespace clbvh {
namespace {

OptionInfo info_of(const OptionRow& row) {
    return {.name = row.name,
            .flag = row.flag,
            .group = row.group,
            .help = row.help,
            .readers = row.readers,
            .type = type_of(row.value),
            .values = values_text(row.value),
            .default_value = get_value(row.value, {}),
            .implied = row.implied,
            .choices = choices_of(row.value)};
}

[[noreturn]] void refuse_unknown(std::string_view name) {
    std::string meant;
    std::string known;
    for (const OptionRow& row : option_rows()) {
        known += (known.empty() ? "" : ", ") + std::string(row.name);
        const bool is_last_part = row.name.ends_with(name) && row.name[row.name.size() - name.size() - 1] == '.';
        if (is_last_part) meant += (meant.empty() ? "; did you mean " : " or ") + std::string(row.name);
    }
    throw Error(ErrorCode::invalid_input,
                "unknown option '" + std::string(name) + "'" + meant + "; known are: " + known);
}

const OptionRow& find_row(std::string_view name) {
    const auto row = std::ranges::find(option_rows(), name, &OptionRow::name);
    if (row == option_rows().end()) refuse_unknown(name);
    return *row;
}

/// The costs and the leaf size of a Config in BuildOptions have no say: whoever sets them is told.
template <typename Config>
void check_left_alone(std::string_view name, const Config& config) {
    const Config defaults;
    const auto check = [&](std::string_view field, auto Config::*member) {
        if (config.*member == defaults.*member) return;
        throw Error(ErrorCode::invalid_input, std::string(name) + "." + std::string(field) +
                                                  " is set, but builds take BuildOptions::" + std::string(field));
    };
    check("inner_cost", &Config::inner_cost);
    check("primitive_cost", &Config::primitive_cost);
    check("max_leaf_size", &Config::max_leaf_size);
}

}  // namespace

std::span<const OptionInfo> options() {
    static const std::vector<OptionInfo> infos = with_memory_errors("the table of options", [] {
        std::vector<OptionInfo> list;
        std::ranges::transform(option_rows(), std::back_inserter(list), info_of);
        return list;
    });
    return infos;
}

const OptionInfo& find_option(std::string_view name) {
    return options()[static_cast<std::size_t>(&find_row(name) - option_rows().data())];
}

void set_option(BuildOptions& options, std::string_view name, std::string_view value) {
    const OptionRow& row = find_row(name);
    set_value(row.value, row.name, value, options);
}

std::string get_option(const BuildOptions& options, std::string_view name) {
    return get_value(find_row(name).value, options);
}

bool reads_option(std::string_view builder, std::string_view name) {
    const BuilderInfo& info = find_builder(builder);
    const std::string_view readers = find_row(name).readers;
    if (readers == "all") return true;
    if (readers == "device") return info.kind == BuilderKind::device;
    const std::string list = ", " + std::string(readers) + ",";
    return list.find(", " + std::string(info.id) + ",") != std::string::npos;
}

void check_options(const BuildOptions& options) {
    for (const OptionRow& row : option_rows())
        check_value(row.value, row.name, options);
    check_left_alone("binned_sah", options.binned_sah);
    check_left_alone("sbvh", options.sbvh);
    if (options.max_leaf_size > 0 && options.hploc.leaf_size > options.max_leaf_size) {
        throw Error(ErrorCode::invalid_input, "hploc.leaf_size " + std::to_string(options.hploc.leaf_size) +
                                                  " makes leaves that are larger than max_leaf_size " +
                                                  std::to_string(options.max_leaf_size));
    }
    if (options.presplit_level > 0 && options.split_quota > 0.0f) {
        throw Error(ErrorCode::invalid_input,
                    "presplit_level and split_quota are two ways to split triangles: give one");
    }
}

}  // namespace clbvh
