// Stands in for the code that measures devices where the library has no OpenCL: no context is ever opened there, so
// that nobody comes here.
#include <clbvh/core/error.hpp>

#include "measure/copy_contestant.hpp"
#include "measure/ray_engine.hpp"

namespace clbvh::tool {
namespace {

[[noreturn]] void refuse() {
    throw Error(ErrorCode::unsupported, "this build of clbvh has no OpenCL");
}

}  // namespace

std::unique_ptr<RayEngine> make_device_engine(const Context&, const Bvh&, const Mesh&, TriangleTest) {
    refuse();
}

struct CopyContestant::Device {};

CopyContestant::CopyContestant(const Context&) {
    refuse();
}
CopyContestant::~CopyContestant() = default;

void CopyContestant::run(bool) {
    refuse();
}
bool CopyContestant::is_right() const {
    refuse();
}

}  // namespace clbvh::tool
