#include <catch2/catch.hpp>

#include "report/table.hpp"

using clbvh::tool::Table;

TEST_CASE("tables align names to the left and numbers to the right") {
    Table table({"name", "ms"});
    table.add_row({"a", "100.25"});
    table.add_row({"longer", "7.00"});
    CHECK(table.text() ==
          "name        ms\n"
          "a       100.25\n"
          "longer    7.00\n");
}

TEST_CASE("tables of words align to the left, without blanks at the end") {
    Table table({"id", "paper", "title"}, Table::Align::left);
    table.add_row({"ploc", "M", ""});
    table.add_row({"b", "Benthin", "PLOC++"});
    CHECK(table.text() ==
          "id    paper    title\n"
          "ploc  M\n"
          "b     Benthin  PLOC++\n");
}
