#include "tests/bench/session_way.hpp"

#include <cmath>
#include <fstream>
#include <optional>
#include <string>

#include "coupler/coupler.hpp"
#include "coupler/mapping/lattice_mapping.hpp"

namespace bench {
namespace {

//! `back`: what side 0 gets. Both sides write the same scene.
std::string scene_of(std::string const& transport, bool parallel, bool lattice)
{
    std::string const forth = lattice ? "moving" : "points";
    return "sluice: 1\ndimension: 3\ntime: {end: 1.0e+9, window: 1}\ntransport: " + transport +
           "\nledger: {on-violation: off}\n"
           "data:\n"
           "  points: {columns: {position: {shape: vector, unit: m}}}\n"
           "  moving: {columns: {position: {shape: vector, unit: m}, value: {shape: vector, unit: N}}}\n"
           "participants: {side0: {command: none}, side1: {command: none}}\n"
           "couplings:\n"
           "  - {from: side0, to: side1, data: " +
           forth + ", sample: hold" + (parallel ? ", lag: 1" : "") + "}\n" +
           "  - {from: side1, to: side0, data: points, lag: 1}\n";
}

//! Velocities forth, forces back, of the same points in every window.
std::string scene_of_loads(std::string const& ledger)
{
    return "sluice: 1\ndimension: 3\ntime: {end: 1.0e+9, window: 1}\ntransport: shm\nledger: " + ledger +
           "\ndata:\n"
           "  motion: {columns: {velocity: {shape: vector, unit: m/s}}}\n"
           "  force: {columns: {force: {shape: vector, unit: N}}}\n"
           "participants: {side0: {command: none}, side1: {command: none}}\n"
           "couplings:\n"
           "  - {from: side0, to: side1, data: motion, sample: hold}\n"
           "  - {from: side1, to: side0, data: force, lag: 1}\n";
}

//! One participant; a round trip is one window.
class SessionWay final : public Way
{
 public:
    //! `ledger`: of velocities and forces; empty: other data.
    SessionWay(Setting const& setting, std::string const& name, std::string const& transport, bool parallel,
               bool lattice, std::string const& ledger = "")
        : side_(setting.side),
          parallel_(parallel),
          loads_(!ledger.empty()),
          ids_(setting.most_points + 1),
          position_(3 * (setting.most_points + 1)),
          value_(lattice ? position_.size() : 0)
    {
        auto const directory = setting.directory / name;
        std::filesystem::create_directories(directory);
        auto const file = directory / "scene.yaml", mine = directory / ("scene" + std::to_string(side_));
        std::ofstream(mine) << (loads_ ? scene_of_loads(ledger) : scene_of(transport, parallel, lattice));
        std::filesystem::rename(mine, file);  // the other side writes the same
        self_.emplace(
            sluice::JoinOptions{.scene = file, .name = "side" + std::to_string(side_), .directory = directory / "run"});
        self_->config().finish();
        if (lattice && side_ == 1) open_lattice(setting.most_points);
        write(0);
        windows_.emplace(self_->windows());
    }

    void round_trip(std::size_t points) override
    {
        bool const first = !at_;
        if (first) at_.emplace(windows_->begin());
        if (side_ == 0 || parallel_) {
            write(points);
            ++*at_;
            take();
        } else {
            if (!first) ++*at_;
            take();
            write(points);
        }
    }

 private:
    std::string partner() const { return "side" + std::to_string(1 - side_); }

    //! Other points than last time, one more every other time, at other places.
    void write(std::size_t points)
    {
        ++turn_;
        auto const n = points + static_cast<std::size_t>(turn_ % 2);
        for (std::size_t i = 0; i < n; ++i) ids_[i] = static_cast<std::int64_t>(i) + turn_;
        double const shift = static_cast<double>(turn_ % 64) / 64;
        if (loads_) return write_loads(points, shift);
        auto const ids = std::span<std::int64_t const>(ids_).first(n);
        if (lattice_) {  // what was gathered at the points that came
            self_->write(partner(), "points", std::span<std::int64_t const>(came_ids_),
                         {std::span<double const>(gathered_)});
            return;
        }
        if (value_.empty()) {
            for (std::size_t k = 0; k < 3 * n; ++k) position_[k] = static_cast<double>(k) + shift;
            self_->write(partner(), "points", ids, {std::span<double const>(position_).first(3 * n)});
            return;
        }
        auto const edge = std::max(1.0, std::ceil(std::cbrt(static_cast<double>(n))));
        auto const per_edge = static_cast<std::size_t>(edge);
        for (std::size_t i = 0; i < n; ++i) {
            position_[3 * i] = static_cast<double>(i % per_edge) + 1 + shift;
            position_[3 * i + 1] = static_cast<double>(i / per_edge % per_edge) + 1 + shift;
            position_[3 * i + 2] = static_cast<double>(i / per_edge / per_edge) + 1 + shift;
        }
        self_->write(partner(), "moving", ids,
                     {std::span<double const>(position_).first(3 * n), std::span<double const>(value_).first(3 * n)});
    }

    void write_loads(std::size_t n, double shift)
    {
        for (std::size_t i = 0; i < n; ++i) ids_[i] = static_cast<std::int64_t>(i);
        for (std::size_t k = 0; k < 3 * n; ++k) position_[k] = static_cast<double>(k) + shift;
        self_->write(partner(), side_ == 0 ? "motion" : "force", std::span<std::int64_t const>(ids_).first(n),
                     {std::span<double const>(position_).first(3 * n)});
    }

    void take()
    {
        if (loads_) {
            auto const& values = self_->read(partner(), side_ == 0 ? "force" : "motion", **at_).columns((**at_).end)[0];
            for (std::size_t k = 0; k < values.size(); k += 8) sum_ += values[k];
            return;
        }
        auto samples = self_->read(partner(), side_ == 1 && !lattice_field_.empty() ? "moving" : "points", **at_);
        auto const& columns = samples.columns((**at_).end);
        if (!lattice_) {
            auto const& values = columns[0];
            double sum = 0;
            for (std::size_t k = 0; k < values.size(); k += 8) sum += values[k];  // every cache line
            sum_ += sum;
            return;
        }
        auto const ids = samples.ids();
        came_ids_.assign(ids.begin(), ids.end());
        gathered_.resize(3 * ids.size());
        lattice_->place(columns[0]);
        lattice_->spread(columns[1], 3, lattice_field_);
        lattice_->gather(lattice_field_, 3, gathered_);
    }

    void open_lattice(std::size_t most)
    {
        auto const edge = static_cast<int>(std::ceil(std::cbrt(static_cast<double>(most + 1)))) + 4;
        sluice::Lattice const lattice{.dimension = 3, .origin = {0, 0, 0}, .spacing = 1, .cells = {edge, edge, edge}};
        lattice_.emplace(lattice, sluice::LatticeKernel::hat, sluice::Border::mirror);
        lattice_field_.resize(3 * static_cast<std::size_t>(edge) * static_cast<std::size_t>(edge) *
                              static_cast<std::size_t>(edge));
    }

    int side_;
    bool parallel_, loads_;
    std::int64_t turn_ = 0;
    std::vector<std::int64_t> ids_;
    std::vector<double> position_, value_;
    std::optional<sluice::Participant> self_;
    std::optional<sluice::Windows> windows_;
    std::optional<sluice::Windows::Iterator> at_;
    std::optional<sluice::LatticeMapping> lattice_;
    std::vector<double> lattice_field_, gathered_;
    std::vector<std::int64_t> came_ids_;
    double sum_ = 0;
};

}  // namespace

std::unique_ptr<Way> session_shm(Setting const& setting)
{
    return std::make_unique<SessionWay>(setting, "session-shm", "shm", false, false);
}

std::unique_ptr<Way> session_shm_parallel(Setting const& setting)
{
    return std::make_unique<SessionWay>(setting, "session-shm-parallel", "shm", true, false);
}

std::unique_ptr<Way> session_zmq(Setting const& setting)
{
    return std::make_unique<SessionWay>(setting, "session-zmq", "zmq", false, false);
}

std::unique_ptr<Way> session_zmq_parallel(Setting const& setting)
{
    return std::make_unique<SessionWay>(setting, "session-zmq-parallel", "zmq", true, false);
}

std::unique_ptr<Way> session_unbooked(Setting const& setting)
{
    return std::make_unique<SessionWay>(setting, "session-unbooked", "shm", false, false, "{on-violation: off}");
}

std::unique_ptr<Way> session_amounts(Setting const& setting)
{
    return std::make_unique<SessionWay>(setting, "session-amounts", "shm", false, false, "{energy: {every: 0}}");
}

std::unique_ptr<Way> session_energy(Setting const& setting)
{
    return std::make_unique<SessionWay>(setting, "session-energy", "shm", false, false, "{energy: {every: 1}}");
}

std::unique_ptr<Way> session_mpi(Setting const& setting)
{
    return std::make_unique<SessionWay>(setting, "session-mpi", "mpi", false, false);
}

std::unique_ptr<Way> session_lattice(Setting const& setting)
{
    return std::make_unique<SessionWay>(setting, "session-lattice", "shm", false, true);
}

}  // namespace bench
