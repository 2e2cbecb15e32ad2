#pragma once

#include <clbvh/device/context.hpp>
#include <cstdint>
#include <memory>
#include <vector>

#include "measure/contestant.hpp"
#include "measure/sample.hpp"

namespace clbvh::tool {

/// The fastest copy that the device's memory is known to allow: what the stages' bytes per second are measured against.
///
/// A kernel copies one buffer to another, both larger than most caches. On a CPU each work item copies a contiguous
/// piece with vectors, asks for what it reads ahead of time, and writes past the caches where the compiler knows how
/// to: an ordinary store reads the line that it overwrites first. Elsewhere each work item copies 16 bytes.
class CopyContestant final : public Contestant {
public:
    /// Throws clbvh::Error where the device has no room for the buffers, or an OpenCL call fails.
    explicit CopyContestant(const Context& context);
    CopyContestant(const CopyContestant&) = delete;
    CopyContestant& operator=(const CopyContestant&) = delete;
    ~CopyContestant() override;

    [[nodiscard]] std::string_view name() const override { return "copy"; }
    void run(bool counted) override;
    /// Gigabytes (10^9) read and written a second.
    [[nodiscard]] Sample gb_per_s() const { return summarize(gb_per_s_); }
    /// True where the target holds what the source does, for tests.
    [[nodiscard]] bool is_right() const;

private:
    struct Device;
    std::unique_ptr<Device> device_;
    std::vector<double> gb_per_s_;
};

}  // namespace clbvh::tool
