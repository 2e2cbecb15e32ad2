#pragma once

#include <string>

namespace clbvh::tool {

/// Throws what load_scene would throw, with the scene named, where `scene` names no generated scene or no regular file
/// that can be opened, so that a typing error is found before the long work. A file is not read.
void require_scene(const std::string& scene);

}  // namespace clbvh::tool
