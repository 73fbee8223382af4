#include "tests/bench/transport_way.hpp"

#include <chrono>
#include <cstring>
#include <stdexcept>
#include <string>

#include "coupler/transport/transport.hpp"

namespace bench {
namespace {

using sluice::Transport;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds longest_wait{60};
constexpr int settling_rounds = 200;  // 10 ms and more: by then shared memory has taken over from ZeroMQ

class TransportWay final : public Way
{
 public:
    TransportWay(Setting const& setting, std::unique_ptr<Transport> transport, std::string const& kind)
        : side_(setting.side), transport_(std::move(transport)), field_(setting.most_points)
    {
        for (int n = 0; n < settling_rounds; ++n) round_trip(1);
        if (transport_->kind() != kind) throw std::runtime_error("not " + kind + " but " + transport_->kind());
        transport_->settle();
    }

    void round_trip(std::size_t points) override
    {
        if (side_ == 0) send(points);
        receive(points);
        if (side_ == 1) send(points);
    }

    void wait_in_vain(double seconds) override
    {
        auto const end = Clock::now() + std::chrono::duration<double>(seconds);
        while (Clock::now() < end)
            if (transport_->receive(milliseconds(100))) throw std::runtime_error("a message that nobody sent");
    }

 private:
    void send(std::size_t points)
    {
        auto const bytes = field_.of(points);
        for (;;) {
            auto const room = transport_->reserve(1 - side_, bytes.size());
            if (room.size() >= bytes.size() && room.data()) {
                std::memcpy(room.data(), bytes.data(), bytes.size());
                break;
            }
            idle();
        }
        while (!transport_->commit(1 - side_, bytes.size())) idle();
    }

    void idle()
    {
        if (transport_->receive(milliseconds(1))) throw std::runtime_error("a message out of turn");
    }

    void receive(std::size_t points)
    {
        auto const deadline = Clock::now() + longest_wait;
        for (;;) {
            auto const incoming = transport_->receive(milliseconds(100));
            if (incoming && incoming->message.bytes.size() == points * point_size) return read(incoming->message.bytes);
            if (incoming || Clock::now() > deadline) throw std::runtime_error("not what was sent");
        }
    }

    void read(std::span<std::byte const> bytes)
    {
        for (std::size_t i = 0; i < bytes.size(); i += sizeof sum_) {
            std::uint64_t word = 0;
            std::memcpy(&word, bytes.data() + i, sizeof word);
            sum_ += word;
        }
        asm volatile("" : : "r"(sum_));  // somebody may use it
    }

    int side_;
    std::unique_ptr<Transport> transport_;
    Field field_;
    std::uint64_t sum_ = 0;
};

sluice::Members members(Setting const& setting)
{
    return {{"a", "b"}, setting.side};
}

}  // namespace

std::unique_ptr<Way> our_shm(Setting const& setting)
{
    auto const directory = setting.directory / "shm";
    return std::make_unique<TransportWay>(
        setting, sluice::make_shm_transport(members(setting), {.directory = directory}), "shm");
}

std::unique_ptr<Way> our_zmq_ipc(Setting const& setting)
{
    auto const directory = setting.directory / "zmq";
    return std::make_unique<TransportWay>(
        setting, sluice::make_zmq_transport(members(setting), {.directory = directory}), "zmq");
}

std::unique_ptr<Way> our_zmq_tcp(Setting const& setting)
{
    auto const address = "tcp://127.0.0.1:" + std::to_string(setting.port + 4);
    return std::make_unique<TransportWay>(setting, sluice::make_zmq_transport(members(setting), {.address = address}),
                                          "zmq");
}

std::unique_ptr<Way> our_mpi(Setting const& setting)
{
    return std::make_unique<TransportWay>(setting, sluice::make_mpi_transport(members(setting)), "mpi");
}

}  // namespace bench
