//! A whole participant against a partner that says anything, in any order: its greeting, its plans, frames, verdicts
//! and powers, right, wrong, doubled, of another session, or nothing. It never computes before it has met its partner,
//! its windows come in order, and it sees only what right frames brought.
//!
//! Input: a byte (which of the two the participant is, in which scene), then steps: a byte (which), and what the step
//! reads.
#include <xxhash.h>

#include <bit>
#include <charconv>
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

//! A scene, and what never changes in a greeting of one of its participants.
struct Case
{
    std::shared_ptr<LoadedScene const> loaded;
    bool grouped = false;
    std::string canonical = nlohmann::json(loaded->scene.canonical).dump();

    Scene const& scene() const { return loaded->scene; }
    Edge const& edge_from(int participant) const
    {
        auto const& edges = scene().edges;
        return edges[0].from == participant ? edges[0] : edges[1];
    }
    DataSpec const& data_from(int participant) const
    {
        return scene().data[static_cast<std::size_t>(edge_from(participant).data)];
    }
};

//! Two participants that only exchange; the same in an implicit group; and with books of energy in every window.
Case const& the_case(int which)
{
    auto const load = [](std::string const& there, std::string const& back, std::string const& more) {
        auto loaded = load_scene_text(
            "sluice: 1\ntime: {end: 0.003, window: 0.001}\ntimeouts: {connect: 1}\n"
            "data: {place: {columns: {place: {unit: m}}}}\n"
            "participants: {a: {command: x}, b: {command: x}}\ncouplings:\n"
            "  - {from: a, to: b, data: " +
                there + "}\n  - {from: b, to: a, data: " + back + ", lag: 1}\n" + more,
            "scene.yaml", {});
        loaded.scene.canonical = "a = 1\nb = 2\n";  // most of a greeting, and most of the work, but for its being short
        return std::make_shared<LoadedScene const>(std::move(loaded));
    };
    static Case const cases[] = {
        {load("place", "place", "")},
        {load("place", "place", "implicit: [{participants: [a, b], max_iterations: 5}]\n"), true},
        {load("kinematics", "load", "dimension: 2\nledger: {energy: {every: 1}}\n")}};
    return cases[which % 3];
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
    std::vector<double> numbers(std::size_t count)
    {
        std::vector<double> numbers(count);
        for (double& number : numbers) number = byte();
        return numbers;
    }

 private:
    std::span<std::uint8_t const> bytes_;
    std::size_t at_ = 0;
};

//! The partner, and the way to it. Its clock goes on by what the participant waits.
class Partner final : public Transport
{
 public:
    Partner(Case const& which, Input& input, int self) : case_(which), input_(input), self_(self) {}

    std::span<std::byte> reserve(int, std::size_t size) override { return room_.room(size); }
    bool commit(int, std::size_t size) override
    {
        auto const message = std::span<std::byte const>(room_.data(), size);
        if (open_message(message, "self").kind == MessageKind::hello) theirs_ = nonce_of(message);
        return true;
    }
    std::optional<Incoming> receive(std::chrono::microseconds patience) override
    {
        if (!input_.more()) {  // nothing will ever come: whatever has a deadline need not be asked many times
            now_ += std::chrono::hours(1);
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
    bool has_said(double value) const
    {
        return std::find(said_.begin(), said_.end(), std::bit_cast<std::uint64_t>(value)) != said_.end();
    }

 private:
    //! The entries of a greeting, as text; one that is empty is left out.
    static constexpr std::array keys{"can_store", "canonical", "exact", "knows",  "name", "nonce",
                                     "process",   "resumes",   "scene", "window", "box",  "columns"};
    using Entries = std::array<std::string, keys.size()>;

    std::string const& partner() const { return case_.scene().participants[static_cast<std::size_t>(1 - self_)].name; }

    //! Found in the text: reading all of it as JSON, again for each greeting, would be most of the work.
    static std::uint64_t nonce_of(std::span<std::byte const> message)
    {
        auto const text = text_of(message);
        constexpr std::string_view key = "\"nonce\":";
        auto const at = text.find(key);
        std::uint64_t nonce = 0;
        fuzz::demand(at != text.npos, "a greeting has a nonce", text);
        std::from_chars(text.data() + at + key.size(), text.data() + text.size(), nonce);
        return nonce;
    }

    Entries right() const
    {
        return {"false",
                case_.canonical,
                "false",
                std::to_string(theirs_),
                "\"" + partner() + "\"",
                std::to_string(nonce_),
                "1",
                "-1",
                std::to_string(case_.scene().hash),
                "0.0",
                "",
                ""};
    }

    static std::string greeting(Entries const& entries)
    {
        std::string text = "{";
        for (std::size_t k = 0; k < keys.size(); ++k)
            if (!entries[k].empty())
                text += (text.size() > 1 ? ",\"" : "\"") + std::string(keys[k]) + "\":" + entries[k];
        return text + "}";
    }

    //! An entry's number, and another value for it.
    std::pair<std::size_t, std::string> change()
    {
        std::size_t const entry = input_.byte() % keys.size();
        auto const value = input_.text();
        return {entry, nlohmann::json::accept(value) ? value : std::to_string(input_.byte())};
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

    Bytes frame(std::int64_t number, std::uint32_t iteration, double value)
    {
        auto const& columns = case_.data_from(1 - self_).columns;
        std::vector<std::int64_t> ids(points_);
        for (std::size_t i = 0; i < points_; ++i) ids[i] = static_cast<std::int64_t>(i + 1);
        std::vector<std::vector<double>> values;
        for (auto const& column : columns)
            values.emplace_back(points_ * static_cast<std::size_t>(components(column.shape, 2)), value);
        std::vector<std::span<double const>> const spans(values.begin(), values.end());
        Buffer buffer;
        auto const room = buffer.room(encoder_.bound(points_));
        auto const ticks = number * ticks_per_window;
        auto const size = encoder_.encode({number, ticks, iteration, ids, spans}, session(), partner(), room);
        return {room.begin(), room.begin() + static_cast<std::ptrdiff_t>(size)};
    }

    static Bytes sealed(Header header)
    {
        seal(header);
        auto const bytes = bytes_of(header);
        return {bytes.begin(), bytes.end()};
    }

    Bytes step()
    {
        switch (input_.byte() % 16) {
            case 0: {
                auto entries = right();
                for (std::size_t k = 0; k < keys.size(); ++k)
                    if (!changed_[k].empty()) entries[k] = changed_[k];
                return encode_text({.kind = MessageKind::hello}, greeting(entries));
            }
            case 1: {  // one entry of another kind or value
                auto entries = right();
                auto const [entry, value] = change();
                entries[entry] = value;
                return encode_text({.kind = MessageKind::hello}, greeting(entries));
            }
            case 2:
                return encode_text({.kind = MessageKind::hello}, input_.text());
            case 3: {
                auto const planned = planned_++;
                return sealed({.kind = MessageKind::plan,
                               .session = session(),
                               .columns = planned == 2 ? 1u : 0u,
                               .frame = planned,
                               .ticks = planned * ticks_per_window,
                               .points = static_cast<std::uint32_t>(ticks_per_window)});
            }
            case 4:
                iteration_ = 0;
                return frame(frame_++, 0, input_.byte());
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
            case 6:
                return sealed({.kind = MessageKind::bye, .session = session(), .frame = 3});
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
            case 11: {  // from now on it says something else of itself
                auto const [entry, value] = change();
                changed_[entry] = value;
                return {};
            }
            case 12:  // another iteration of the last window
                return frame(frame_ - 1, ++iteration_, input_.byte());
            case 13:  // from now on its frames have so many points
                points_ = input_.byte() % 4u;
                return {};
            case 14: {  // what it makes of the numbers that it iterates on: a summary of a block, see joint_step.cpp
                std::vector<double> said{0, 0, 2, 0, double(input_.byte()), double(input_.byte() % 4), 1};
                auto const sums = input_.numbers(6);
                auto const factor = input_.numbers(input_.byte() % 16u);
                said.insert(said.end(), sums.begin(), sums.end());
                said.insert(said.end(), factor.begin(), factor.end());
                said[1] = static_cast<double>(said.size() - 2);
                return encode(
                    {.kind = MessageKind::verdict, .session = session(), .frame = frame_ - 2, .iteration = iteration_},
                    std::as_bytes(std::span(said)));
            }
            case 15: {  // what its next frame gives
                auto const numbers = input_.numbers(input_.byte() % 8u);
                return encode({.kind = MessageKind::power,
                               .session = session(),
                               .edge = static_cast<std::uint32_t>(self_ == 1 ? 0 : 1),
                               .frame = frame_},
                              std::as_bytes(std::span(numbers)));
            }
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
            for (std::size_t at = sizeof header; at + sizeof(std::uint64_t) <= bytes.size(); ++at) {
                std::uint64_t value = 0;
                std::memcpy(&value, bytes.data() + at, sizeof value);
                said_.push_back(value);
            }
        if (header.kind != MessageKind::hello || greeted_ || theirs_ == 0) return;
        auto const text = text_of(bytes);
        if (text == greeting(right())) {
            greeted_ = true;
            return;
        }
        auto const hello = nlohmann::json::parse(text, nullptr, false);
        if (!hello.is_object()) return;
        auto const is = [&](char const* key, nlohmann::json const& value) {
            return hello.contains(key) && hello[key] == value;
        };
        if (is("name", partner()) && is("scene", case_.scene().hash) && is("canonical", case_.scene().canonical) &&
            is("knows", theirs_))
            greeted_ = true;
    }

    Case const& case_;
    Input& input_;
    int self_;
    Buffer room_;
    FrameEncoder encoder_{case_.data_from(1 - self_), 2, static_cast<std::uint32_t>(self_ == 1 ? 0 : 1)};
    Clock::time_point now_{};
    std::uint64_t theirs_ = 0, nonce_ = 1000;
    std::int64_t frame_ = 0, planned_ = 0;
    std::uint32_t iteration_ = 0;
    std::size_t points_ = 1;
    bool lost_ = false, greeted_ = false;
    std::vector<std::uint64_t> said_;  //!< bits, since a number may be none
    Entries changed_;
    Bytes last_;
};

void solve(Participant& self, Partner const& partner, Case const& which, int number)
{
    auto keys = self.config();
    keys.finish();
    auto const& other = which.scene().participants[static_cast<std::size_t>(1 - number)].name;
    auto const& to = which.data_from(number);
    auto const& from = which.data_from(1 - number);
    std::int64_t const id = 1;
    double value = 0;
    auto const tell = [&] {
        std::vector<double> const values(3, value);
        std::vector<std::span<double const>> columns;
        for (auto const& column : to.columns)
            columns.push_back(std::span(values).first(static_cast<std::size_t>(components(column.shape, 2))));
        self.write(other, to.name, std::span(&id, 1), columns);
    };
    if (which.grouped)
        self.keeps([&](State& state) { state.put_number("value", value); },
                   [&](State const& state) { value = state.number("value"); });
    tell();
    std::int64_t next = 0;
    int iteration = 0;
    bool const iterates_on_it = which.grouped && number == 0;  // it reads what no one has said yet
    for (Window const& window : self.windows()) {
        fuzz::demand(partner.greeted(), "nobody computes before the partner has said that it knows this life");
        fuzz::demand(window.index == next && window.index < 100, "windows come in order");
        fuzz::demand(window.iteration == iteration, "iterations come in order");
        auto samples = self.read(other, from.name, window);
        (void)samples.columns(window.begin);
        for (auto const& column : samples.columns(window.end))
            for (double const x : column) fuzz::demand(iterates_on_it || partner.has_said(x), "what is read was said");
        value += 1;
        tell();
        bool const stands = self.accepted(window);
        iteration = stands ? 0 : iteration + 1;
        next += stands;
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    Input input({data, size});
    auto const first = input.byte();
    int const self = first & 1;
    Case const& which = the_case(first >> 1);
    auto transport = std::make_unique<Partner>(which, input, self);
    Partner const& partner = *transport;
    JoinOptions options;
    options.name = which.scene().participants[static_cast<std::size_t>(self)].name;
    options.transport = std::move(transport);
    options.given = which.loaded;
    std::optional<Participant> participant;
    try {
        participant.emplace(std::move(options));
        solve(*participant, partner, which, self);
        if (participant->finish() == 0) ++fuzz::accepted;
    } catch (Error const& error) {
        fuzz::demand(error.exit() != Exit::internal, "a partner's words are no bug of ours", error.what());
        if (participant) participant->fail(error);
    }
    return 0;
}
