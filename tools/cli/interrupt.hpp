#pragma once

namespace clbvh::tool {

/// From now on the first Ctrl-C only sets a flag, so that the work at hand can end cleanly; the second one kills.
void catch_interrupts();

/// True after a Ctrl-C.
[[nodiscard]] bool interrupted() noexcept;

/// Throws Error(cancelled) after a Ctrl-C.
void throw_if_interrupted();

}  // namespace clbvh::tool
