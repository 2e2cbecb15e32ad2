#pragma once

namespace clbvh::tool {

/// From now on the first Ctrl-C or SIGTERM is only noted, so that the work at hand can end cleanly; the second one
/// kills.
void catch_interrupts();

/// True after one of them.
[[nodiscard]] bool interrupted() noexcept;
/// Its number; 0 where there was none.
[[nodiscard]] int interrupting_signal() noexcept;

/// Throws Error(cancelled) after one of them.
void throw_if_interrupted();

}  // namespace clbvh::tool
