#include "builder_choice.hpp"

#include <algorithm>
#include <clbvh/core/error.hpp>
#include <clbvh/registry.hpp>

namespace clbvh::tool {
namespace {

bool runs_on_device(std::string_view id) {
    return find_builder(id).kind == BuilderKind::device;
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
        } else {
            add_id(find_builder(word).id);
            needs_device_ = needs_device_ || runs_on_device(word);
        }
    }
    [[nodiscard]] const std::vector<std::string>& ids() const { return ids_; }
    [[nodiscard]] bool needs_device() const { return needs_device_; }

private:
    void add_id(std::string_view id) {
        if (std::find(ids_.begin(), ids_.end(), id) == ids_.end()) ids_.emplace_back(id);
    }

    std::vector<std::string> ids_;
    bool needs_device_ = false;
};

IdList parse(std::string_view list) {
    IdList result;
    for (std::size_t begin = 0; begin <= list.size();) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        result.add_word(list.substr(begin, end - begin));
        begin = end + 1;
    }
    return result;
}

}  // namespace

BuilderChoice choose_builders(std::string_view list, std::string_view device) {
    const IdList wanted = parse(list);
    BuilderChoice choice;
    choice.ids = wanted.ids();
    if (std::none_of(choice.ids.begin(), choice.ids.end(), runs_on_device)) return choice;
    try {
        choice.context = Context::open(device);
    } catch (const Error& error) {
        if (wanted.needs_device() || !device.empty()) throw;
        choice.reason = error.what();
        const auto first_unavailable = std::stable_partition(choice.ids.begin(), choice.ids.end(),
                                                             [](const std::string& id) { return !runs_on_device(id); });
        choice.unavailable_ids.assign(first_unavailable, choice.ids.end());
        choice.ids.erase(first_unavailable, choice.ids.end());
    }
    return choice;
}

}  // namespace clbvh::tool
