// Row F14 of the fault matrix, versions: one of two participants speaks another version of the wire's protocol.
#include <doctest/doctest.h>

#include <memory>
#include <thread>

#include "coupler/coupler.hpp"
#include "coupler/wire/message.hpp"
#include "tests/support/fault_row.hpp"
#include "tests/support/toys.hpp"

namespace {

//! The loopback transport of a participant of the next version: whole messages, with that version in their headers.
class Newer final : public sluice::Transport
{
 public:
    explicit Newer(std::unique_ptr<sluice::Transport> inner) : inner_(std::move(inner)) {}
    std::span<std::byte> reserve(int peer, std::size_t size) override { return room_ = inner_->reserve(peer, size); }
    bool commit(int peer, std::size_t size) override
    {
        sluice::Header header;
        std::memcpy(&header, room_.data(), sizeof header);
        header.version = sluice::protocol_version + 1;
        auto const message = sluice::encode(header, room_.subspan(sizeof header, size - sizeof header));
        std::memcpy(room_.data(), message.data(), size);
        return inner_->commit(peer, size);
    }
    std::optional<Incoming> receive(std::chrono::microseconds patience) override { return inner_->receive(patience); }
    bool lost(int peer) const override { return inner_->lost(peer); }
    std::string kind() const override { return inner_->kind(); }

 private:
    std::unique_ptr<sluice::Transport> inner_;
    std::span<std::byte> room_;
};

//! What a participant stops with.
sluice::Error live(std::string const& name, std::unique_ptr<sluice::Transport> transport)
{
    sluice::JoinOptions options;
    options.name = name;
    options.given = toys::two_masses("{connect: 20}");
    options.transport = std::move(transport);
    sluice::Participant self(std::move(options));
    try {
        toys::oscillator(self);
        self.finish();
    } catch (sluice::Error const& e) {
        self.fail(e);
        return e;
    }
    return sluice::Error("no error", sluice::Exit::ok);
}

}  // namespace

TEST_CASE("F14: partners with different versions: both print both versions")
{
    auto const other = std::to_string(sluice::protocol_version + 1), own = std::to_string(sluice::protocol_version);
    auto const versions = "protocol version " + other + " there, " + own + " here";
    sluice::test::Row row("F14", "another version on one side", {.brief = 5, .stated = 20});
    while (row.next()) {
        bool const first = row.round() % 2 == 0;
        sluice::LoopbackHub hub(2);
        auto a = hub.connect(0), b = hub.connect(1);
        (first ? a : b) = std::make_unique<Newer>(std::move(first ? a : b));
        sluice::Error right("");
        std::thread thread([&] { right = live("right", std::move(b)); });
        auto const left = live("left", std::move(a));
        thread.join();
        for (auto const& side : {left, right}) {
            CHECK((side.exit() == sluice::Exit::protocol || side.exit() == sluice::Exit::peer_died));
            CHECK_MESSAGE(std::string(side.what()).find(versions) != std::string::npos, side.what());
        }
    }
}
