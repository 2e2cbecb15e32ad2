#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "clbvh/builder.hpp"

namespace clbvh::test {

/// The context that all tests of one process share, so that each program is built once.
[[nodiscard]] const Context& shared_context();

/// Whether this builder, or preset, can run: in a build without OpenCL only those of the host can.
[[nodiscard]] bool can_run(std::string_view id);

/// Ids of the table's device builders that can run.
[[nodiscard]] std::vector<std::string_view> device_builders();
/// Those of them that need nothing of the host, and DeviceBuilder takes.
[[nodiscard]] std::vector<std::string_view> enqueued_builders();

/// Ids of the table's host builders.
[[nodiscard]] std::vector<std::string_view> host_builders();

/// A builder on the shared context, where there is one.
[[nodiscard]] Builder make_builder(std::string_view id, const BuildOptions& options = {});

/// The builder's tree. Of one that cannot run, its oracle's, which is the same bytes; max_leaf_size is then the only
/// option heeded beside those of oracle_tree().
[[nodiscard]] Bvh built_tree(std::string_view id, const Mesh& mesh, const BuildOptions& options = {});

/// Options of one shape, with a number of Morton ranges that oracles know.
[[nodiscard]] BuildOptions options_of(Shape shape, std::uint32_t radius = 16);

/// Checks that `bvh` is the oracle's tree for these options, with the documented numbering, and valid.
/// Returns false after the first failed check, so that a loop can stop.
bool expect_oracle_tree(const Builder& builder, const Bvh& bvh, const Mesh& mesh, const std::string& where);

/// True where both trees are the same bytes.
[[nodiscard]] bool same_bytes(const Bvh& a, const Bvh& b);

/// The stage of this name. Fails the test where there is none.
[[nodiscard]] const StageStats& stage(const BuildStats& stats, std::string_view name);

}  // namespace clbvh::test
