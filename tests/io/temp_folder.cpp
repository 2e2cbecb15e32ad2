#include "io/temp_folder.hpp"

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <system_error>

namespace clbvh::test {

TempFolder::TempFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "clbvh-io-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::system_error(errno, std::generic_category(), name);
    folder_ = name;
}

TempFolder::~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
}

std::size_t TempFolder::entry_count() const {
    const std::filesystem::directory_iterator entries(folder_);
    return static_cast<std::size_t>(std::distance(begin(entries), end(entries)));
}

std::string TempFolder::write(std::string_view name, std::string_view content) const {
    const std::filesystem::path file = path(name);
    std::ofstream stream(file, std::ios::binary);
    stream.exceptions(std::ios::failbit | std::ios::badbit);
    stream.write(content.data(), static_cast<std::streamsize>(content.size()));
    stream.close();
    return file.string();
}

std::string content_of(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace clbvh::test
