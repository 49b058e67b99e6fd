#pragma once
#include "core/mesh/point_tree.hpp"
#include "objectives/external/gradient_places.hpp"

#include <memory>
#include <string_view>

/// Shared by the readers of gradient files. Internal.
namespace strake {

/// Collects rows in any order and checks that each place has exactly one.
class GradientRows {
public:
    GradientRows(const std::string& name, const GradientPlaces& places);

    /// "FILE:LINE: …", or "FILE: row N: …" if `is_line` is false.
    [[noreturn]] void refuse(const char* kind, const std::string& what) const;
    void next_row(long row) { row_ = row; }
    void rows_are_lines() { is_line_ = true; }

    int with_id(double id);                 ///< place with this number
    int near(const Eigen::RowVector3d& x);  ///< place at these coordinates
    void put(int place, const Eigen::RowVector3d& gradient);
    int count() const { return rows_; }
    const GradientPlaces& places() const { return places_; }
    Points finish() const;  ///< refuses when a place has no row

private:
    std::string name_;
    const GradientPlaces& places_;
    Points rows_of_;
    std::vector<long> row_of_;  ///< of each place, -1: none yet
    std::unique_ptr<PointTree> tree_;
    std::vector<std::pair<std::int64_t, int>> by_id_;
    long row_ = 0;
    int rows_ = 0;
    bool is_line_ = false;
};

/// Reads rows of text into `rows`.
void read_gradient_csv(std::string_view bytes, const std::string& field, GradientRows& rows);

}  // namespace strake
