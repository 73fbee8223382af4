//! A whole participant against a partner that says anything, in any order: its greeting, its plans and frames, right,
//! wrong, doubled, of another session, or nothing. It never computes before it has met its partner, its windows come in
//! order, and it sees only what right frames brought.
//!
//! Input: a byte (which of the two the participant is), then steps: a byte (which), and what the step reads.
#include <xxhash.h>

#include <nlohmann/json.hpp>

#include "coupler/base/ticks.hpp"
#include "coupler/coupler.hpp"
#include "coupler/scene/scene.hpp"
#include "coupler/transport/buffer.hpp"
#include "coupler/wire/message.hpp"
#include "tests/fuzz/target.hpp"

using namespace sluice;

namespace {

using std::chrono::milliseconds;

std::shared_ptr<LoadedScene const> the_scene()
{
    static auto const loaded = std::make_shared<LoadedScene const>(
        load_scene_text("sluice: 1\ntime: {end: 0.003, window: 0.001}\ntimeouts: {connect: 1}\n"
                        "data: {place: {columns: {place: {unit: m}}}}\n"
                        "participants: {a: {command: x}, b: {command: x}}\ncouplings:\n"
                        "  - {from: a, to: b, data: place}\n  - {from: b, to: a, data: place, lag: 1}\n",
                        "scene.yaml", {}));
    return loaded;
}

//! The bytes of an input, one after the other; zeros when they have run out.
class Input
{
 public:
    explicit Input(std::span<std::uint8_t const> bytes) : bytes_(bytes) {}
    bool more() const { return at_ < bytes_.size(); }
    std::uint8_t byte() { return more() ? bytes_[at_++] : std::uint8_t{0}; }
    std::string text()
    {
        std::string text(byte(), '\0');
        for (char& c : text) c = static_cast<char>(byte());
        return text;
    }

 private:
    std::span<std::uint8_t const> bytes_;
    std::size_t at_ = 0;
};

//! The partner, and the way to it. Its clock goes on by what the participant waits.
class Partner final : public Transport
{
 public:
    Partner(Input& input, int self) : input_(input), self_(self) {}

    std::span<std::byte> reserve(int, std::size_t size) override { return room_.room(size); }
    bool commit(int, std::size_t size) override
    {
        auto const message = std::span<std::byte const>(room_.data(), size);
        if (open_message(message, "self").kind != MessageKind::hello) return true;
        auto const hello = nlohmann::json::parse(text_of(message), nullptr, false);
        theirs_ = hello.value("nonce", std::uint64_t{0});
        return true;
    }
    std::optional<Incoming> receive(std::chrono::microseconds patience) override
    {
        if (!input_.more()) {
            now_ += std::max<std::chrono::microseconds>(patience, milliseconds(1));
            lost_ = true;
            return std::nullopt;
        }
        auto bytes = step();
        if (bytes.empty()) {
            now_ += std::max<std::chrono::microseconds>(patience, milliseconds(1));
            return std::nullopt;
        }
        last_ = bytes;
        note(bytes);
        auto const owner = std::make_shared<Bytes>(std::move(bytes));
        return Incoming{1 - self_, {*owner, owner}};
    }
    bool lost(int) const override { return lost_; }
    std::string kind() const override { return "fuzz"; }
    Clock::time_point now() const override { return now_; }

    bool greeted() const { return greeted_; }  //!< a right greeting that knows the participant's life has been read
    bool has_said(double value) const { return std::find(said_.begin(), said_.end(), value) != said_.end(); }

 private:
    std::string const& partner() const
    {
        return the_scene()->scene.participants[static_cast<std::size_t>(1 - self_)].name;
    }

    nlohmann::json greeting() const
    {
        Scene const& scene = the_scene()->scene;
        return {{"name", partner()},   {"process", 1},
                {"knows", theirs_},    {"nonce", nonce_},
                {"window", 0.0},       {"exact", false},
                {"can_store", false},  {"resumes", -1},
                {"scene", scene.hash}, {"canonical", scene.canonical}};
    }

    std::uint64_t session() const
    {
        std::uint64_t session = 0;
        for (int m : {0, 1}) {
            auto const nonce = m == self_ ? theirs_ : nonce_;
            session = XXH3_64bits_withSeed(&nonce, sizeof nonce, session);
        }
        return session;
    }

    Bytes step()
    {
        switch (input_.byte() % 11) {
            case 0:
                return encode_text({.kind = MessageKind::hello}, greeting().dump());
            case 1: {  // one entry of another kind or value
                auto hello = greeting();
                auto entry = hello.begin();
                std::advance(entry, input_.byte() % hello.size());
                auto const value = nlohmann::json::parse(input_.text(), nullptr, false);
                *entry = value.is_discarded() ? nlohmann::json(input_.byte()) : value;
                return encode_text({.kind = MessageKind::hello},
                                   hello.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
            }
            case 2:
                return encode_text({.kind = MessageKind::hello}, input_.text());
            case 3: {
                Header header{.kind = MessageKind::plan,
                              .session = session(),
                              .columns = planned_ == 2 ? 1u : 0u,
                              .frame = planned_,
                              .ticks = planned_ * ticks_per_window,
                              .points = static_cast<std::uint32_t>(ticks_per_window)};
                ++planned_;
                seal(header);
                auto const bytes = bytes_of(header);
                return {bytes.begin(), bytes.end()};
            }
            case 4: {
                double const value = input_.byte();
                std::int64_t const id = 1;
                std::span<double const> const column(&value, 1);
                Buffer buffer;
                auto const room = buffer.room(encoder_.bound(1));
                auto const size =
                    encoder_.encode({frame_, frame_ * ticks_per_window, 0, std::span(&id, 1), std::span(&column, 1)},
                                    session(), partner(), room);
                ++frame_;
                return {room.begin(), room.begin() + static_cast<std::ptrdiff_t>(size)};
            }
            case 5: {  // any message at all
                Header header{.kind = static_cast<MessageKind>(input_.byte() % 13)};
                header.session = std::array{session(), std::uint64_t{0}, ~session()}[input_.byte() % 3u];
                header.edge = input_.byte() % 4u;
                header.columns = input_.byte() * 0x01010101u;
                header.frame = input_.byte() - 8;
                header.ticks = (input_.byte() - 8) * ticks_per_window;
                header.points = input_.byte();
                header.iteration = input_.byte() % 3u;
                auto const body = input_.text();
                return encode(header, std::as_bytes(std::span(body)));
            }
            case 6: {
                Header header{.kind = MessageKind::bye, .session = session(), .frame = 3};
                seal(header);
                auto const bytes = bytes_of(header);
                return {bytes.begin(), bytes.end()};
            }
            case 7:
                lost_ = !lost_;
                return {};
            case 8:  // it is started again
                nonce_ += 1 + input_.byte();
                frame_ = planned_ = 0;
                encoder_.forget();
                return {};
            case 9:
                now_ += milliseconds(input_.byte());
                return {};
            default:
                return last_;
        }
    }

    //! What a right message says, whoever made it.
    void note(Bytes const& bytes)
    {
        Header header;
        std::memcpy(&header, bytes.data(), sizeof header);
        if (header.kind == MessageKind::frame)  // a body may be anything: its numbers, wherever they stand
            for (std::size_t at = sizeof header; at + sizeof(double) <= bytes.size(); ++at) {
                double value = 0;
                std::memcpy(&value, bytes.data() + at, sizeof value);
                said_.push_back(value);
            }
        if (header.kind != MessageKind::hello) return;
        auto const hello = nlohmann::json::parse(text_of(bytes), nullptr, false);
        if (!hello.is_object()) return;
        Scene const& scene = the_scene()->scene;
        auto const is = [&](char const* key, nlohmann::json const& value) {
            return hello.contains(key) && hello[key] == value;
        };
        if (is("name", partner()) && is("scene", scene.hash) && is("canonical", scene.canonical) &&
            is("knows", theirs_) && theirs_ != 0)
            greeted_ = true;
    }

    Input& input_;
    int self_;
    Buffer room_;
    FrameEncoder encoder_{the_scene()->scene.data[static_cast<std::size_t>(the_scene()->scene.edges[0].data)], 2,
                          static_cast<std::uint32_t>(self_ == 1 ? 0 : 1)};
    Clock::time_point now_{};
    std::uint64_t theirs_ = 0, nonce_ = 1000;
    std::int64_t frame_ = 0, planned_ = 0;
    bool lost_ = false, greeted_ = false;
    std::vector<double> said_;
    Bytes last_;
};

void solve(Participant& self, Partner const& partner, std::string const& other)
{
    auto keys = self.config();
    keys.finish();
    std::int64_t const id = 1;
    double value = 0;
    auto const tell = [&] { self.write(other, "place", std::span(&id, 1), {std::span<double const>(&value, 1)}); };
    tell();
    std::int64_t next = 0;
    for (Window const& window : self.windows()) {
        fuzz::demand(partner.greeted(), "nobody computes before the partner has said that it knows this life");
        fuzz::demand(window.index == next++ && window.index < 100, "windows come in order");
        auto const place = self.read(other, "place", window).columns(window.end)[0];
        for (double const x : place) fuzz::demand(partner.has_said(x), "what is read was said");
        value += 1;
        tell();
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    Input input({data, size});
    int const self = input.byte() & 1;
    auto transport = std::make_unique<Partner>(input, self);
    Partner const& partner = *transport;
    std::string const names[] = {"a", "b"};
    JoinOptions options;
    options.name = names[self];
    options.transport = std::move(transport);
    options.given = the_scene();
    std::optional<Participant> participant;
    try {
        participant.emplace(std::move(options));
        solve(*participant, partner, names[1 - self]);
        if (participant->finish() == 0) ++fuzz::accepted;
    } catch (Error const& error) {
        fuzz::demand(error.exit() != Exit::internal, "a partner's words are no bug of ours", error.what());
        if (participant) participant->fail(error);
    }
    return 0;
}
