#include "report/layout_dump.hpp"

#include <nlohmann/json.hpp>

namespace clbvh::tool {
namespace {

const char* name_of_elements(LayoutKind kind) {
    switch (kind) {
        case LayoutKind::wide8:
        case LayoutKind::wide4: return "blocks";
        case LayoutKind::compressed8: return "triangles";
        case LayoutKind::pair:
        case LayoutKind::skip: break;
    }
    return "primitive_ids";
}

}  // namespace

std::string layout_json(const LayoutFileInfo& info) {
    nlohmann::ordered_json document;
    document["layout"] = to_string(info.kind);
    document["primitive_count"] = info.primitive_count;
    document["split_references"] = info.split_references;
    document["depth"] = info.depth;
    document["nodes"] = info.node_count;
    document[name_of_elements(info.kind)] = info.element_count;
    document["bytes"] = info.file_bytes;
    return document.dump(2) + '\n';
}

}  // namespace clbvh::tool
