#pragma once

#include <string>
#include <vector>

namespace clbvh::tool {

/// Text in aligned columns with a header line: the first column to the left, the others to the right unless told.
class Table {
public:
    enum class Align : unsigned char { left, right };

    explicit Table(std::vector<std::string> header, Align others = Align::right);

    /// `cells` has one entry per column.
    void add_row(std::vector<std::string> cells);
    [[nodiscard]] std::string text() const;

private:
    std::vector<std::vector<std::string>> rows_;
    Align others_;
};

/// A number for a cell; "-" where it is not finite.
[[nodiscard]] std::string fixed_text(double value, int decimals);

}  // namespace clbvh::tool
