#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "participants/dem/config.hpp"
#include "participants/files/lines.hpp"

//! Rows of numbers as grains. Which column is what comes from a header; the formats differ in how that looks.
namespace dem {

using files::Lines, files::number_in, files::take_word, files::trimmed;

//! What a column may say. `scaled`: as a part of the box; `unwound`: not put back into a periodic box.
enum Column : std::size_t
{
    id_column,
    type_column,
    x_column,  // x, y, z are neighbours, here and below
    y_column,
    z_column,
    x_scaled,
    y_scaled,
    z_scaled,
    x_unwound,
    y_unwound,
    z_unwound,
    radius_column,
    diameter_column,
    density_column,
    x_velocity,
    y_velocity,
    z_velocity,
    x_spin,
    y_spin,
    z_spin,
    columns,
    no_column = columns  //!< not looked at
};

//! The column of this name, as CSV files and dumps have it; no_column: none.
Column column_of(std::string_view name);
std::string_view name_of(Column column);
std::string_view unit_of(Column column);  //!< empty: a number
//! The names that a CSV file may have.
std::vector<std::string> csv_names();

//! A row: each column's number, 0 where there is none.
using Row = std::array<double, columns>;

class Layout
{
 public:
    explicit Layout(std::vector<Column> order);
    bool has(Column column) const { return has_[column]; }
    std::size_t size() const { return order_.size(); }

    //! Fails at the line for a number too many or too few, a word that is none, or a number out of bounds.
    void read(Lines const& lines, std::string_view text, char separator, Row& row) const;

 private:
    std::vector<Column> order_;
    std::array<bool, columns + 1> has_{};
};

//! The grain of a row whose x, y, z are places; fails at the line for one that cannot be. No id: -1. No density: 0.
GrainConfig grain_of(Lines const& lines, Layout const& layout, Row const& row, int dimension);

//! A whole number, if the word is one.
std::optional<std::int64_t> whole_number(std::string_view word);

}  // namespace dem
