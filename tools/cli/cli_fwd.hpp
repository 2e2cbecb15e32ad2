#pragma once

/// CLI11's header takes longer to compile than most files here: headers name its types, and only what adds options
/// includes it.
namespace CLI {
class App;
class Option;
}  // namespace CLI
