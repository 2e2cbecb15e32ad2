#include "clbvh/core/error.hpp"

namespace clbvh {

Error::~Error() = default;

}  // namespace clbvh
