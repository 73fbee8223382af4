#include "coupler/ledger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace sluice {
namespace {

//! Prediction of order 2 uses three frames with weights up to 3, 3 and 1: so much may be under way.
constexpr double windows_under_way = 7;

}  // namespace

bool is_amount(ColumnSpec const& column)
{
    constexpr std::array amounts{"N", "N m", "N s", "N m s", "J", "W", "kg", "m3", "kg m/s", "kg/s", "m3/s"};
    return std::find(amounts.begin(), amounts.end(), column.unit) != amounts.end();
}

Totals totals_of(DataSpec const& spec, int dimension, std::vector<std::span<double const>> const& columns)
{
    Totals totals;
    for (std::size_t c = 0; c < columns.size(); ++c) {
        if (!is_amount(spec.columns[c])) continue;
        auto const width = static_cast<std::size_t>(components(spec.columns[c].shape, dimension));
        // sums of every 4th point: each addition would wait for the one before
        std::array<std::array<double, 3>, 4> lanes{};
        auto const points = columns[c].size() / width;
        for (std::size_t i = 0; i < points; ++i)
            for (std::size_t k = 0; k < width; ++k) lanes[i % 4][k] += columns[c][i * width + k];
        std::array<double, 3> sum{};
        for (std::size_t k = 0; k < width; ++k) sum[k] = lanes[0][k] + lanes[1][k] + (lanes[2][k] + lanes[3][k]);
        totals.insert(totals.end(), sum.begin(), sum.begin() + static_cast<std::ptrdiff_t>(width));
    }
    return totals;
}

Account::Account(DataSpec const& spec, int dimension, std::string name) : name_(std::move(name))
{
    if (spec.meshless) return;
    for (auto const& column : spec.columns) {
        if (!is_amount(column)) continue;
        int const width = components(column.shape, dimension);
        for (int k = 0; k < width; ++k)
            labels_.push_back(column.name + (width > 1 ? std::string("_") + "xyz"[k] : "") + " [" + column.unit + "]");
    }
    books_.resize(labels_.size());
}

void Account::came(Totals const& totals)
{
    assert(totals.size() == books_.size());
    for (std::size_t k = 0; k < books_.size(); ++k) books_[k].frame = totals[k];
}

void Account::taken(Totals const& totals)
{
    assert(totals.size() == books_.size());
    ++sampled_;
    for (std::size_t k = 0; k < books_.size(); ++k) books_[k].samples += totals[k];
}

void Account::forget_samples()
{
    sampled_ = 0;
    for (Book& b : books_) b.samples = 0;
}

void Account::close(double length)
{
    for (Book& b : books_) {
        double const came = b.frame * length;
        b.came += came;
        b.taken += sampled_ > 0 ? b.samples / sampled_ * length : 0.0;
        b.moved += std::abs(came);
        b.largest = std::max(b.largest, std::abs(came));
    }
    ++windows_;
    forget_samples();
}

void Account::sent(Totals const& written, Totals const& sent, Totals const& outside)
{
    sender_ = true;
    ++windows_;
    for (std::size_t k = 0; k < books_.size(); ++k) {
        books_[k].came += written[k];
        books_[k].taken += sent[k] + outside[k];
        books_[k].outside += outside[k];
        books_[k].moved += std::abs(written[k]);
    }
}

std::string Account::violation(double tolerance) const
{
    for (std::size_t k = 0; k < books_.size(); ++k) {
        Book const& b = books_[k];
        double const under_way = sender_ ? 0 : windows_under_way * b.largest;
        // sums of many numbers of both signs: rounding grows with what was moved, which `tolerance` is relative to
        if (std::abs(b.came - b.taken) <= tolerance * b.moved + under_way) continue;
        return sender_ ? fmt::format("{}: {} does not close: {:.6g} were written, {:.6g} sent or left outside.", name_,
                                     labels_[k], b.came, b.taken)
                       : fmt::format(
                             "{}: {} does not close: {:.6g} times seconds came in {} windows, {:.6g} were taken. "
                             "Does the solver read all of it?",
                             name_, labels_[k], b.came, windows_, b.taken);
    }
    return {};
}

nlohmann::ordered_json Account::summary() const
{
    nlohmann::ordered_json rows = nlohmann::ordered_json::object();
    for (std::size_t k = 0; k < books_.size(); ++k) {
        rows[labels_[k]] = {{sender_ ? "written" : "came", books_[k].came},
                            {sender_ ? "sent" : "taken", books_[k].taken}};
        if (sender_) rows[labels_[k]]["outside"] = books_[k].outside;
    }
    return {{"edge", name_}, {"windows", windows_}, {"books", rows}};
}

}  // namespace sluice
