// Drop, damage or kill at message N, for N = 1, 2, ... until two participants over the loopback transport do not get so
// far as N: each time both end, with success or with one clear error. In real time, beside tests/simulation.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "coupler/coupler.hpp"
#include "tests/support/toys.hpp"

namespace {

enum class Fault
{
    drop,  //!< the connection breaks with the message: both find each other lost
    damage,
    kill
};

struct Killed
{};

//! What the two ends of a connection share.
struct Line
{
    std::atomic<std::int64_t> sent{0};
    std::atomic<bool> struck{false}, broken{false};
    std::int64_t at;
    Fault fault;
};

//! The loopback transport with something done to the message of one number, counted over both ends.
class Faulty final : public sluice::Transport
{
 public:
    Faulty(std::unique_ptr<sluice::Transport> inner, Line& line) : inner_(std::move(inner)), line_(line) {}

    std::span<std::byte> reserve(int peer, std::size_t size) override { return room_ = inner_->reserve(peer, size); }
    bool commit(int peer, std::size_t size) override
    {
        if (line_.broken) return false;
        if (++line_.sent == line_.at) {
            line_.struck = true;
            if (line_.fault == Fault::kill) throw Killed{};
            if (line_.fault == Fault::drop) return line_.broken = true;
            room_[size / 2] ^= std::byte{4};
        }
        return inner_->commit(peer, size);
    }
    std::optional<Incoming> receive(std::chrono::microseconds patience) override { return inner_->receive(patience); }
    bool lost(int peer) const override { return line_.broken || inner_->lost(peer); }
    std::string kind() const override { return inner_->kind(); }

 private:
    std::unique_ptr<sluice::Transport> inner_;
    Line& line_;
    std::span<std::byte> room_;
};

struct Ending
{
    bool well = false, killed = false;
    int exit = 0;
    std::string error;
    double place = 0;
};

Ending live(std::shared_ptr<sluice::LoadedScene const> const& scene, std::string const& name,
            std::unique_ptr<sluice::Transport> transport)
{
    Ending ending;
    sluice::JoinOptions options;
    options.name = name;
    options.given = scene;
    options.transport = std::move(transport);
    try {
        sluice::Participant self(std::move(options));
        try {
            toys::oscillator(self, [&](double, double x) { ending.place = x; });
            self.finish();
            ending.well = true;
        } catch (sluice::Error const& e) {
            self.fail(e);
            ending.error = e.what();
            ending.exit = static_cast<int>(e.exit());
        }
    } catch (Killed const&) {
        ending.killed = true;
    }
    return ending;
}

std::pair<Ending, Ending> run_two(Line& line)
{
    auto const scene = [&] { return toys::two_masses("{connect: 1, silence: 0.5}"); };
    sluice::LoopbackHub hub(2);
    std::pair<Ending, Ending> endings;
    auto a = std::make_unique<Faulty>(hub.connect(0), line);
    auto b = std::make_unique<Faulty>(hub.connect(1), line);
    std::thread other([&] { endings.second = live(scene(), "right", std::move(b)); });
    endings.first = live(scene(), "left", std::move(a));
    other.join();
    return endings;
}

}  // namespace

TEST_CASE("nth message: broken off, damaged or its sender killed, at every one: success or one clear error, no hang")
{
    Line untouched{.at = -1, .fault = Fault::drop};
    auto const [left, right] = run_two(untouched);
    REQUIRE(left.error == "");
    REQUIRE(right.error == "");
    for (Fault const fault : {Fault::drop, Fault::damage, Fault::kill}) {
        std::int64_t n = 1;
        for (;; ++n) {
            Line line{.at = n, .fault = fault};
            auto const [l, r] = run_two(line);
            CAPTURE(n);
            CAPTURE(static_cast<int>(fault));
            for (auto const& [ending, right_place] : {std::pair{l, left.place}, std::pair{r, right.place}}) {
                if (ending.well) CHECK(ending.place == right_place);
                if (ending.well || ending.killed) continue;
                CHECK(ending.exit >= 3);
                CHECK(ending.exit <= 6);
                bool const named = ending.error.find("\"left\"") != std::string::npos ||
                                   ending.error.find("\"right\"") != std::string::npos;
                CHECK_MESSAGE(named, ending.error);
            }
            CHECK_FALSE((line.struck && l.well && r.well && fault == Fault::damage));  // it cannot go unnoticed
            if (!line.struck) {
                CHECK((l.well && r.well));
                break;
            }
            REQUIRE(n < 1000);
        }
        CHECK(n > 15);  // greetings, 5 windows' plans and frames each way, goodbyes
    }
}
