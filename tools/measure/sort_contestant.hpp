#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "measure/contestant.hpp"
#include "measure/native_sort.hpp"
#include "measure/sample.hpp"

namespace clbvh::tool {

/// The native sort: always over the same random keys.
class SortContestant final : public Contestant {
public:
    explicit SortContestant(std::size_t count);

    [[nodiscard]] std::string_view name() const override { return "native sort"; }
    void run(bool counted) override;
    [[nodiscard]] Sample milliseconds() const { return summarize(milliseconds_); }

private:
    NativeSort sort_;
    std::vector<std::uint64_t> random_keys_;
    std::vector<std::uint64_t> keys_;
    std::vector<std::uint32_t> values_;
    std::vector<double> milliseconds_;
};

}  // namespace clbvh::tool
