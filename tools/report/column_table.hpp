#pragma once

#include <algorithm>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "report/table.hpp"

namespace clbvh::tool {

/// A column of a table: its title, and what stands in a row.
template <typename Row>
struct Column {
    std::string title;
    std::function<std::string(const Row&)> cell;
};

/// The table of `rows` under `columns`.
template <typename Row>
[[nodiscard]] std::string table_text(const std::vector<Column<Row>>& columns, std::span<const Row> rows) {
    std::vector<std::string> cells(columns.size());
    std::ranges::transform(columns, cells.begin(), &Column<Row>::title);
    Table table(cells);
    for (const Row& row : rows) {
        std::ranges::transform(columns, cells.begin(), [&](const Column<Row>& column) { return column.cell(row); });
        table.add_row(cells);
    }
    return table.text();
}

}  // namespace clbvh::tool
