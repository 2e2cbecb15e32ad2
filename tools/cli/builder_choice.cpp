#include "cli/builder_choice.hpp"

#include <algorithm>
#include <clbvh/catalog.hpp>
#include <clbvh/core/error.hpp>
#include <string>

namespace clbvh::tool {
namespace {

bool runs_on_device(std::string_view id) {
    return find_builder(id).kind == BuilderKind::device;
}

void require_id_or_group(std::string_view word) {
    try {
        static_cast<void>(require_builder(word));
    } catch (const Error& error) {
        throw Error(error.code(), std::string(error.what()) + "; groups are: all, host, device, presets");
    }
}

std::string_view without_spaces_around(std::string_view word) {
    const std::size_t begin = std::min(word.find_first_not_of(' '), word.size());
    return word.substr(begin, word.find_last_not_of(' ') + 1 - begin);
}

/// The ids of a list, and whether a device is needed or only welcome.
class IdList {
public:
    void add_word(std::string_view word) {
        if (word == "all" || word == "host" || word == "device") {
            for (const BuilderInfo& builder : builders()) {
                if (word == "all" || word == (builder.kind == BuilderKind::host ? "host" : "device")) {
                    add_id(builder.id);
                }
            }
            needs_device_ = needs_device_ || word == "device";
        } else if (word == "presets") {
            for (const PresetInfo& preset : presets())
                name_id(preset.id);
        } else {
            require_id_or_group(word);
            name_id(word);
        }
    }
    [[nodiscard]] const std::vector<std::string>& ids() const { return ids_; }
    [[nodiscard]] const std::vector<std::string>& named_ids() const { return named_ids_; }
    [[nodiscard]] bool needs_device() const { return needs_device_; }

private:
    void name_id(std::string_view id) {
        add_id(id);
        named_ids_.emplace_back(id);
        needs_device_ = needs_device_ || runs_on_device(id);
    }
    void add_id(std::string_view id) {
        if (std::find(ids_.begin(), ids_.end(), id) == ids_.end()) ids_.emplace_back(id);
    }

    std::vector<std::string> ids_;
    std::vector<std::string> named_ids_;
    bool needs_device_ = false;
};

IdList parse(std::string_view list) {
    IdList result;
    for (std::size_t begin = 0; begin <= list.size();) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        result.add_word(without_spaces_around(list.substr(begin, end - begin)));
        begin = end + 1;
    }
    return result;
}

}  // namespace

const BuilderInfo& require_builder(std::string_view id) {
    try {
        return find_builder(id);
    } catch (const Error& error) {
        if (!id.starts_with("embree")) throw;
        throw Error(error.code(), std::string(error.what()) + "; Embree's builders come with bench --peers");
    }
}

BuilderChoice choose_builders(std::string_view list, std::string_view device, std::string_view way_out) {
    const IdList wanted = parse(list);
    BuilderChoice choice;
    choice.ids = wanted.ids();
    choice.named_ids = wanted.named_ids();
    if (std::none_of(choice.ids.begin(), choice.ids.end(), runs_on_device)) return choice;
    try {
        choice.context = Context::open(device);
    } catch (const Error& error) {
        if (!device.empty()) throw;
        if (wanted.needs_device()) throw Error(error.code(), std::string(error.what()) + "; " + std::string(way_out));
        choice.reason = error.what();
        const auto first_unavailable = std::stable_partition(choice.ids.begin(), choice.ids.end(),
                                                             [](const std::string& id) { return !runs_on_device(id); });
        choice.unavailable_ids.assign(first_unavailable, choice.ids.end());
        choice.ids.erase(first_unavailable, choice.ids.end());
    }
    return choice;
}

}  // namespace clbvh::tool
